"""The vehicle's side of right of way: it drives only into places that it holds, and makes room for others."""

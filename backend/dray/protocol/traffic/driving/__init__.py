"""A vehicle drives only into what it holds, and makes room for others."""

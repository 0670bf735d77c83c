"""How a vehicle drives: alone on the floor, or with right of way."""

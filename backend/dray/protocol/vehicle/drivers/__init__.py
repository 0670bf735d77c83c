"""How a vehicle gets somewhere: alone on the floor, or with right of way."""

"""What is said about the floor: who may drive where, where one may stand, and what is closed, lies there, or was carried away."""

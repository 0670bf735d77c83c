"""For planning a plant: a first sketch, a picture, its capacity, and advice."""

"""For whoever plans a plant: a first sketch, a picture, how much it can move, and what is advised against."""

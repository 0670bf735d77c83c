"""What people have closed: the floor as one agent knows it."""

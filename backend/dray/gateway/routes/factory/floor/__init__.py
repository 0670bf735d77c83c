"""What people ask and say about the floor: closures, obstacles, waits, traffic, vehicles that were carried."""

"""Messages about the floor: right of way, dwell points, closures, obstacles, and vehicles that were carried away."""

"""The floor: closures, obstacles, waits, traffic, and carried vehicles."""

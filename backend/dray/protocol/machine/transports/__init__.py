"""The transports of one machine: announced, watched, handed over, and found again after a restart."""

"""A simulated vehicle: its ways and movement, its battery, and what it does where it stands."""

"""A simulated vehicle: its ways and movement, its battery, and its actions at a stand."""

"""Right of way between neighbours: the vehicles that may drive into a place, and those that make room."""

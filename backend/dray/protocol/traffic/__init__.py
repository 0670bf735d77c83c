"""Right of way between neighbours: who may drive into a place, and who makes room."""

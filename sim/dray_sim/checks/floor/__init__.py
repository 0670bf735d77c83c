"""Invariants of the floor: places, bodies, closed lanes, and what lies on lanes."""

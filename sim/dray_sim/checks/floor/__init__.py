"""Invariants of the floor: places, bodies, closed lanes, and obstacles on lanes."""

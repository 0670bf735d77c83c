"""Closures by people: the floor as one agent knows it."""

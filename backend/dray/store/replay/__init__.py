"""Recordings of the panels' view for replay, and the spells of every vehicle and machine."""

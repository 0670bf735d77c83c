"""Failure detection: which agents live, and which contractors make progress (paper, 3.2 and 4.2, cases 3 and 4).

Knows no vehicle.
"""

"""The machine agent (paper, 3.2 and 4.1)."""

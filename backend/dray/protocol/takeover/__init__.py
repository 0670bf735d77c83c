"""Failed carriers: the secondary, and what the coordinator does (paper, 4.2, cases 3 and 4)."""

"""Who lives, and who comes on with what it has promised (paper, 3.2 and 4.2, cases 3 and 4). Knows no vehicle."""

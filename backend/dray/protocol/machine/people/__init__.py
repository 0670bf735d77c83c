"""A machine and people: their commands, and its requests (paper, case 1)."""

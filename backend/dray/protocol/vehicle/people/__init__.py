"""A vehicle and people: their commands, and its requests (paper, cases 4 and 5)."""

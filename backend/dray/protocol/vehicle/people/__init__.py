"""A vehicle and people: what they tell it to do, and what it asks them for (paper, cases 4 and 5)."""

"""A machine and people: what they tell it to do, and what it asks them for (paper, case 1)."""

"""The strategist: orders become production goals (paper, 3.2 and 4.1)."""

"""Whose offers are believed: what cannot be, who has kept its promises, and who is on probation."""

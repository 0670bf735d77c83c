"""Whose offers are believed: plausibility, reliability and probation."""

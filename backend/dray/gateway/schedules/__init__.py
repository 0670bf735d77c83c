"""Recurring work: requests by a calendar, at most one for each moment."""

"""Recurring work: what is asked for by a calendar, at most once for each of its moments."""

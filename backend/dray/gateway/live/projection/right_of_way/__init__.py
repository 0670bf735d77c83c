"""Right of way as people see it: `chains` finds out who waits for whom in the end, `waits` keeps since when."""

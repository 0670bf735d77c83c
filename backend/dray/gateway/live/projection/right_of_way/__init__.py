"""Right of way as people see it: `chains` finds the end of each chain of waits, `waits` keeps since when."""

"""Processes with something simulated in them: `dray up`, the floor, customers, faults by hand, and their meters."""

"""Processes with simulated parts: `dray up`, the floor, customers, injected faults, and their meters."""

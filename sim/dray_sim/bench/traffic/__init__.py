"""Benchmark `traffic`: right of way on a lean floor, beside ghosts, first come and a planner that knows everything."""

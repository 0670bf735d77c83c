"""The factory's figures: fleet use, transport times, people's interventions, passages per lane.

All are sums over a `sliding_window`, at a cost that does not grow with time.
"""

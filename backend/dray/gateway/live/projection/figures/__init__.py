"""The factory's figures: use of the fleet, times of transports, interventions of people, passages per lane.

All are sums over a `sliding_window`, at a cost that does not grow with time.
"""

"""The simulated world: virtual time, a network, vehicles, workcells, and what can go wrong with them."""

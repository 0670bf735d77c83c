"""The cost of the bus: the simulated one, Zenoh on this computer, links and computers."""

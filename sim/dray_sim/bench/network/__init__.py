"""What the bus costs: the simulated one, Zenoh on this computer, links and computers."""

"""Metrics of what is in a process beside the gateway: agents, the simulated network, a place on the bus.

`factory` reads a whole simulated one, `agent` an agent that has a process of its own, `bus` a process's place
on the bus, `floor` the bodies of agents that are elsewhere. Names are the same wherever they come from, so that one board shows both.
"""

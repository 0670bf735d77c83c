"""What a process tells of itself: its log, its traces, and what it counts.

`agent_meter` reads an agent that has a process of its own, `bus_meter` a process's place on the bus, `clock_meter` how
its clock stands. What is simulated has its meters in `dray.cli.simulation`. Names are the same wherever figures come
from, so that one board shows all.
"""

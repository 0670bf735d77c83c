"""A process's telemetry: its log, its traces, and its metrics.

`agent_meter` reads an agent with its own process, `bus_meter` a process's connection to the bus, `clock_meter` its clock. Meters of
simulated parts are in `dray.cli.simulation`. Names do not depend on the source of the figures, so that one dashboard shows all.
"""

"""What people do about the factory, and its figures over time (paper, 4.2, cases 4 and 5, and the management panel).

`commands` to vehicles, `alerts` that somebody takes on, `exclusions` of agents, `fault_injection` and `scenario_play` where it is
simulated; `promises` and `figures`, which `figure_sampler` writes down minute by minute.
"""

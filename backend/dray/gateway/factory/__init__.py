"""People's actions on the factory, and its figures (paper, 4.2, cases 4 and 5, management panel).

`commands` to vehicles, `alerts` that people take on, `exclusions` of agents; `fault_injection` and
`scenario_play` in a simulated factory; `promises` and `figures`, which `figure_sampler` writes every minute.
"""

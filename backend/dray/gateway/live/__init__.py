"""The factory at this moment, as panels see it (paper, 3.2, visualization panel).

`peer` hears the agents, `projection` makes `views` of what they say, `visibility` says who is shown what,
`stream` sends it to browsers in `frames`, by `stream_scopes` of those who see the same. `backfill` and `database_sync`
read from SQL what nobody says on the bus; `health` and `strategist_probe` tell whether all of this works;
`timescale` turns the plant's clock into the wall's.
"""

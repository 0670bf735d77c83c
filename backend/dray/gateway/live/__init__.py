"""The factory at this moment, as panels see it (paper, 3.2, visualization panel).

`peer` hears the agents, `projection` turns their messages into `views`, `visibility` limits them per person.
`stream` sends them to browsers in `frames`; `stream_scopes` groups viewers who see the same. `backfill` and
`database_sync` read from SQL what is not on the bus; `health` and `strategist_probe` report whether all of
this works; `timescale` converts plant clock to wall clock.
"""

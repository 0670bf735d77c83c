"""A whole factory as processes on this computer.

`supervisor` implements `dray fleet up`: it prepares the `folder` of a fleet, lists its processes in `process_specs`, finds
`addresses` for them, and gives each a `process_supervisor`. The `process_registry` tells other commands which processes run,
by the birth of `processes` too. `control` lets other commands ask the supervisors, and `ending` ends remaining processes.

`rollout` replaces agents by those of another `software`.
"""

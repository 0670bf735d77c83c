"""A whole factory as processes on this computer.

`supervisor` is what `dray fleet up` does: it prepares the `folder` of a fleet, says in `process_specs` which processes
there are, finds `addresses` for them, and gives each a `process_supervisor`. The `process_registry` tells everybody else
who runs, by the birth of `processes` too; `control` lets other commands ask the supervisors, `ending` ends what is left.

`rollout` replaces agents by those of another `software`.
"""

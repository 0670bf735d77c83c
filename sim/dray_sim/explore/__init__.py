"""The search that tries to break it: random plants, loads and faults, one run per seed.

`run` draws what a seed stands for, out of a `profile` and with a `small_plant`; `play` plays it with all invariants
watched (`dray_sim.checks`), `search` does that for many seeds in many processes, `outcome` says what became of them, and
`story` what came before a violation.
"""

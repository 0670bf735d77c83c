"""The search that tries to break it: random plants, loads and faults, one run per seed.

`run` draws the run of a seed from a `profile` and with a `small_plant`; `play` plays it with all invariants watched
(`dray_sim.checks`), and `search` does that for many seeds in many processes. `outcome` holds the results, and `story`
tells the events before a violation. `ledger` keeps each played seed in a file, by the key of its code (`code_key`).
"""

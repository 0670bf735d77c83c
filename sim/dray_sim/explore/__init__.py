"""The search that tries to break it: random plants, loads and faults, one trial per seed.

`trial` draws what a seed stands for, `play` runs it with all invariants watched (`dray_sim.checks`), `search` does
that for many seeds in many processes, `outcome` says what became of them, and `story` what came before a violation.
"""

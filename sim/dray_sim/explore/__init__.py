"""The search that tries to break it: random plants, loads and faults, one trial per seed.

`trial` draws what a seed stands for, `play` runs it with all invariants watched, `calm` asks that
everything ends when the faults are over, `search` does that for many seeds in many processes, and
`story` tells what came before a violation.
"""

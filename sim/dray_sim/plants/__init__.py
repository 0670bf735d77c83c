"""Random plants: a generator that is independent of the default plant, and a judgement of their runs.

`lanes` draws halls and their lanes, and `draw` puts a factory on them. `play` runs it for some hours, and `judge`
names broken promises and whether they were foreseen.
"""

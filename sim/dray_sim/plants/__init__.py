"""Plants that nobody here has drawn: a generator that knows nothing of the default one, and a judge of what becomes of them.

`lanes` draws halls and their lanes, `draw` puts a factory on them, `play` lets it work for some hours, `judge` says what
was promised and not kept, and whether it was foreseen.
"""

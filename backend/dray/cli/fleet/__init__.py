"""A whole factory as processes on this computer.

`commands` is what a person types. `muster` starts a fleet: it prepares its `folder`, says in `posts` which
processes there are, finds `addresses` for them, and gives each a `keeper`. The `roll` tells everybody else who
runs, by the birth of `processes` too; `control` lets other commands ask the keepers, `ending` ends what is left.

`update` replaces agents by those of another `software`, one `replacement` after the other. A `listener` hears the
fleet's bus, a `judge` makes up his mind from that, the `books` have the `history` of what it has cost, and the
`report` tells it.
"""

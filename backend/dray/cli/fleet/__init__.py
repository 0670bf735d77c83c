"""A whole factory as processes on this computer.

`commands` is what a person types. `muster` starts a fleet: it prepares its `folder`, says in `posts` which
processes there are, and gives each a `keeper`. The `roll` tells everybody else who runs.
"""

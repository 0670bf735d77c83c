"""The published wire format: schemas and an AsyncAPI document for authors of other agents.

All of it is generated from the code (`dray wire write`), and a test compares it with `docs/wire`.
`compatibility` tells how a change would break agents of the last version.
"""

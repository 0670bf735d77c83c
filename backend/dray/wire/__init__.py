"""The wire, published: schemas and an AsyncAPI document for those who write agents of their own.

All of it is made from the code (`dray wire write`), and a test compares it with what is in `docs/wire`.
`compatibility` says what a change would break for agents of the last version.
"""

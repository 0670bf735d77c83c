"""Transports as their coordinator sees them, be it a machine or the station of a storage.

Whoever receives a load coordinates its transport, since it counts what is put down; goods on their way to a delivery warehouse, which
has no agent, are coordinated by the machine that made them.
"""

"""Transports as their coordinator sees them, be it a machine or the station of a storage.

The receiver of a load coordinates its transport, because it counts what is put down. A delivery warehouse has no
agent, so the machine that made the goods coordinates their transport there.
"""

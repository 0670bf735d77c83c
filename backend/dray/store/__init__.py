"""The store: what outlives a process, in SQL.

`tables` are the shapes. One repository per table or subject holds every query on it: `orders`, `access`, `history`,
`factory`. `database` opens, serialises and brings the tables up to date; `historian` writes what agents tell. Whoever
needs rows asks a `Store` for a `Work`, which is all repositories in one transaction.
"""

from __future__ import annotations

from dray.store.database.database import Database
from dray.store.database.migrate import downgrade, upgrade
from dray.store.historian import Historian
from dray.store.work import Store, Work, open_store

__all__ = ["Database", "Historian", "Store", "Work", "downgrade", "open_store", "upgrade"]

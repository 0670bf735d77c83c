"""The store: what outlives a process, in SQL.

`tables` are the shapes, one repository module per noun holds every query on it, `database` opens
and serialises, `migrate` brings the tables up to date, `historian` writes what agents tell. Whoever
needs rows asks a `Store` for a `Work`, which is one transaction.
"""

from __future__ import annotations

from dray.store.database import Database
from dray.store.historian import Historian
from dray.store.migrate import downgrade, upgrade
from dray.store.work import Store, Work, open_store

__all__ = ["Database", "Historian", "Store", "Work", "downgrade", "open_store", "upgrade"]

"""The store: durable data, in SQL.

`tables` defines the tables. One repository per table or subject contains all its queries: `orders`, `access`, `history`,
`factory`. `database` opens the database, serialises transactions and migrates the tables. `historian` writes what agents report.
A caller gets a `Work` from a `Store`: all repositories in one transaction.
"""

from __future__ import annotations

from dray.store.database.database import Database
from dray.store.database.migrate import downgrade, upgrade
from dray.store.historian import Historian
from dray.store.work import Store, Work, open_store

__all__ = ["Database", "Historian", "Store", "Work", "downgrade", "open_store", "upgrade"]

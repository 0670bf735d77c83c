"""Insertion: new rows of several tables, written at once.

The statements are written once and handed to the driver as they are. PostgreSQL gets one for all tables, with the rows
of each as a JSON array, so that it is gone to once; SQLite is at hand, and gets one for each table.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import msgspec
from sqlalchemy import Connection, Table

Rows = Sequence[Mapping[str, object]]
"""By the names of columns; those that a database counts by itself are left out."""


class Insertion:
    """Writes new rows of some tables.

    Args:
        tables: those that others refer to come first.
    """

    def __init__(self, *tables: Table) -> None:
        self._for_postgresql = _one_statement(tables)
        self._for_sqlite = [_statement(table) for table in tables]

    def write(self, connection: Connection, rows: Sequence[Rows]) -> None:
        """Write them.

        Args:
            connection: in a transaction.
            rows: of each of the tables, perhaps none.
        """
        if connection.dialect.name == "postgresql":
            arrays = tuple(msgspec.json.encode(each).decode() for each in rows)
            connection.exec_driver_sql(self._for_postgresql, arrays)
            return
        for statement, each in zip(self._for_sqlite, rows, strict=True):
            if each:
                connection.exec_driver_sql(statement, list(map(dict, each)))


def _columns(table: Table) -> list[str]:
    return [column.name for column in table.columns if column.autoincrement is not True]


def _statement(table: Table) -> str:
    columns = _columns(table)
    values = ", ".join(f":{name}" for name in columns)
    return f"INSERT INTO {table.name} ({', '.join(columns)}) VALUES ({values})"  # noqa: S608 - of our own names


def _one_statement(tables: Sequence[Table]) -> str:
    """Foreign keys are looked at when all of it is done."""
    each = [
        f"INSERT INTO {table.name} ({columns}) SELECT {columns} "  # noqa: S608 - of our own names
        f"FROM json_populate_recordset(NULL::{table.name}, ${place}::text::json)"
        for place, table in enumerate(tables, 1)
        for columns in [", ".join(_columns(table))]
    ]
    *before, last = each
    named = ", ".join(f"written_{place} AS ({statement})" for place, statement in enumerate(before))
    return f"WITH {named} {last}" if named else last

"""Insertion: new rows of several tables, written at once.

The statements are built once and passed directly to the driver. PostgreSQL gets one for all tables, with each table's rows
as a JSON array: this needs one round trip, even for the whole transaction where wanted. SQLite is local, and gets one statement
per table.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

import msgspec
from sqlalchemy import Column, Connection, Table

from dray.store.database.dialect import AtOnce
from dray.store.database.postgresql import WRITERS

T = TypeVar("T")

Rows = Sequence[Mapping[str, object]]
"""Rows by column names; columns that the database numbers are left out."""


class Insertion:
    """Writes new rows of some tables.

    Args:
        tables: referenced tables come first.
        once: a unique column of one of them: `at_once` writes nothing when one of its values exists.
    """

    def __init__(self, *tables: Table, once: Column[Any]) -> None:
        self._for_postgresql = _one_statement(tables)
        self._at_once = _one_transaction(tables, once)
        self._for_sqlite = [_statement(table) for table in tables]

    def write(self, connection: Connection, rows: Sequence[Rows]) -> None:
        """Write the rows.

        Args:
            connection: in a transaction.
            rows: for each of the tables, possibly none.
        """
        if connection.dialect.name == "postgresql":
            connection.exec_driver_sql(self._for_postgresql, _arrays(rows))
            return
        for statement, each in zip(self._for_sqlite, rows, strict=True):
            if each:
                connection.exec_driver_sql(statement, list(map(dict, each)))

    def at_once(self, rows: Sequence[Rows], values: Sequence[str], done: T) -> AtOnce[T]:
        """One statement for PostgreSQL that is its own transaction and writes the rows, if all of them are new.

        Args:
            rows: as `write`.
            values: the values of the column `once`.
            done: the result when they are written.
        """
        return AtOnce(self._at_once, (*_arrays(rows), list(values)), done)


def _arrays(rows: Sequence[Rows]) -> tuple[str, ...]:
    return tuple(msgspec.json.encode(each).decode() for each in rows)


def _columns(table: Table) -> list[str]:
    return [column.name for column in table.columns if column.autoincrement is not True]


def _statement(table: Table) -> str:
    columns = _columns(table)
    values = ", ".join(f":{name}" for name in columns)
    return f"INSERT INTO {table.name} ({', '.join(columns)}) VALUES ({values})"  # noqa: S608 - of our own names


def _one_statement(tables: Sequence[Table]) -> str:
    """Foreign keys are checked at the end of the statement."""
    *before, last = (_from_array(table, place) for place, table in enumerate(tables, 1))
    return f"WITH {_named(before)} {last}" if before else last


def _one_transaction(tables: Sequence[Table], once: Column[Any]) -> str:
    """All rows are written under the writers' lock; unique keys detect rows committed during the wait."""
    known = f"SELECT FROM {once.table} WHERE {once.name} = ANY(${len(tables) + 1}::text[])"
    return (
        f"WITH turn AS MATERIALIZED (SELECT pg_advisory_xact_lock({WRITERS})), "  # noqa: S608 - of our own names
        f"free AS MATERIALIZED (SELECT FROM turn WHERE NOT EXISTS ({known})), "
        + _named([_from_array(table, place, "free, ") for place, table in enumerate(tables, 1)])
        + " SELECT EXISTS (SELECT FROM free)"
    )


def _from_array(table: Table, place: int, before: str = "") -> str:
    columns = ", ".join(_columns(table))
    return (
        f"INSERT INTO {table.name} ({columns}) SELECT {columns} "  # noqa: S608 - of our own names
        f"FROM {before}json_populate_recordset(NULL::{table.name}, ${place}::text::json)"
    )


def _named(statements: Sequence[str]) -> str:
    return ", ".join(f"written_{place} AS ({statement})" for place, statement in enumerate(statements))

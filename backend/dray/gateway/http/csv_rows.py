"""Rows of CSV that people send: read up to a bound, with every fault named by its row. Pure.

Whoever sends a file chooses what is in it. So the work grows no faster than the file, and what is no list of the right kind is
given up as soon as that is known: at the first row too many, and at a first row that is too wide.
"""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice

import msgspec

from dray.gateway.http.problems import MAX_FIELD_ERRORS, FieldError, Problem, unusable

MAX_ROWS = 1_000
"""Rows of one file: what a person can still look through; they are all taken at once."""

MAX_COLUMNS = 64
"""Cells of the first row: several times the columns that there are. To name each column of what is wider as unknown would help
nobody."""

Row = tuple[int, dict[str, str]]
"""As a spreadsheet counts it, and its cells by column."""


class RowFault(msgspec.Struct, frozen=True):
    """What is wrong in one row."""

    row: int
    """As a spreadsheet counts: the names of the columns are row 1."""
    column: str
    """Empty for the row as a whole."""
    reason: str
    """What is wrong, and what to do."""
    code: str = ""
    """The same for programs (`http.fault_codes`); empty where it has none."""
    values: dict[str, str] = {}
    """What is filled in."""

    @classmethod
    def of(cls, row: int, column: str, code: str, /, **values: object) -> RowFault:
        """A fault that has a code."""
        return cls.at(row, column, FieldError.of(column, code, **values))

    @classmethod
    def at(cls, row: int, column: str, error: FieldError) -> RowFault:
        """A fault of a field, where it stands in the file."""
        return cls(row, column, error.reason, error.code, error.values)


def refusal(faults: Sequence[RowFault]) -> Problem:
    """Refuses a file as a whole for what is wrong in its rows."""
    named = (
        FieldError(f"row {fault.row}, {fault.column}".rstrip(", "), fault.reason, fault.code, fault.values)
        for fault in faults
    )
    return unusable(*islice(named, MAX_FIELD_ERRORS))


def read_rows(text: str, columns: Sequence[str], needed: Sequence[str]) -> tuple[list[Row], list[RowFault]]:
    """Read a file whose first row names its columns.

    Args:
        text: of the file.
        columns: those that it may have.
        needed: those that it must have.

    Returns:
        Its rows, and none where anything is wrong with it.
    """
    text = text.removeprefix("\ufeff")
    head = text.partition("\n")[0]
    # Where a comma stands in numbers, spreadsheets write semicolons between cells.
    reader = csv.reader(io.StringIO(text), delimiter=";" if head.count(";") > head.count(",") else ",")
    try:
        # The names of the columns, the rows, and one more, which tells that there are too many.
        rows = list(islice(_filled(reader), MAX_ROWS + 2))
    except csv.Error as error:
        return [], [RowFault.of(reader.line_num, "", "csv_unreadable", why=error)]
    if not rows:
        return [], [RowFault.of(1, "", "csv_empty", columns=", ".join(columns))]
    (_, names), *lines = rows
    if len(names) > MAX_COLUMNS:
        return [], [RowFault.of(1, "", "csv_too_wide", count=len(names), columns=", ".join(columns))]
    header = [name.strip().lower() for name in names]
    faults = list(_wrong_header(header, columns, needed))
    if len(lines) > MAX_ROWS:
        faults.append(RowFault.of(lines[MAX_ROWS][0], "", "csv_too_many_rows", most=MAX_ROWS))
    if not lines:
        faults.append(RowFault.of(1, "", "csv_no_rows"))
    if faults:
        return [], faults
    return [
        (row, dict(zip(header, (cell.strip() for cell in cells), strict=False))) for row, cells in lines
    ], []


def number(text: str) -> int | str:
    """What a cell says, where it is a whole number; else the cell, for who refuses it."""
    return int(text) if text.isascii() and text.isdigit() and len(text) < 10 else text


def _filled(rows: Iterable[list[str]]) -> Iterator[tuple[int, list[str]]]:
    """The rows with something in them, and as which a spreadsheet counts them."""
    return ((row, cells) for row, cells in enumerate(rows, 1) if any(cell.strip() for cell in cells))


def _wrong_header(header: list[str], columns: Sequence[str], needed: Sequence[str]) -> Iterator[RowFault]:
    times = Counter(header)
    for name in needed:
        if name not in times:
            yield RowFault.of(1, name, "column_missing")
    for name in header:
        if name not in columns:
            yield RowFault.of(1, name, "column_unknown", columns=", ".join(columns))
        elif times[name] > 1:
            yield RowFault.of(1, name, "column_twice")

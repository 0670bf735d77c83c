"""Orders out of a spreadsheet: rows of CSV read as drafts, with every fault named by its row. Pure.

Whoever sends a file chooses what is in it. So the work grows no faster than the file, and what is no list of
orders is given up as soon as that is known: at the first row too many, and at a first row that is too wide.

The first row names the columns. Rows that follow one another with the same customer and reference are the
items of one order; a row without a reference is an order of its own.
"""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from itertools import groupby, islice
from typing import Any

import msgspec
from pydantic import ValidationError

from dray.gateway.http.problems import FieldError, field_error
from dray.gateway.orders.drafts import MAX_ITEMS, OrderDraft

COLUMNS = ("customer", "reference", "product", "quantity", "due_at", "release")

NEEDED = ("customer", "product", "quantity")

MAX_ROWS = 1_000
"""Rows of one file: what a person can still look through; they are all placed at once."""

MAX_COLUMNS = 64
"""Cells of the first row: ten times the columns that there are. What is wider is no list of orders, and to name
each of its columns as unknown would help nobody."""

WORDS = {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False}
"""What may stand in `release`."""


class RowFault(msgspec.Struct, frozen=True):
    """What is wrong in one row."""

    row: int
    """As a spreadsheet counts: the names of the columns are row 1."""
    column: str
    """Empty for the row as a whole."""
    reason: str


class ReadOrder(msgspec.Struct, frozen=True):
    """One order, and the row with which it begins."""

    row: int
    draft: OrderDraft


def read_orders(text: str) -> tuple[list[ReadOrder], list[RowFault]]:
    """Read a file.

    Returns:
        The orders whose rows have the right shape, and what is wrong with the others.
    """
    text = text.removeprefix("\ufeff")
    head = text.partition("\n")[0]
    # Where a comma stands in numbers, spreadsheets write semicolons between cells.
    reader = csv.reader(io.StringIO(text), delimiter=";" if head.count(";") > head.count(",") else ",")
    try:
        # The names of the columns, the rows, and one more, which tells that there are too many.
        rows = list(islice(_filled(reader), MAX_ROWS + 2))
    except csv.Error as error:
        return [], [RowFault(reader.line_num, "", f"this is no CSV: {error}")]
    if not rows:
        return [], [RowFault(1, "", f"there is nothing in it; begin with {', '.join(COLUMNS)}")]
    (_, names), *lines = rows
    if len(names) > MAX_COLUMNS:
        reason = f"it has {len(names)} columns; there are {', '.join(COLUMNS)}"
        return [], [RowFault(1, "", reason)]
    header = [name.strip().lower() for name in names]
    faults = list(_wrong_header(header))
    if len(lines) > MAX_ROWS:
        faults.append(RowFault(lines[MAX_ROWS][0], "", f"a file has {MAX_ROWS} rows at most; cut it in two"))
    if not lines:
        faults.append(RowFault(1, "", "there is no row below the names of the columns"))
    if faults:
        return [], faults
    orders: list[ReadOrder] = []
    cells_of = [
        (row, dict(zip(header, (cell.strip() for cell in cells), strict=False))) for row, cells in lines
    ]
    for _, group in groupby(cells_of, _order_of):
        members = list(group)
        wrong = list(_differing(members))
        try:
            draft = OrderDraft.model_validate(_draft([cells for _, cells in members]))
        except ValidationError as error:
            wrong += [place(field_error(fault), members[0][0]) for fault in error.errors()]
        else:
            if not wrong:
                orders.append(ReadOrder(members[0][0], draft))
        faults += wrong
    return orders, faults


def place(error: FieldError, row: int) -> RowFault:
    """Where in a file something is wrong that was found in the draft that begins at `row`."""
    first, _, column = error.field.rpartition(".")
    index = int(first[6:-1]) if first.startswith("items[") else 0
    return RowFault(row + index, column or first, error.reason)


def _filled(rows: Iterable[list[str]]) -> Iterator[tuple[int, list[str]]]:
    """The rows with something in them, and as which a spreadsheet counts them."""
    return ((row, cells) for row, cells in enumerate(rows, 1) if any(cell.strip() for cell in cells))


def _wrong_header(header: list[str]) -> Iterator[RowFault]:
    times = Counter(header)
    for name in NEEDED:
        if name not in times:
            yield RowFault(1, name, "this column is missing")
    for name in header:
        if name not in COLUMNS:
            yield RowFault(1, name, f"there is no such column; there are {', '.join(COLUMNS)}")
        elif times[name] > 1:
            yield RowFault(1, name, "this column is there more than once")


def _order_of(line: tuple[int, Mapping[str, str]]) -> tuple[str, str, int]:
    row, cells = line
    reference = cells.get("reference", "")
    return cells.get("customer", ""), reference, 0 if reference else row


def _differing(members: list[tuple[int, dict[str, str]]]) -> Iterator[RowFault]:
    """What stands in every row of an order, and is of the whole order."""
    (first_row, first), *others = members
    for row, cells in others:
        for column in ("due_at", "release"):
            if cells.get(column, "") != first.get(column, ""):
                yield RowFault(row, column, f"it is of the same order as row {first_row}; write the same")
    if len(members) > MAX_ITEMS:
        yield RowFault(members[MAX_ITEMS][0], "", f"an order has {MAX_ITEMS} items at most")


def _draft(rows: list[dict[str, str]]) -> dict[str, Any]:
    first = rows[0]
    draft: dict[str, Any] = {
        "customer": first.get("customer", ""),
        "items": [
            {"product": cells.get("product", ""), "quantity": _number(cells.get("quantity", ""))}
            for cells in rows
        ],
    }
    for name in ("reference", "due_at"):
        if first.get(name):
            draft[name] = first[name]
    if release := first.get("release"):
        draft["release"] = WORDS.get(release.lower(), release)
    return draft


def _number(text: str) -> int | str:
    return int(text) if text.isascii() and text.isdigit() and len(text) < 10 else text

"""Orders out of a spreadsheet: rows of CSV read as drafts, with every fault named by its row. Pure.

Rows that follow one another with the same customer and reference are the items of one order; a row without a reference is an
order of its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Any

import msgspec
from pydantic import ValidationError

from dray.gateway.http.csv_rows import Row, RowFault, number, read_rows
from dray.gateway.http.problems import FieldError, field_error
from dray.gateway.orders.drafts import MAX_ITEMS, OrderDraft
from dray.store.orders.orders import Referred

COLUMNS = ("customer", "reference", "product", "quantity", "due_at", "priority", "release")

NEEDED = ("customer", "product", "quantity")

WORDS = {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False}
"""What may stand in `release`."""


class ReadOrder(msgspec.Struct, frozen=True):
    """One order, and the row with which it begins."""

    row: int
    draft: OrderDraft


def read_orders(text: str) -> tuple[list[ReadOrder], list[RowFault]]:
    """Read a file.

    Returns:
        The orders whose rows have the right shape, and what is wrong with the others.
    """
    rows, faults = read_rows(text, COLUMNS, NEEDED)
    orders: list[ReadOrder] = []
    for _, group in groupby(rows, _order_of):
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
    return RowFault.at(row + index, column or first, error)


def twice_in_file(orders: Sequence[ReadOrder]) -> list[RowFault]:
    """Orders that have the customer and reference of another one further up in the file."""
    hints: list[RowFault] = []
    first_rows: dict[tuple[str, str], int] = {}
    for each in orders:
        if (reference := each.draft.reference) is None:
            continue
        first = first_rows.setdefault((each.draft.customer, reference), each.row)
        if first != each.row:
            hints.append(RowFault.of(each.row, "reference", "in_file_already", row=first))
    return hints


def placed_already(orders: Sequence[ReadOrder], lately: Sequence[Referred], now_s: float) -> list[RowFault]:
    """Orders that have the customer and reference of one that was placed a short while ago.

    Args:
        orders: of the file.
        lately: orders that were placed, oldest first.
        now_s: wall clock.
    """
    placed = {(order.customer, order.reference): order for order in lately}
    hints = []
    for each in orders:
        draft = each.draft
        if draft.reference is None or (known := placed.get((draft.customer, draft.reference))) is None:
            continue
        minutes = max(0, round((now_s - known.created_at_s) / 60.0))
        values = {"customer": draft.customer, "order": known.id, "minutes": minutes}
        hints.append(RowFault.of(each.row, "reference", "placed_already", **values))
    return hints


def _order_of(line: Row) -> tuple[str, str, int]:
    row, cells = line
    reference = cells.get("reference", "")
    return cells.get("customer", ""), reference, 0 if reference else row


def _differing(members: list[Row]) -> Iterator[RowFault]:
    """What stands in every row of an order, and is of the whole order."""
    (first_row, first), *others = members
    for row, cells in others:
        for column in ("due_at", "priority", "release"):
            if cells.get(column, "") != first.get(column, ""):
                yield RowFault.of(row, column, "differs_in_order", row=first_row)
    if len(members) > MAX_ITEMS:
        yield RowFault.of(members[MAX_ITEMS][0], "", "too_many_items", most=MAX_ITEMS)


def _draft(rows: list[dict[str, str]]) -> dict[str, Any]:
    first = rows[0]
    draft: dict[str, Any] = {
        "customer": first.get("customer", ""),
        "items": [
            {"product": cells.get("product", ""), "quantity": number(cells.get("quantity", ""))}
            for cells in rows
        ],
    }
    for name in ("reference", "due_at"):
        if first.get(name):
            draft[name] = first[name]
    if priority := first.get("priority"):
        draft["priority"] = priority.lower()
    if release := first.get("release"):
        draft["release"] = WORDS.get(release.lower(), release)
    return draft

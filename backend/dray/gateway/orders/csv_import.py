"""Orders from a spreadsheet: CSV rows read as drafts, with every fault named by its row. Pure.

Successive rows with the same customer and reference are the items of one order; a row without a reference is
an order of its own.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any

import msgspec
from pydantic import ValidationError

from dray.gateway.http.csv_rows import Row, RowFault, first_by_row, number, read_rows, text_of_file
from dray.gateway.http.problems import FieldError, field_error
from dray.gateway.http.request_bodies import RowsFile
from dray.gateway.http.unread import read
from dray.gateway.orders.drafts import MAX_ITEMS, OrderDraft, nonsense

if TYPE_CHECKING:
    # A side process would take a second to load SQL's packages.
    from dray.store.orders.orders import Referred

COLUMNS = ("customer", "reference", "product", "quantity", "due_at", "priority", "release")

NEEDED = ("customer", "product", "quantity")

WORDS = {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False}
"""Values allowed in `release`."""


class ReadOrder(msgspec.Struct, frozen=True):
    """One order and its first row."""

    row: int
    draft: OrderDraft


class ReadFile(msgspec.Struct, frozen=True):
    """A file of orders as read."""

    dry_run: bool
    orders: list[ReadOrder] = []
    faults: list[RowFault] = []
    """Faults of form, by row; at most `MAX_FIELD_ERRORS`."""
    senseless: list[RowFault] = []
    """Faults of content here or now, likewise. They do not matter for a file that was answered before."""
    hints: list[RowFault] = []
    """Oddities; as many."""


def read_file(body: bytes, products: Collection[str], now_s: float) -> ReadFile:
    """Read a request with a file. Slow: run as side work.

    Args:
        body: a `RowsFile`.
        products: ids of the products that can be ordered.
        now_s: the wall clock, for checking due times.

    Raises:
        Problem: the body has another shape, or no file.
    """
    request = read(RowsFile, body)
    file = text_of_file(request.csv, request.base64)
    if file.faults:
        return ReadFile(request.dry_run, faults=file.faults)
    orders, faults = read_orders(file.text)
    senseless = [place(error, each.row) for each in orders for error in nonsense(each.draft, products, now_s)]
    return ReadFile(
        request.dry_run,
        orders,
        faults=first_by_row(faults),
        senseless=first_by_row(senseless),
        hints=first_by_row([*file.hints, *twice_in_file(orders)]),
    )


def read_orders(text: str) -> tuple[list[ReadOrder], list[RowFault]]:
    """Read a file.

    Returns:
        The orders of valid rows, and the faults of the others.
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
    """A fault of the draft that begins at `row`, with its place in the file."""
    first, _, column = error.field.rpartition(".")
    index = int(first[6:-1]) if first.startswith("items[") else 0
    return RowFault.at(row + index, column or first, error)


def twice_in_file(orders: Sequence[ReadOrder]) -> list[RowFault]:
    """Orders that repeat a customer and reference from further up in the file."""
    hints: list[RowFault] = []
    first_rows: dict[tuple[str, str], int] = {}
    for each in orders:
        if (reference := each.draft.reference) is None:
            continue
        first = first_rows.setdefault((each.draft.customer, reference), each.row)
        if first != each.row:
            hints.append(RowFault.of(each.row, "reference", "in_file_already", row=first))
    return hints


def placed_already(
    orders: Sequence[ReadOrder], lately: Sequence[Referred], now_s: float
) -> Iterator[RowFault]:
    """Orders that repeat the customer and reference of one placed lately, by row.

    Args:
        orders: the orders of the file.
        lately: recent orders; within a reference oldest first.
        now_s: wall clock.
    """
    placed = {(order.customer, order.reference): order for order in lately}
    for each in orders:
        draft = each.draft
        if draft.reference is None or (known := placed.get((draft.customer, draft.reference))) is None:
            continue
        yield RowFault.of(each.row, "reference", "placed_already", **known.values(now_s))


def _order_of(line: Row) -> tuple[str, str, int]:
    row, cells = line
    reference = cells.get("reference", "")
    return cells.get("customer", ""), reference, 0 if reference else row


def _differing(members: list[Row]) -> Iterator[RowFault]:
    """Faults of rows that contradict the first row of their order."""
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
            {"product": cells.get("product", "")}
            | ({"quantity": number(quantity)} if (quantity := cells.get("quantity", "")) else {})
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

"""Products from a spreadsheet: CSV rows read as drafts, with every fault named by its row. Pure.

Successive rows with the same product are one product. Each may name one line of its bill (`material`,
`pieces`), one machine (`machine`, `cycle_s`) and one document; data of the whole product is in the first row,
and optional below.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from itertools import groupby
from typing import Any

import msgspec
from pydantic import ValidationError

from dray.gateway.http.csv_rows import Row, RowFault, number, read_rows
from dray.gateway.http.fault_codes import WORDS
from dray.gateway.http.problems import FieldError, field_error
from dray.gateway.products.drafts import ID, ProductDraft

WHOLE = ("name", "lot", "ability")
"""Columns about the whole product."""

DOCUMENT = ("document", "address", "media_type", "sha256")

COLUMNS = ("product", *WHOLE, "material", "pieces", "machine", "cycle_s", *DOCUMENT)

NEEDED = ("product", "name", "lot", "material", "pieces")

OF_AMOUNTS = frozenset({"missing", "whole_number", "number", "at_least", "at_most", "machine_own_time"})
"""Codes of faults in a part's number, not in its name."""

_DECIMAL = re.compile(r"\d{1,9}([.,]\d{1,6})?")


class ReadProduct(msgspec.Struct, frozen=True):
    """One product of a file, with the rows of its parts."""

    id: str
    draft: ProductDraft
    row: int
    rows: dict[str, int]
    """Row per field of the draft, as `bill.shaft`."""

    def place(self, error: FieldError) -> RowFault:
        """A fault of the draft, with its place in the file."""
        return _place(error, self.row, self.rows)


def read_products(text: str) -> tuple[list[ReadProduct], list[RowFault]]:
    """Read a file.

    Returns:
        The products of valid rows, and the faults of the others.
    """
    rows, faults = read_rows(text, COLUMNS, NEEDED)
    products: list[ReadProduct] = []
    first_rows: dict[str, int] = {}
    for id_, group in groupby(rows, lambda row: row[1].get("product", "")):
        members = list(group)
        first = members[0][0]
        wrong = list(_differing(members))
        if not re.match(ID, id_):
            wrong.append(RowFault.of(first, "product", "bad_id"))
        elif id_ in first_rows:
            begins = first_rows[id_]
            wrong.append(RowFault.of(first, "product", "begins_already", product=id_, row=begins))
        first_rows.setdefault(id_, first)
        fields, places, twice = _draft(members)
        wrong += twice
        try:
            draft = ProductDraft.model_validate(fields)
        except ValidationError as error:
            wrong += [_place(_of_cell(fault), first, places) for fault in error.errors()]
        else:
            if not wrong:
                products.append(ReadProduct(id_, draft, first, places))
        faults += wrong
    return products, faults


def _of_cell(fault: Mapping[str, Any]) -> FieldError:
    """A fault of the draft; an empty cell is missing, whatever it should have held."""
    error = field_error(fault)
    if fault.get("input", "") is None:
        return FieldError(error.field, WORDS["missing"], "missing")
    return error


def _place(error: FieldError, first: int, rows: dict[str, int]) -> RowFault:
    head, _, rest = error.field.partition(".")
    if (place := f"{head}.{rest.removesuffix('.[key]')}") in rows:
        names, amounts = {"bill": ("material", "pieces"), "machines": ("machine", "cycle_s")}[head]
        return RowFault.at(rows[place], amounts if error.code in OF_AMOUNTS else names, error)
    if numbered := re.match(r"bill\[(\d+)\]", error.field):
        lines = [row for field, row in rows.items() if field.startswith("bill.")]
        return RowFault.at(lines[int(numbered[1])], "material", error)
    if numbered := re.match(r"documents\[(\d+)\]", error.field):
        row = rows.get(f"documents.{numbered[1]}", first)
        return RowFault.at(row, {"name": "document"}.get(rest, rest) or "document", error)
    column = {"bill": "material", "machines": "machine", "documents": "document"}.get(head, head)
    return RowFault.at(first, column if column in COLUMNS else "", error)


def _differing(members: list[Row]) -> Iterator[RowFault]:
    """Faults of later rows that contradict the first on the whole product."""
    (first_row, first), *others = members
    for row, cells in others:
        for column in WHOLE:
            if cells.get(column, "") not in ("", first.get(column, "")):
                yield RowFault.of(row, column, "differs_in_product", row=first_row)


def _draft(members: list[Row]) -> tuple[dict[str, Any], dict[str, int], list[RowFault]]:
    """The fields of a draft, the row of each part, and faults of repeated parts."""
    first = members[0][1]
    bill: dict[str, Any] = {}
    machines: dict[str, Any] = {}
    documents: list[dict[str, str]] = []
    rows: dict[str, int] = {}
    twice: list[RowFault] = []
    for row, cells in members:
        for column, amount, parts, kind in (
            ("material", number(cells.get("pieces", "")), bill, "bill"),
            ("machine", _decimal(cells.get("cycle_s", "")), machines, "machines"),
        ):
            if name := cells.get(column, ""):
                if name in parts:
                    known = rows[f"{kind}.{name}"]
                    twice.append(RowFault.of(row, column, "stands_already", name=name, row=known))
                # None is reported as a missing number.
                parts[name] = None if amount == "" else amount
                rows.setdefault(f"{kind}.{name}", row)
        if any(cells.get(column) for column in DOCUMENT):
            rows[f"documents.{len(documents)}"] = row
            document = {column: cells.get(column, "") for column in DOCUMENT}
            documents.append({"name": document.pop("document"), **document})
    fields: dict[str, Any] = {
        "name": first.get("name", ""),
        "bill": bill,
        "machines": machines,
        "documents": documents,
    }
    if lot := first.get("lot"):
        fields["lot"] = number(lot)
    if first.get("ability"):
        fields["ability"] = first["ability"]
    return fields, rows, twice


def _decimal(text: str) -> float | str:
    return float(text.replace(",", ".")) if _DECIMAL.fullmatch(text) else text

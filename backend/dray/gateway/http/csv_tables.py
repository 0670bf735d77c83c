"""Tables for spreadsheets: streamed CSV in which no cell is a formula.

Spreadsheets read text that begins with `=`, `+`, `-` or `@` as a formula, by any author. Such text gets an
apostrophe in front, which they read as "this is text" (OWASP, CSV injection). In some countries they split
cells at semicolons or tabs and ignore our quotes. So a sign after one of these inside a cell gets an
apostrophe too.
"""

from __future__ import annotations

import asyncio
import csv
import io
import logging
import re
from collections.abc import AsyncIterable, AsyncIterator, Iterable, Sequence
from typing import Annotated, Any, Literal

import msgspec
from fastapi import Query
from fastapi.responses import StreamingResponse

from dray.gateway.http.responses import iso

_log = logging.getLogger(__name__)

CUT_SHORT = "error: this table was cut short and is not whole. Ask for it again."
"""Last row of a table that was cut short, since the status was sent long before."""

BATCH = 50
"""Rows after which other work gets a turn: a fast client would otherwise take the whole event loop."""

_FORMULA = re.compile(
    r"""
    (^ | [;\t\r\n])              # where a cell begins, for whatever program
    (?=
        [\s"\u200b\ufeff]*       # what some skip
        [=+\-@＝＋－＠﹢﹣﹦﹫−]    # what a formula begins with, in the widths in which it may be written
        | [\t\r]                  # skipped by some, at the beginning of the whole
    )
    """,  # noqa: RUF001 - that they look alike is why they are here
    re.VERBOSE,
)

_NUMBER = re.compile(r"-?\d+(\.\d+)?")

Row = Sequence[object]

Format = Annotated[
    Literal["json", "csv"], Query(description="`csv` for a spreadsheet: all of it, in one table")
]
"""A router's parameter."""


def with_csv(answer: dict[str, Any]) -> dict[str, Any]:
    """The OpenAPI answer with a table as a second format."""
    return answer | {"content": answer["content"] | {"text/csv": {"schema": {"type": "string"}}}}


def table(name: str, header: Row, rows: Iterable[Row] | AsyncIterable[Row]) -> StreamingResponse:
    """Answer with a table, streamed line by line.

    Args:
        name: name of the file without its extension.
        header: names of the columns.
        rows: cells; None is an empty one.
    """
    headers = {"Content-Disposition": f'attachment; filename="{name}.csv"'}
    return StreamingResponse(_written(header, rows), media_type="text/csv", headers=headers)


def header_of(fields: Sequence[str]) -> Row:
    """Column names for `row_of`; ISO 8601 times have no unit."""
    return [name.removesuffix("_s") if name.endswith("at_s") else name for name in fields]


def row_of(fields: Sequence[str], values: msgspec.Struct) -> Row:
    """Some fields of a struct as cells.

    Fields named `*_at_s` are written in ISO 8601; fractions with four decimals, other floats with one.
    """
    return [_readable(name, getattr(values, name)) for name in fields]


def line(cells: Row) -> str:
    """One line of CSV."""
    text = io.StringIO()
    csv.writer(text).writerow([_harmless(cell) for cell in cells])
    return text.getvalue()


async def _written(header: Row, rows: Iterable[Row] | AsyncIterable[Row]) -> AsyncIterator[str]:
    yield line(header)
    try:
        written = 0
        async for row in rows if isinstance(rows, AsyncIterable) else _each(rows):
            yield line(row)
            written += 1
            if written % BATCH == 0:
                await asyncio.sleep(0)
    except Exception:
        _log.exception("a table could not be written to its end")
        yield line([CUT_SHORT])
        # The client then sees that the answer is incomplete.
        raise


async def _each(rows: Iterable[Row]) -> AsyncIterator[Row]:
    for row in rows:
        yield row


def _readable(name: str, value: object) -> object:
    if not isinstance(value, float):
        return value
    if name.endswith("at_s"):
        return iso(value)
    return f"{value:.4f}" if name.endswith(("_frac", "_ratio")) else f"{value:.1f}"


def _harmless(cell: object) -> object:
    if isinstance(cell, str) and not _NUMBER.fullmatch(cell):
        return _FORMULA.sub(r"\1'", cell)
    return cell

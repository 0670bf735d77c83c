"""Tables for spreadsheets: CSV that streams, and in which no cell is a formula.

A program that opens the file takes text that begins with `=`, `+`, `-` or `@` for a formula, whoever has
written it; such text gets an apostrophe in front, which these programs take for "this is text" (OWASP, CSV
injection). In some countries they part cells at semicolons, or at tabs, and do not see then what is in quotes
for us: so a sign that follows one of these inside of a cell gets an apostrophe, too.
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
"""The last row of a table that could not be written to its end: the status was sent long before."""

BATCH = 100
"""Rows after which others have a turn of the event loop: who takes them as fast as they come would have it alone."""

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
    """How OpenAPI tells of an answer that also comes as a table."""
    return answer | {"content": answer["content"] | {"text/csv": {"schema": {"type": "string"}}}}


def table(name: str, header: Row, rows: Iterable[Row] | AsyncIterable[Row]) -> StreamingResponse:
    """Answer with a table, line by line as its rows come.

    Args:
        name: of the file, without its ending.
        header: names of the columns.
        rows: cells; None is an empty one.
    """
    headers = {"Content-Disposition": f'attachment; filename="{name}.csv"'}
    return StreamingResponse(_written(header, rows), media_type="text/csv", headers=headers)


def header_of(fields: Sequence[str]) -> Row:
    """Names of columns for `row_of`: a moment that is written in ISO 8601 is in no unit."""
    return [name.removesuffix("_s") if name.endswith("at_s") else name for name in fields]


def row_of(fields: Sequence[str], values: msgspec.Struct) -> Row:
    """Some fields of a struct as cells.

    Moments, whose names end in `_at_s`, are written in ISO 8601; fractions with four decimals, and other
    numbers that may have some with one.
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
        # Whoever reads to the end of the answer learns that it has none.
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

"""Rows of CSV that people send: read up to a bound, with every fault named by its row. Pure.

Whoever sends a file chooses what is in it. So the work grows no faster than the file, and what is no list of the right kind is
given up as soon as that is known: at the first row too many, and at a first row that is too wide.
"""

from __future__ import annotations

import base64
import csv
import io
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice

import msgspec

from dray.gateway.http.problems import MAX_FIELD_ERRORS, FieldError, Problem, unusable
from dray.messages.base import encodable
from dray.plant.file.text_encoding import LOST, UnknownEncodingError, decode_text

MAX_ROWS = 1_000
"""Rows of one file: what a person can still look through; they are all taken at once."""

MAX_COLUMNS = 64
"""Cells of the first row: several times the columns that there are. To name each column of what is wider as unknown would help
nobody."""

SEPARATORS = (",", ";", "\t", "|")
"""Between cells. Where a comma stands in numbers, spreadsheets write semicolons."""

_DIRECTIVE = re.compile(r'\s*"?sep=(.)"?[,;\t| ]*(\r\n|\r|\n|$)', re.IGNORECASE)
"""The first line of a file by which a spreadsheet is told its separator; the spreadsheet does not count it as a row."""

_CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f]")

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


def first_by_row(faults: Iterable[RowFault]) -> list[RowFault]:
    """Those that are told of a file: the first `MAX_FIELD_ERRORS`."""
    return sorted(faults, key=lambda fault: fault.row)[:MAX_FIELD_ERRORS]


class FileText(msgspec.Struct, frozen=True):
    """A file as it came."""

    text: str
    faults: list[RowFault] = []
    """Why there is no text of it."""
    hints: list[RowFault] = []
    """What is to be known of how it was read."""


def text_of_file(text: str | None, packed: str | None) -> FileText:
    """The text of a file.

    Args:
        text: as the caller has read it; None if it sends the file itself.
        packed: the file in base64.

    Raises:
        Problem: there is no file, or more than one.
    """
    if (text is None) == (packed is None):
        raise unusable(FieldError.of("csv", "file_needed"))
    if packed is None:
        return FileText(encodable(text or ""))
    try:
        content = base64.b64decode(packed, validate=True)
    except ValueError:
        raise unusable(FieldError.of("base64", "no_base64")) from None
    try:
        decoded = decode_text(content)
    except UnknownEncodingError:
        return FileText("", faults=[RowFault.of(1, "", "csv_encoding")])
    read_as = [RowFault.of(1, "", "csv_read_as", encoding=decoded.encoding)] if decoded.assumed else []
    return FileText(encodable(decoded.text), hints=read_as)


def read_rows(text: str, columns: Sequence[str], needed: Sequence[str]) -> tuple[list[Row], list[RowFault]]:
    """Read a file whose first row names its columns.

    Args:
        text: of the file.
        columns: those that it may have.
        needed: those that it must have.

    Returns:
        Its rows, and none where anything is wrong with it.
    """
    text, told = _without_directive(text.removeprefix("\ufeff"))
    # Some spreadsheets end lines with CR alone, which csv takes for no end of a line.
    lines_of_text = io.StringIO(text, newline=None)
    reader = csv.reader(lines_of_text, delimiter=_separator(text, told, columns))
    read: list[tuple[int, list[str]]] = []
    try:
        # The names of the columns, the rows, and one more, which tells that there are too many.
        read.extend(islice(_filled(reader), MAX_ROWS + 2))
    except csv.Error:
        row = read[-1][0] + 1 if read else 1
        return [], [RowFault.of(row, "", "csv_cell_too_long", most=csv.field_size_limit())]
    if not read:
        return [], [RowFault.of(1, "", "csv_empty", columns=", ".join(columns))]
    (_, names), *lines = read
    header = [name.strip().lower() for name in names]
    while header and not header[-1]:
        header.pop()
    if len(header) > MAX_COLUMNS:
        return [], [RowFault.of(1, "", "csv_too_wide", count=len(header), columns=", ".join(columns))]
    faults = list(_wrong_header(header, columns, needed))
    if len(lines) > MAX_ROWS:
        faults.append(RowFault.of(lines[MAX_ROWS][0], "", "csv_too_many_rows", most=MAX_ROWS))
    if not lines:
        faults.append(RowFault.of(1, "", "csv_no_rows"))
    if faults:
        return [], faults
    for row, cells in lines:
        faults += _wrong_cells(row, cells, header)
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
    for number, name in enumerate(header, 1):
        if not name:
            yield RowFault.of(1, "", "column_unnamed", number=number)
        elif name not in columns:
            yield RowFault.of(1, name, "column_unknown", columns=", ".join(columns))
        elif times[name] > 1:
            yield RowFault.of(1, name, "column_twice")


def _without_directive(text: str) -> tuple[str, str]:
    """The text without a line `sep=;`, and the separator that it names; empty for none."""
    if found := _DIRECTIVE.match(text):
        return text[found.end() :], found[1]
    return text, ""


def _separator(text: str, told: str, columns: Sequence[str]) -> str:
    """What stands between cells: the one that finds most names of columns, the file's own word first."""
    head = re.split(r"[\r\n]", text.lstrip("\r\n"), maxsplit=1)[0].lower()

    def known(separator: str) -> tuple[int, int]:
        cells = [cell.strip(' "') for cell in head.split(separator)]
        return sum(cell in columns for cell in cells), head.count(separator)

    candidates = dict.fromkeys((told, *SEPARATORS) if told and told not in '"\r\n' else SEPARATORS)
    # The first of equals is taken.
    return max(candidates, key=known)


def _wrong_cells(row: int, cells: Sequence[str], header: Sequence[str]) -> Iterator[RowFault]:
    """What no text in a cell may be, and what is no cell of a column."""
    if any(cell.strip() for cell in cells[len(header) :]):
        yield RowFault.of(row, "", "csv_row_too_wide", count=len(cells), columns=len(header))
        return
    for name, cell in zip(header, cells, strict=False):
        if LOST in cell:
            yield RowFault.of(row, name, "csv_lost_character")
        elif _CONTROL.search(cell):
            yield RowFault.of(row, name, "csv_control_character")
        elif "\n" in cell.strip():
            yield RowFault.of(row, name, "csv_cell_of_lines", count=cell.count("\n") + 1)

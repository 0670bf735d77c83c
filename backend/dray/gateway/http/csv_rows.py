"""CSV rows from people: read up to a bound, with every fault named by its row. Pure.

The content is up to the sender. So the work grows no faster than the file, and a file of the wrong kind is
rejected as early as possible: at the first row too many, or at too wide a first row.
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
"""Maximum rows per file: as many as a person can check; all are taken at once."""

MAX_COLUMNS = 64
"""Maximum cells of the first row: several times the known columns. Naming more columns as unknown would help
nobody."""

SEPARATORS = (",", ";", "\t", "|")
"""Separators of cells. Where numbers use a decimal comma, spreadsheets write semicolons."""

_DIRECTIVE = re.compile(r'\s*"?sep=(.)"?[,;\t| ]*(\r\n|\r|\n|$)', re.IGNORECASE)
"""A first line that tells a spreadsheet the separator; spreadsheets do not count it as a row."""

WORKBOOKS = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")
"""First bytes of workbooks: packed XML (.xlsx, .ods), and the format before (.xls)."""

_AROUND = re.compile(r"^[\s\u00ad\u200b-\u200f\u2060\ufeff]+|[\s\u00ad\u200b-\u200f\u2060\ufeff]+$")
"""Blanks around a cell, and characters without width, which come with what is copied from pages and documents."""

_CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f]")

_WHOLE = re.compile(r"-?[0-9]{1,9}")

Row = tuple[int, dict[str, str]]
"""Row number as in a spreadsheet, and its cells by column."""


class RowFault(msgspec.Struct, frozen=True):
    """A fault in one row."""

    row: int
    """Row number as in a spreadsheet: the column names are row 1."""
    column: str
    """Column; empty for the whole row."""
    reason: str
    """What is wrong, and what to do."""
    code: str = ""
    """Code of the reason (`http.fault_codes`); empty if it has none."""
    values: dict[str, str] = {}
    """Values for the reason."""

    @classmethod
    def of(cls, row: int, column: str, code: str, /, **values: object) -> RowFault:
        """A fault with a code."""
        return cls.at(row, column, FieldError.of(column, code, **values))

    @classmethod
    def at(cls, row: int, column: str, error: FieldError) -> RowFault:
        """A fault of a field, with its place in the file."""
        return cls(row, column, error.reason, error.code, error.values)


def refusal(faults: Sequence[RowFault]) -> Problem:
    """The problem that refuses a whole file for faults in its rows."""
    named = (
        FieldError(f"row {fault.row}, {fault.column}".rstrip(", "), fault.reason, fault.code, fault.values)
        for fault in faults
    )
    return unusable(*islice(named, MAX_FIELD_ERRORS))


def first_by_row(faults: Iterable[RowFault]) -> list[RowFault]:
    """The faults to report: the first `MAX_FIELD_ERRORS` by row."""
    return sorted(faults, key=lambda fault: fault.row)[:MAX_FIELD_ERRORS]


class FileText(msgspec.Struct, frozen=True):
    """A file as text."""

    text: str
    faults: list[RowFault] = []
    """Reasons why it has no text."""
    hints: list[RowFault] = []
    """Notes on how it was read."""


def text_of_file(text: str | None, packed: str | None) -> FileText:
    """The text of a file.

    Args:
        text: the text, as read by the caller; None if the caller sends the file itself.
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
    if content.startswith(WORKBOOKS):
        return FileText("", faults=[RowFault.of(1, "", "csv_workbook")])
    try:
        decoded = decode_text(content)
    except UnknownEncodingError:
        return FileText("", faults=[RowFault.of(1, "", "csv_encoding")])
    read_as = [RowFault.of(1, "", "csv_read_as", encoding=decoded.encoding)] if decoded.assumed else []
    return FileText(encodable(decoded.text), hints=read_as)


def read_rows(text: str, columns: Sequence[str], needed: Sequence[str]) -> tuple[list[Row], list[RowFault]]:
    """Read a file whose first row has the column names.

    Args:
        text: text of the file.
        columns: allowed columns.
        needed: required columns.

    Returns:
        Its rows and its faults; no rows if there is any fault.
    """
    text, told = _without_directive(text.removeprefix("\ufeff"))
    # Some spreadsheets end lines with a single CR, which csv does not accept.
    lines_of_text = io.StringIO(text, newline=None)
    reader = csv.reader(lines_of_text, delimiter=_separator(text, told, columns))
    read: list[tuple[int, list[str]]] = []
    try:
        # Column names, rows, and one more row, which shows that there are too many.
        read.extend(islice(_filled(reader), MAX_ROWS + 2))
    except csv.Error:
        row = read[-1][0] + 1 if read else 1
        return [], [RowFault.of(row, "", "csv_cell_too_long", most=csv.field_size_limit())]
    if not read:
        return [], [RowFault.of(1, "", "csv_empty", columns=", ".join(columns))]
    (_, names), *lines = read
    header = [_AROUND.sub("", name).lower() for name in names]
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
        (row, dict(zip(header, (_AROUND.sub("", cell) for cell in cells), strict=False)))
        for row, cells in lines
    ], []


def number(text: str) -> int | str:
    """The whole number in a cell; else the cell itself, to be refused later."""
    return int(text) if _WHOLE.fullmatch(text) else text


def _filled(rows: Iterable[list[str]]) -> Iterator[tuple[int, list[str]]]:
    """Rows that are not empty, with their numbers as in a spreadsheet."""
    return ((row, cells) for row, cells in enumerate(rows, 1) if any(cell.strip() for cell in cells))


def _wrong_header(header: list[str], columns: Sequence[str], needed: Sequence[str]) -> Iterator[RowFault]:
    times = Counter(header)
    damaged = {name: _CONTROL.sub("", name) for name in header if _CONTROL.search(name)}
    for name in needed:
        if name not in times and name not in damaged.values():
            yield RowFault.of(1, name, "column_missing")
    for number, name in enumerate(header, 1):
        if name in damaged:
            yield RowFault.of(1, damaged[name], "csv_control_character")
        elif not name:
            yield RowFault.of(1, "", "column_unnamed", number=number)
        elif name not in columns:
            yield RowFault.of(1, name, "column_unknown", columns=", ".join(columns))
        elif times[name] > 1:
            yield RowFault.of(1, name, "column_twice")


def _without_directive(text: str) -> tuple[str, str]:
    """The text without a line `sep=;`, and the separator named there; empty without one."""
    if found := _DIRECTIVE.match(text):
        return text[found.end() :], found[1]
    return text, ""


def _separator(text: str, told: str, columns: Sequence[str]) -> str:
    """The separator that finds most column names, the file's own first."""
    head = re.split(r"[\r\n]", text.lstrip("\r\n"), maxsplit=1)[0].lower()

    def known(separator: str) -> tuple[int, int]:
        cells = [cell.strip(' "') for cell in head.split(separator)]
        return sum(cell in columns for cell in cells), head.count(separator)

    candidates = dict.fromkeys((told, *SEPARATORS) if told and told not in '"\r\n' else SEPARATORS)
    # The first maximum wins.
    return max(candidates, key=known)


def _wrong_cells(row: int, cells: Sequence[str], header: Sequence[str]) -> Iterator[RowFault]:
    """Faults of a row's cells: forbidden characters, or more cells than columns."""
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

"""Common parts of commands: tables, JSON files, choices by name."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TypeVar

import msgspec
from rich import box
from rich.console import Console
from rich.table import Table

from dray.adapters.vda5050.dialogue import Line
from dray.errors import SettingsError, UnavailableError

T = TypeVar("T")

FILE_WIDTH = 120
"""Columns of a table in a file or a pipe: the width of a code review."""


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Print a table on stdout; the first column never wraps."""
    shown = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for index, title in enumerate(head):
        shown.add_column(title, no_wrap=index == 0)
    for row in rows:
        shown.add_row(*row)
    console = Console()
    if not console.is_terminal:
        console.width = FILE_WIDTH
    console.print(shown)


def one_of(choices: Mapping[str, T], name: str, kind: str) -> T:
    """The choice of this name.

    Raises:
        SettingsError: there is none; lists the choices.
    """
    if name not in choices:
        raise SettingsError(kind, f"there is no {name!r}; choose one of {', '.join(choices)}")
    return choices[name]


def line_text(line: Line) -> str:
    """A line of a vehicle's dialogue, for people."""
    arrow = "->" if line.effect else "<-"
    fields = msgspec.json.encode(line.fields).decode() if line.fields else line.text
    return f"{line.at_s:12.2f} {arrow} {line.effect or line.event:10} {line.about:14} {fields[:200]}".rstrip()


def check_writable(file: Path, option: str) -> None:
    """Check the file of an option before a long computation, and leave it as it is.

    Raises:
        UnavailableError: it cannot be written.
    """
    folder = file.parent
    if not folder.is_dir():
        reason = f"there is no folder {folder}"
    elif file.is_dir():
        reason = "it is a folder"
    elif not os.access(file if file.exists() else folder, os.W_OK):
        reason = "it may not be written"
    else:
        return
    raise UnavailableError(str(file), reason, f"choose another file for {option}")


def write_json(file: Path, content: object) -> None:
    """Write JSON for people and machines; see `write_text`."""
    write_text(file, msgspec.json.format(msgspec.json.encode(content), indent=2).decode() + "\n")


def write_text(file: Path, text: str, option: str = "--json") -> None:
    """Write a file that an option names.

    Raises:
        UnavailableError: writing failed.
    """
    try:
        file.write_text(text, encoding="utf-8")
    except OSError as error:
        reason = error.strerror or str(error)
        raise UnavailableError(str(file), reason, f"choose another file for {option}") from None

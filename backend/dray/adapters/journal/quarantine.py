"""Quarantine: a damaged database file is moved aside, so that its owner can start without it and people can inspect it."""

from __future__ import annotations

import re
import time
from pathlib import Path

from dray.adapters.journal.lives import flush_folder

KEPT = 3
"""Maximum damaged files kept per name, the newest: some 5 MB each. A disk that damages files repeatedly must not be
filled by them."""

DAMAGED = ".damaged-"
"""The separator between the old name and the time."""

COMPANIONS = ("", "-wal", "-shm")
"""Suffixes of the files that SQLite writes; without them the file is incomplete."""


def set_aside(file: Path) -> Path:
    """Move a SQLite file and its companions to a name with the present time.

    The file goes first: SQLite deletes companions of a missing file.

    Returns:
        The new name.

    Raises:
        OSError: moving failed.
    """
    before = _set_aside_before(file)
    number = int(before[-1].name.rpartition("-")[2]) + 1 if before else 1
    stamp = time.strftime("%Y%m%dT%H%M%SZ", time.gmtime())
    aside = file.with_name(f"{file.name}{DAMAGED}{stamp}-{number}")
    for end in COMPANIONS:
        part = file.with_name(file.name + end)
        if end == "" or part.exists():
            part.rename(aside.with_name(aside.name + end))
    flush_folder(file.parent)
    for old in [*before, aside][:-KEPT]:
        for end in COMPANIONS:
            old.with_name(old.name + end).unlink(missing_ok=True)
    return aside


def _set_aside_before(file: Path) -> list[Path]:
    """Damaged files of this name, in the order of their numbers: clocks may have been changed between them."""
    numbered = re.compile(re.escape(f"{file.name}{DAMAGED}") + r"\w+-(\d{1,9})")
    found = [(numbered.fullmatch(each.name), each) for each in file.parent.iterdir()]
    return [each for _, each in sorted((int(match[1]), each) for match, each in found if match)]

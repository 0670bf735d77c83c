"""The count of an agent's starts, in a small file beside its journal, so that a lost journal loses no life.

The count is part of the names of an agent's tasks and goals, and of its events' numbers. An agent's latest life
prevails. So it must never fall, even if the journal is lost. Every start replaces the whole file. The file shows
whether it is complete.
"""

from __future__ import annotations

import contextlib
import os
import time
from pathlib import Path
from zlib import crc32


class Lives:
    """The count of one agent's lives.

    Args:
        file: the file; it need not exist.

    Attributes:
        count: 0 without a file; None for a damaged one.

    Raises:
        OSError: the path is no file, or may not be read.
    """

    def __init__(self, file: Path) -> None:
        self._file = file
        self.count: int | None
        try:
            self.count = _read(file.read_text(encoding="utf-8"))
        except FileNotFoundError:
            self.count = 0
        except ValueError:
            self.count = None

    def next(self, journal: int) -> int:
        """The number of a new life.

        Args:
            journal: the last life's number in the journal; 0 when unknown.
        """
        if self.count is None and not journal:
            # Unix time in seconds: no agent has ever been started once a second.
            return int(time.time())
        return max(self.count or 0, journal) + 1

    def write(self, count: int) -> None:
        """Replace the file; the number is on the disk when the call returns.

        Raises:
            OSError: writing failed.
        """
        self.count = count
        new = self._file.with_name(f"{self._file.name}.new")
        with new.open("w", encoding="utf-8") as file:
            file.write(f"{count} {crc32(str(count).encode()):08x}\n")
            file.flush()
            os.fsync(file.fileno())
        new.replace(self._file)
        flush_folder(self._file.parent)


def flush_folder(folder: Path) -> None:
    """Make renames in a folder survive a power failure, where the system supports it."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _read(text: str) -> int:
    """The number in the file.

    Raises:
        ValueError: the file is damaged.
    """
    count, _, checksum = text.rstrip("\n").partition(" ")
    if checksum != f"{crc32(count.encode()):08x}":
        raise ValueError(f"a torn number of lives: {text[:80]!r}")
    return int(count)

"""How often an agent has been started, in a small file beside its journal, so that a lost journal loses no life.

The number marks the names of an agent's tasks and goals and the numbers of its events, and a later life of an
agent is the one that counts. So it must never fall, whatever becomes of the journal. The file is replaced as a
whole at every start, and says whether it is whole.
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
        file: where it is kept; it need not be there.

    Attributes:
        count: 0 when there is no such file; None when there is one that is not whole.

    Raises:
        OSError: there is something that is no file, or may not be read.
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
        """The number of a life that begins now.

        Args:
            journal: the number of the last one by the journal; 0 when that does not know.
        """
        if self.count is None and not journal:
            # Unix time in seconds: no agent has ever been started once a second.
            return int(time.time())
        return max(self.count or 0, journal) + 1

    def write(self, count: int) -> None:
        """Replace the file; the number is on the disk when the call returns.

        Raises:
            OSError: that cannot be done.
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
    """See to it that what was renamed in a folder outlives a power failure, where the system can do so."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _read(text: str) -> int:
    """The number.

    Raises:
        ValueError: it is not whole.
    """
    count, _, checksum = text.rstrip("\n").partition(" ")
    if checksum != f"{crc32(count.encode()):08x}":
        raise ValueError(f"a torn number of lives: {text[:80]!r}")
    return int(count)

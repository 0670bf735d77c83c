"""A process that writes lines: a caller can wait for a line, and its complaints are kept."""

from __future__ import annotations

import os
import select
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

from dray.errors import UnavailableError

CHUNK_BYTES = 2**16

SILENCE_S = 90.0
"""Longest wait for a line, on a busy computer."""


class Speaker:
    """A process.

    Args:
        name: for complaints.
        command: starts it.
        environment: all of its variables.
        log: takes its standard error.
    """

    def __init__(self, name: str, command: Sequence[str], environment: Mapping[str, str], log: Path) -> None:
        self._name, self._log, self._unread = name, log, b""
        self._listener, mouth = os.pipe()
        try:
            with log.open("wb") as complaints:
                self._process = subprocess.Popen(  # noqa: S603 (no shell, and no word of a stranger's)
                    command, stdin=subprocess.DEVNULL, stdout=mouth, stderr=complaints, env=environment
                )
        finally:
            os.close(mouth)

    def line(self) -> bytes:
        """The next line that it says.

        Raises:
            UnavailableError: it says none, or has ended.
        """
        while b"\n" not in self._unread:
            if not select.select([self._listener], [], [], SILENCE_S)[0]:
                raise self.complaint("says nothing any more")
            said = os.read(self._listener, CHUNK_BYTES)
            if not said:
                raise self.complaint("has ended")
            self._unread += said
        line, _, self._unread = self._unread.partition(b"\n")
        return line

    def kill(self) -> None:
        """End it as a power failure does. Twice is harmless."""
        self._process.kill()

    def close(self) -> None:
        """Wait until it has ended."""
        self._process.wait()
        os.close(self._listener)

    def complaint(self, what: str) -> UnavailableError:
        """An error about this process, with the last line of its log."""
        last = self._log.read_text(encoding="utf-8", errors="replace").strip().rpartition("\n")[2]
        return UnavailableError(
            self._name, f"{what}: {last}" if last else what, "try again on a quieter computer"
        )

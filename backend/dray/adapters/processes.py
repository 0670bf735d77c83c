"""Processes of this computer, identified by number and birth.

The system reuses the number of an ended process; then no other process may be signalled.
"""

from __future__ import annotations

import asyncio
import contextlib
import errno
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import msgspec

from dray.errors import UnavailableError

PROC = Path("/proc")

ENDED = frozenset("ZX")
"""States of an ended process that its parent has not waited for."""

NOBODY = frozenset({errno.ESRCH, errno.EINVAL, errno.ENOENT})
"""The kernel's errors for a number without a process: unused, or now a thread's."""

STATE, BIRTH = 0, 19
"""Indexes in `/proc/PID/stat`, counted after the name of the program (proc(5), fields 3 and 22)."""


class Process(msgspec.Struct, frozen=True):
    """One process, running or not.

    Attributes:
        pid: its number.
        born: boot time of the computer, and start of the process since then; empty for one that had ended at once.
    """

    pid: int
    born: str

    @classmethod
    def of(cls, pid: int) -> Process:
        """The present process with this number."""
        return cls(pid, birth_of(pid))

    @property
    def runs(self) -> bool:
        """Whether it still runs."""
        return self.born != "" and birth_of(self.pid) == self.born

    def signal(self, number: signal.Signals) -> bool:
        """Send it a signal; False when it has ended.

        Raises:
            UnavailableError: it belongs to another user.
        """
        with self._held() as handle:
            if handle is None:
                return False
            try:
                signal.pidfd_send_signal(handle, number)
            except ProcessLookupError:
                return False
            except PermissionError:
                raise UnavailableError(
                    f"process {self.pid}", "belongs to another user", "ask as that user"
                ) from None
            return True

    async def gone(self) -> None:
        """Wait until it has ended, even if it is no child of ours."""
        ended = asyncio.Event()
        loop = asyncio.get_running_loop()
        with self._held() as handle:
            if handle is None:
                return
            loop.add_reader(handle, ended.set)
            try:
                await ended.wait()
            finally:
                loop.remove_reader(handle)

    @contextlib.contextmanager
    def _held(self) -> Iterator[int | None]:
        """A handle of exactly this process; None when it has ended."""
        try:
            handle = os.pidfd_open(self.pid) if self.runs else None
        except OSError as error:
            if error.errno not in NOBODY:
                raise
            handle = None
        if handle is None:
            yield None
            return
        try:
            # Check again: if the number was reused meanwhile, the birth differs.
            yield handle if self.runs else None
        finally:
            os.close(handle)


def birth_of(pid: int) -> str:
    """The birth of the process with this number, as a unique text; empty when there is none."""
    try:
        told = (PROC / str(pid) / "stat").read_text(encoding="utf-8", errors="replace")
        boot = (PROC / "sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
    except (FileNotFoundError, ProcessLookupError):
        return ""
    # The program's name is in brackets, and may contain brackets itself.
    fields = told.rpartition(")")[2].split()
    return "" if fields[STATE] in ENDED else f"{boot}/{fields[BIRTH]}"

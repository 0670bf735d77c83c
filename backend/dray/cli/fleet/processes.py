"""Processes of this computer, known by number and birth.

The number of a process that has ended is given to another one some day; no stranger may be signalled then.
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
"""States of a process that has ended and that its parent has not yet asked about."""

NOBODY = frozenset({errno.ESRCH, errno.EINVAL, errno.ENOENT})
"""What the kernel says of a number that is no process any more: it is nobody's, or a thread's by now."""

STATE, BIRTH = 0, 19
"""Places in `/proc/PID/stat`, counted after the name of the program (proc(5), fields 3 and 22)."""


class Process(msgspec.Struct, frozen=True):
    """One process, running or not.

    Attributes:
        pid: its number.
        born: the start of the computer, and of the process since then; empty for one that had ended at once.
    """

    pid: int
    born: str

    @classmethod
    def of(cls, pid: int) -> Process:
        """The process that has this number now."""
        return cls(pid, birth_of(pid))

    @property
    def runs(self) -> bool:
        """Whether it is there still."""
        return self.born != "" and birth_of(self.pid) == self.born

    def signal(self, number: signal.Signals) -> bool:
        """Send it a signal; False when it has ended.

        Raises:
            UnavailableError: it is somebody else's.
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
        """Wait until it has ended, also when it is no child of ours."""
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
        """A handle that means this process and no later one; None when it has ended."""
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
            # Asked once more: had the number been given anew meanwhile, this would be another birth.
            yield handle if self.runs else None
        finally:
            os.close(handle)


def birth_of(pid: int) -> str:
    """When the process of this number began, in words that fit no other process; empty when there is none."""
    try:
        told = (PROC / str(pid) / "stat").read_text(encoding="utf-8", errors="replace")
        boot = (PROC / "sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
    except (FileNotFoundError, ProcessLookupError):
        return ""
    # The program's name stands in brackets, and may hold brackets itself.
    fields = told.rpartition(")")[2].split()
    return "" if fields[STATE] in ENDED else f"{boot}/{fields[BIRTH]}"

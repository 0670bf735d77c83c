"""Resource usage of processes of this computer, by the kernel's figures (proc(5))."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from dray.errors import UnavailableError

USER_TICKS, SYSTEM_TICKS = 11, 12
"""Places in `/proc/PID/stat`, counted after the name of the program: fields 14 and 15."""

TICKS_PER_S = os.sysconf("SC_CLK_TCK")

SHARE = "Pss:"
"""Each process is charged its part of shared memory, so the sum is their joint usage."""


@dataclass(frozen=True, slots=True)
class Usage:
    """The usage of some processes so far.

    Attributes:
        processor_s: seconds of one processor.
        memory_mb: at this moment.
    """

    processor_s: float
    memory_mb: float

    @classmethod
    def of(cls, pids: Iterable[int]) -> Self:
        """The joint usage of these processes.

        Raises:
            UnavailableError: one of them has ended.
        """
        folders = [Path("/proc") / str(pid) for pid in pids]
        return cls(sum(map(_processor_s, folders)), sum(map(_memory_mb, folders)))


def _processor_s(folder: Path) -> float:
    fields = _read(folder / "stat").rpartition(")")[2].split()
    return (int(fields[USER_TICKS]) + int(fields[SYSTEM_TICKS])) / TICKS_PER_S


def _memory_mb(folder: Path) -> float:
    lines = _read(folder / "smaps_rollup").splitlines()
    return sum(int(line.split()[1]) for line in lines if line.startswith(SHARE)) / 1024


def _read(file: Path) -> str:
    try:
        return file.read_text()
    except (FileNotFoundError, ProcessLookupError):
        remedy = "see its log; what is measured must not end meanwhile"
        raise UnavailableError(f"process {file.parent.name}", "has ended", remedy) from None

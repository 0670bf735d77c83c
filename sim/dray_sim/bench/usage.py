"""What processes of this computer use, as the kernel tells it (proc(5))."""

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
"""Of memory that several processes share, each is charged its part: so the sum is what they use together."""


@dataclass(frozen=True, slots=True)
class Usage:
    """What some processes have used so far.

    Attributes:
        processor_s: seconds of one processor.
        memory_mb: at this moment.
    """

    processor_s: float
    memory_mb: float

    @classmethod
    def of(cls, pids: Iterable[int]) -> Self:
        """What these processes have used together.

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

"""The process of side work (`http.side_work`): reads pieces from its input, writes outcomes to its output.

A piece is a function with its arguments; both ends are ours, so they use pickle. An exception is an outcome
too, except lack of memory, which ends the process. So does a piece that uses the processor for too long.
"""

from __future__ import annotations

import os
import pickle
import signal
import struct
import sys
from collections.abc import Callable
from typing import Any, BinaryIO

LENGTH = struct.Struct("!Q")
"""Length in bytes before every piece and outcome."""


Outcome = tuple[Any, Exception | None]
"""Result of a piece, or its exception."""


def framed(value: object) -> bytes:
    """A value as sent."""
    written = pickle.dumps(value)
    return LENGTH.pack(len(written)) + written


def serve(pieces: BinaryIO, outcomes: BinaryIO, work_s: float) -> None:
    """Do pieces one by one until the input ends.

    Args:
        pieces: the input.
        outcomes: the output.
        work_s: maximum processor seconds per piece.
    """
    while head := pieces.read(LENGTH.size):
        # Its signal ends the process, whatever runs.
        signal.setitimer(signal.ITIMER_PROF, work_s)
        work, given = pickle.loads(pieces.read(*LENGTH.unpack(head)))  # noqa: S301 - the gateway's own
        outcomes.write(framed(_outcome(work, given)))
        outcomes.flush()


def _outcome(work: Callable[..., Any], given: tuple[Any, ...]) -> Outcome:
    try:
        return work(*given), None
    except MemoryError:
        raise
    except Exception as error:  # noqa: BLE001 - it is for who asked
        return None, error


if __name__ == "__main__":
    with os.fdopen(os.dup(sys.stdout.fileno()), "wb") as outcomes:
        # Keep prints of a piece out of the outcomes.
        os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
        serve(sys.stdin.buffer, outcomes, float(sys.argv[1]))

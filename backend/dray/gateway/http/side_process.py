"""The process in which side work is done (`http.side_work`): pieces come on its input, and what came of each leaves on its output.

A piece is a function and what it is given; both ends are ours, so they speak pickle. What a piece raises is its result, but for want
of memory, which ends the process.
"""

from __future__ import annotations

import os
import pickle
import struct
import sys
from collections.abc import Callable
from typing import Any, BinaryIO

LENGTH = struct.Struct("!Q")
"""Stands before every piece and every outcome: how many bytes it has."""


Outcome = tuple[Any, Exception | None]
"""What a piece returned, or what it raised."""


def framed(value: object) -> bytes:
    """A value as it is sent."""
    written = pickle.dumps(value)
    return LENGTH.pack(len(written)) + written


def serve(pieces: BinaryIO, outcomes: BinaryIO) -> None:
    """Do one piece after the other, until no other comes."""
    while head := pieces.read(LENGTH.size):
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
        # What a piece prints is no outcome.
        os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
        serve(sys.stdin.buffer, outcomes)

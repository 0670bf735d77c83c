"""A stand-in for Dray: it says how it was started, waits for a signal, and says which one came.

It tells whoever has started it that it takes part when SIGUSR1 comes.
"""

from __future__ import annotations

import sys
from pathlib import Path

from dray.cli.fleet.software import Software
from dray.messages import WIRE_VERSION

PROGRAM = """\
#!{python} -S
import os, signal, socket, sys
ENDS = {{signal.SIGINT, signal.SIGTERM}}
HEEDED = ENDS | {{signal.SIGUSR1}}
# Held back from here on, and taken one by one: none can come between a look and the wait for the next.
signal.pthread_sigmask(signal.SIG_BLOCK, HEEDED)
print("{version}", *sys.argv[4:], os.environ["TOLD"], flush=True)
while True:
    came = signal.Signals(signal.sigwait(HEEDED))
    if came == signal.SIGUSR1:
        told = "\\0" + os.environ["NOTIFY_SOCKET"][1:]
        socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM).sendto(b"READY=1", told)
    elif came.name not in {deaf!r}:
        print("{version} ends by", came.name, flush=True)
        sys.exit(0)
"""


def make_actor(folder: Path, version: str, deaf: tuple[str, ...] = ()) -> Software:
    """A software whose processes do nothing.

    Args:
        folder: where its interpreter is put.
        version: of the software.
        deaf: signals that it does not heed.
    """
    python = folder / f"python-{version}"
    python.write_text(PROGRAM.format(python=sys.executable, version=version, deaf=deaf), encoding="utf-8")
    python.chmod(0o700)
    return Software(str(python), version, WIRE_VERSION)


def ends_at_once(folder: Path) -> Software:
    """A software that cannot live."""
    python = folder / "python-dead"
    python.write_text("#!/bin/sh\necho dead\nexit 1\n", encoding="utf-8")
    python.chmod(0o700)
    return Software(str(python), "dead", WIRE_VERSION)

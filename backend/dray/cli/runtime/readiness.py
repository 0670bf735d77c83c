"""Readiness: a process that was started tells whoever has started it that it takes part (sd_notify(3)).

systemd listens for `Type=notify` units, `dray fleet up` for its processes. Who listens is named by an
environment variable; when nobody does, there is nobody to tell. A person reads a line on stdout.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import socket
import sys
from collections.abc import Iterator

import typer

VARIABLE = "NOTIFY_SOCKET"

READY = b"READY=1"

SAID = "{name} is ready"
"""What a process says when it takes part, on a line of its own."""

LONGEST_BYTES = 4096
"""Of one notice: far more than anyone has to say."""


def tell_ready() -> None:
    """Tell that this process takes part."""
    address = os.environ.get(VARIABLE, "")
    if not address:
        return
    # Nobody may listen any more, and a process that takes part does not depend on being waited for.
    with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as teller:
        teller.setblocking(False)
        # A leading @ stands for Linux' addresses that are no files.
        teller.sendto(READY, address.replace("@", "\0", 1) if address.startswith("@") else address)


def say_ready(name: str) -> None:
    """Tell whoever has started this process that it takes part."""
    typer.echo(SAID.format(name=name))
    # A pipe would hold the line back.
    sys.stdout.flush()
    tell_ready()


class Listener:
    """Hears when one process takes part.

    Args:
        inbox: a datagram socket that has an address.
    """

    def __init__(self, inbox: socket.socket) -> None:
        self._inbox = inbox
        self.environment = {VARIABLE: "@" + inbox.getsockname()[1:].decode()}
        """What the process has to be started with."""

    async def ready(self) -> None:
        """Wait until it takes part."""
        loop = asyncio.get_running_loop()
        while READY not in (await loop.sock_recv(self._inbox, LONGEST_BYTES)).splitlines():
            pass


@contextlib.contextmanager
def listening() -> Iterator[Listener]:
    """Listen for one process, at an address that nobody else has."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as inbox:
        inbox.setblocking(False)
        inbox.bind("")  # Linux chooses a free address that is no file (unix(7), autobind)
        yield Listener(inbox)

"""Readiness: a started process notifies its parent that it takes part in the plant (sd_notify(3)).

The parent is systemd for units of `Type=notify`, or `dray fleet up`. It passes the address of its socket in an environment variable.
Without that variable no notice is sent. A line on stdout tells people the same.
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
"""The line for people on stdout."""

LONGEST_BYTES = 4096
"""Maximum size of one notice: far more than needed."""


def tell_ready() -> None:
    """Send the notice, if there is a listener."""
    address = os.environ.get(VARIABLE, "")
    if not address:
        return
    # The listener may have gone, and a process that takes part does not depend on it.
    with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as teller:
        teller.setblocking(False)
        # A leading @ means an abstract address of Linux, without a file.
        teller.sendto(READY, address.replace("@", "\0", 1) if address.startswith("@") else address)


def say_ready(name: str) -> None:
    """Print the line for people, and send the notice."""
    typer.echo(SAID.format(name=name))
    # A pipe would buffer the line.
    sys.stdout.flush()
    tell_ready()


class Listener:
    """Waits for the readiness of one process.

    Args:
        inbox: a datagram socket that has an address.
    """

    def __init__(self, inbox: socket.socket) -> None:
        self._inbox = inbox
        self.environment = {VARIABLE: "@" + inbox.getsockname()[1:].decode()}
        """Variables for the start of the process."""

    async def ready(self) -> None:
        """Wait until it takes part."""
        loop = asyncio.get_running_loop()
        while READY not in (await loop.sock_recv(self._inbox, LONGEST_BYTES)).splitlines():
            pass


@contextlib.contextmanager
def listening() -> Iterator[Listener]:
    """Listen for one process, at an unused address."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as inbox:
        inbox.setblocking(False)
        inbox.bind("")  # Linux chooses a free address that is no file (unix(7), autobind)
        yield Listener(inbox)

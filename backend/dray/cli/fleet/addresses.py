"""Addresses on this computer for processes that are to be started on it."""

from __future__ import annotations

import contextlib
import socket


def free_addresses(count: int) -> list[str]:
    """Addresses on this computer where nobody listens."""
    with contextlib.ExitStack() as stack:
        # All of them at once, so that none is given twice.
        sockets = [stack.enter_context(socket.socket()) for _ in range(count)]
        for each in sockets:
            each.bind(("127.0.0.1", 0))
        return [f"127.0.0.1:{each.getsockname()[1]}" for each in sockets]

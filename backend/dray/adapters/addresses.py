"""Free addresses on this computer, for processes to be started."""

from __future__ import annotations

import contextlib
import socket


def free_addresses(count: int) -> list[str]:
    """Addresses on this computer without a listener."""
    with contextlib.ExitStack() as stack:
        # Bind all at once, so that none is returned twice.
        sockets = [stack.enter_context(socket.socket()) for _ in range(count)]
        for each in sockets:
            each.bind(("127.0.0.1", 0))
        return [f"127.0.0.1:{each.getsockname()[1]}" for each in sockets]

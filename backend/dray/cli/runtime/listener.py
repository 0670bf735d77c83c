"""A port that is ours before anything starts. It loads no server: agents and fleets need none."""

from __future__ import annotations

import errno
import socket

from dray.errors import UnavailableError

BACKLOG = 1024
"""Connections that may wait to be accepted. Whoever finds the queue full tries again after a second, and a crowd must
not let a Stop wait for that."""

ANY_ADDRESS = frozenset({"0.0.0.0", "::", ""})  # noqa: S104 (compared with, not bound to)


def listen(host: str, port: int, option: str = "--port") -> socket.socket:
    """Take the port, before anything else is started.

    Args:
        host: a name or address of this machine.
        port: 0 lets the system choose one.
        option: where it was chosen.

    Raises:
        UnavailableError: with a remedy, when it is taken or not allowed.
    """
    what = f"port {port} on {host}"
    try:
        family, kind, proto, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
    except (OSError, UnicodeError) as error:
        remedy = "name a host or address of this machine with --host"
        raise UnavailableError(f"host {host}", _reason(error), remedy) from error
    listener = socket.socket(family, kind, proto)
    try:
        # A port whose last connections are still fading may be taken at once; one in use may not.
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(address)
        listener.listen(BACKLOG)
    except OSError as error:
        listener.close()
        if error.errno == errno.EADDRINUSE:
            remedy = f"end the program that uses it, or choose another one with {option} (0: any free one)"
        else:
            remedy = f"choose another one with --host and {option}; ports below 1024 need a privilege"
        raise UnavailableError(what, _reason(error), remedy) from error
    return listener


def address_of(listener: socket.socket, host: str) -> str:
    """What to type into a browser on this machine."""
    return url_of(host, listener.getsockname()[1])


def url_of(host: str, port: int) -> str:
    """How a server that listens there is called from this machine."""
    if host in ANY_ADDRESS:
        host = "127.0.0.1"
    return f"http://[{host}]:{port}" if ":" in host else f"http://{host}:{port}"


def _reason(error: Exception) -> str:
    reason = getattr(error, "strerror", None) or str(error)
    return reason[:1].lower() + reason[1:]

"""A port that is taken before anything starts. It imports no server: agents and fleets need none."""

from __future__ import annotations

import errno
import socket

from dray.errors import UnavailableError

BACKLOG = 1024
"""Maximum connections that wait to be accepted. With a full queue a client retries after a second, and many clients must not
delay a Stop by that."""

ANY_ADDRESS = frozenset({"0.0.0.0", "::", ""})  # noqa: S104 (compared with, not bound to)


def listen(host: str, port: int, option: str = "--port") -> socket.socket:
    """Take the port, before anything else is started.

    Args:
        host: a name or address of this machine.
        port: 0 lets the system choose one.
        option: the option of the port, for the error.

    Raises:
        UnavailableError: the port is taken or not allowed; contains a remedy.
    """
    what = f"port {port} on {host}"
    try:
        family, kind, proto, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
    except (OSError, UnicodeError) as error:
        remedy = "name a host or address of this machine with --host"
        raise UnavailableError(f"host {host}", _reason(error), remedy) from error
    listener = socket.socket(family, kind, proto)
    try:
        # A port with fading connections may be taken at once; one in use may not.
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
    """The address for a browser on this machine."""
    return url_of(host, listener.getsockname()[1])


def url_of(host: str, port: int) -> str:
    """The address of a server with this listener, from this machine."""
    if host in ANY_ADDRESS:
        host = "127.0.0.1"
    return f"http://[{host}]:{port}" if ":" in host else f"http://{host}:{port}"


def _reason(error: Exception) -> str:
    reason = getattr(error, "strerror", None) or str(error)
    return reason[:1].lower() + reason[1:]

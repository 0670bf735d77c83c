"""The HTTP server: uvicorn, with what a gateway needs of it."""

from __future__ import annotations

import errno
import socket

import uvicorn
from fastapi import FastAPI

from dray.errors import UnavailableError
from dray.settings import Settings

INCOMING_BYTES = 4096
"""Longest message that a panel may send on the stream: it has nothing to say."""

GOODBYE_S = 3
"""Wall seconds that open requests get when the server ends: no answer takes longer, but a command."""

BACKLOG = 128
"""Connections that may wait to be accepted."""


def listen(host: str, port: int) -> socket.socket:
    """Take the port, before anything else is started.

    Raises:
        UnavailableError: with a remedy, when it is taken or not allowed.
    """
    what = f"port {port} on {host}"
    try:
        family, kind, proto, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        taken = socket.socket(family, kind, proto)
    except OSError as error:
        raise UnavailableError(what, error.strerror or str(error), "name a host of this machine") from error
    try:
        taken.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        taken.bind(address)
        taken.listen(BACKLOG)
    except OSError as error:
        taken.close()
        if error.errno == errno.EADDRINUSE:
            remedy = f"end the program that uses it, or choose another with --port {port + 1}"
        else:
            remedy = "choose another one with --host and --port; ports below 1024 need a privilege"
        raise UnavailableError(what, error.strerror or str(error), remedy) from error
    return taken


def server_of(app: FastAPI, settings: Settings) -> uvicorn.Server:
    """A server for `app`; run it with ``await server.serve(sockets=[listen(host, port)])``."""
    config = uvicorn.Config(
        app,
        log_level=settings.log_level,
        access_log=False,
        server_header=False,
        ws_max_size=INCOMING_BYTES,
        # Compressing would be done anew for every client, and frames are encoded once for all.
        ws_per_message_deflate=False,
        timeout_graceful_shutdown=GOODBYE_S,
    )
    return uvicorn.Server(config)

"""Hosts: the names by which a gateway may be addressed.

Another site can point its own name at this machine, so that a visitor's browser takes our answers for that
site's (DNS rebinding). Therefore requests by name need a configured name. An address cannot be redirected
like this, and is always accepted.
"""

from __future__ import annotations

import socket
from http import HTTPStatus
from ipaddress import ip_address
from urllib.parse import urlsplit

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Receive, Scope, Send

from dray.gateway.http.problems import Problem
from dray.settings import Settings

HEADERS_KNOWN = 256
"""Maximum accepted Host headers to remember; addresses may come with any port."""

ANY = "*"
"""Wildcard that accepts any name."""


class Hosts:
    """The accepted names.

    Args:
        names: host names without ports; `*` for any.
    """

    def __init__(self, *names: str) -> None:
        self._names = frozenset(name.lower().rstrip(".") for name in names if name)
        self._known: set[str] = set()

    @classmethod
    def of(cls, settings: Settings) -> Hosts:
        """The names of this machine and of the settings."""
        public = urlsplit(settings.public_url).hostname or ""
        return cls("localhost", socket.gethostname(), settings.host, public, *settings.allowed_hosts)

    def know(self, header: str) -> bool:
        """Whether a Host header, or an address's authority, names this gateway."""
        if header in self._known:
            return True
        name = host_in(header)
        known = ANY in self._names or name in self._names or _is_address(name)
        if known and len(self._known) < HEADERS_KNOWN:
            self._known.add(header)
        return known


def host_in(authority: str) -> str:
    """The host of HOST:PORT in small letters; empty without one."""
    try:
        return (urlsplit(f"//{authority}").hostname or "").rstrip(".")
    except ValueError:
        return ""


def authority_in(address: str) -> str:
    """The HOST:PORT of a web address, such as an `Origin`; empty without one."""
    try:
        return urlsplit(address).netloc
    except ValueError:
        return ""


def _is_address(name: str) -> bool:
    try:
        ip_address(name)
    except ValueError:
        return False
    return True


class KnownHost:
    """Refuses requests by names that are not configured.

    Args:
        app: the next application.
        hosts: the accepted names.
    """

    def __init__(self, app: ASGIApp, hosts: Hosts) -> None:
        self._app, self._hosts = app, hosts

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan" or self._hosts.know(Headers(scope=scope).get("host", "")):
            await self._app(scope, receive, send)
        elif scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008, "reason": "not our name"})
        else:
            await unknown_host(Headers(scope=scope).get("host", "")).response(scope["path"])(
                scope, receive, send
            )


def unknown_host(header: str) -> Problem:
    """The problem of a request by a name that is not ours."""
    return Problem(
        HTTPStatus.MISDIRECTED_REQUEST,
        "unknown-host",
        "This gateway is not known by that name",
        f"you asked {header[:100]!r}; ask by address, or name the host in DRAY_ALLOWED_HOSTS or DRAY_PUBLIC_URL",
    )

"""Public URLs: the gateway's own addresses, as given to others."""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated

from fastapi import Depends
from starlette.datastructures import URL
from starlette.requests import Request

from dray.gateway.http.provided import provided
from dray.settings import Settings


def public_url(settings: Settings, request: Request) -> str:
    """The gateway's address for people and customers, without a slash at the end.

    Without a setting it is the request's address, whose host is an accepted one (`dray.gateway.http.hosts`).
    """
    return settings.public_url or _base(
        request.scope["scheme"], request.headers.get("host", ""), request.scope.get("root_path", "")
    )


def stop_url(settings: Settings, request: Request) -> str:
    """The stop path's address for a panel; empty if its browser cannot reach it."""
    if settings.stop_url or not settings.stop_port:
        return settings.stop_url
    # An https page may not call http: then there is a proxy, and the settings must have its address.
    host = request.url.hostname or ""
    if request.url.scheme != "http" or not host:
        return ""
    return f"http://[{host}]:{settings.stop_port}" if ":" in host else f"http://{host}:{settings.stop_port}"


async def _base_url(request: Request) -> str:
    return public_url(provided(request.app, Settings), request)


BaseUrl = Annotated[str, Depends(_base_url)]
"""A router's parameter: see `public_url`."""


@lru_cache(maxsize=64)
def _base(scheme: str, host: str, root_path: str) -> str:
    """The root of the request's address, cached: few per gateway, but needed in every order's answer."""
    headers = [(b"host", host.encode("latin-1"))]
    scope = {"scheme": scheme, "headers": headers, "path": root_path, "query_string": b""}
    return str(URL(scope=scope)).rstrip("/")

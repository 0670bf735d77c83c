"""Public URLs: where this gateway is reached, as it tells others."""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated

from fastapi import Depends
from starlette.datastructures import URL
from starlette.requests import Request

from dray.gateway.http.provided import provided
from dray.settings import Settings


def public_url(settings: Settings, request: Request) -> str:
    """Where people and customers reach the gateway, without a slash at the end.

    Where nobody has said so, it is the address that was asked, whose host is one of ours (`dray.gateway.http.hosts`).
    """
    return settings.public_url or _base(
        request.scope["scheme"], request.headers.get("host", ""), request.scope.get("root_path", "")
    )


def stop_url(settings: Settings, request: Request) -> str:
    """Where a panel reaches the stop path; empty where its browser cannot."""
    if settings.stop_url or not settings.stop_port:
        return settings.stop_url
    # A page that came by https may ask nothing by http: then there is a proxy, and the settings must say where.
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
    """The root of the addresses that are asked there: a few for one gateway, and each order's answer names its own."""
    headers = [(b"host", host.encode("latin-1"))]
    scope = {"scheme": scheme, "headers": headers, "path": root_path, "query_string": b""}
    return str(URL(scope=scope)).rstrip("/")

"""The stopwatch: measures every request."""

from __future__ import annotations

import time
from http import HTTPStatus

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from dray.gateway.access.rules import find
from dray.gateway.http.assets import PREFIX
from dray.gateway.http.provided import provided
from dray.gateway.metrics.metrics import Metrics

FILES = f"{PREFIX}*"
"""Route label of the panels' files."""

UNKNOWN = "unknown"
"""Route label of unknown paths, which are unlimited in number."""

METHODS = frozenset({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})


class Stopwatch:
    """Measures durations of answers by route; the outermost layer."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        began_s = time.perf_counter()
        status: int = HTTPStatus.INTERNAL_SERVER_ERROR

        async def noted(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
            await send(message)

        method = scope["method"] if scope["method"] in METHODS else UNKNOWN
        try:
            await self._app(scope, receive, noted)
        finally:
            requests = provided(scope["app"], Metrics).requests
            took_s = time.perf_counter() - began_s
            requests.labels(method, _route(method, scope["path"]), str(status)).observe(took_s)


def _route(method: str, path: str) -> str:
    if path.startswith(PREFIX):
        return FILES
    found = find(method, path)
    return UNKNOWN if found is None else found.template

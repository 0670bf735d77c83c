"""The page of an address that no page has, for people; programs get the problem as JSON.

It is the same for every caller, so that it tells nobody what others may see.
"""

from __future__ import annotations

from http import HTTPStatus

from fastapi import FastAPI, Request
from fastapi.responses import Response

from dray.gateway.access.gate import wants_page
from dray.gateway.access.login.page import page
from dray.gateway.http.assets import Panels
from dray.gateway.http.problems import on_http
from dray.gateway.http.provided import provided


def install(app: FastAPI) -> None:
    """Show the page at every address that no page has."""
    for status in (HTTPStatus.NOT_FOUND, HTTPStatus.METHOD_NOT_ALLOWED):
        app.add_exception_handler(status, _on_unknown)


async def _on_unknown(request: Request, error: Exception) -> Response:
    refused = await on_http(request, error)
    if request.method != "GET" or request.url.path == "/api" or not wants_page(request.scope):
        return refused
    headers = {"Allow": refused.headers["Allow"]} if "Allow" in refused.headers else {}
    status = HTTPStatus(refused.status_code)
    shown = page(provided(request.app, Panels), request, status, "unknown.html", headers)
    # Without built panels, the problem says more than the page's absence.
    return shown if shown.status_code == status else refused

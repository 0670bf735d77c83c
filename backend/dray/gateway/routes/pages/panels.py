"""Pages of the panels, which are built from `frontend/`."""

from __future__ import annotations

from hashlib import sha256
from http import HTTPStatus

import msgspec
from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse, PlainTextResponse, RedirectResponse, Response

from dray.gateway.access.caller import Caller
from dray.gateway.access.login.redirect import HOMES
from dray.gateway.access.principal import Role
from dray.gateway.http.assets import NotBuilt, Panels
from dray.gateway.http.language import language_of
from dray.gateway.http.middleware import CONTENT_POLICY
from dray.gateway.http.provided import Provided
from dray.gateway.http.public_urls import stop_url
from dray.settings import Settings

router = APIRouter(include_in_schema=False)

NOT_BUILT = """\
The panels are not built.

Dray itself is running: the API is documented at /api/docs.
To build the panels, run `make panels` in the checkout and load this page again.
"""


@router.get("/")
async def manager(
    settings: Provided[Settings], panels: Provided[Panels], request: Request, caller: Caller
) -> Response:
    """The management panel; callers limited to areas are redirected to their own."""
    if caller.areas is not None:
        return RedirectResponse(HOMES[Role.OPERATOR], HTTPStatus.SEE_OTHER)
    return _panel(settings, panels, request, "manager.html")


@router.get("/editor")
async def editor(settings: Provided[Settings], panels: Provided[Panels], request: Request) -> Response:
    """The plant editor, a page of the management panel by itself."""
    return _panel(settings, panels, request, "editor.html")


@router.get("/operator")
async def operator(settings: Provided[Settings], panels: Provided[Panels], request: Request) -> Response:
    """The operator panel. The page is the same for everybody; its data comes by the stream."""
    return _panel(settings, panels, request, "operator.html")


@router.get("/operator/shell")
async def shell(settings: Provided[Settings], panels: Provided[Panels], request: Request) -> Response:
    """The same page for the service worker, shown when offline. It holds no data."""
    return _panel(settings, panels, request, "operator.html")


@router.get("/operator/worker.js")
async def worker(panels: Provided[Panels]) -> Response:
    """The service worker with its list of files: each build changes the text, which browsers notice."""
    try:
        files = [*panels.files("src/theme/init.ts", "src/operator/main.tsx"), "/static/icon.svg"]
        source = panels.source("src/operator/shell/worker.ts")
    except NotBuilt:
        return PlainTextResponse(NOT_BUILT, HTTPStatus.SERVICE_UNAVAILABLE)
    version = sha256("\n".join(files).encode()).hexdigest()[:16]
    told = msgspec.json.encode({"version": version, "page": "/operator/shell", "files": files}).decode()
    # By default it controls only paths below its folder, which excludes the panel's own address.
    headers = {"Cache-Control": "no-cache", "Service-Worker-Allowed": "/operator"}
    return Response(f"self.SHELL = {told};\n{source}", media_type="text/javascript", headers=headers)


def _panel(settings: Settings, panels: Panels, request: Request, template: str) -> Response:
    stop = stop_url(settings, request)
    try:
        page = panels.render(template, language=language_of(request), stop=stop)
    except NotBuilt:
        return PlainTextResponse(NOT_BUILT, HTTPStatus.SERVICE_UNAVAILABLE)
    # The page names built scripts: a cached page would request scripts that are gone.
    headers = {"Cache-Control": "no-store"}
    if stop:
        headers["Content-Security-Policy"] = f"{CONTENT_POLICY}; connect-src 'self' {stop}"
    return HTMLResponse(page, headers=headers)

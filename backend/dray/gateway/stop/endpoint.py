"""The HTTP endpoint of the stop path. It reads a few hundred bytes, and authenticates from memory alone.

It accepts one request: `POST /api/atvs/{atv}/commands` with kind `stop`, as at the gateway's own address.
Panels' pages come from there, another origin for browsers, so the endpoint allows that origin (CORS).
"""

from __future__ import annotations

import re
from collections.abc import Callable
from http import HTTPStatus
from http.cookies import CookieError, SimpleCookie
from typing import Annotated, Literal
from urllib.parse import urlsplit

import msgspec
from starlette.datastructures import Headers
from starlette.requests import ClientDisconnect
from starlette.responses import Response
from starlette.types import Receive, Scope, Send

from dray.gateway.access.access import STRANGERS_HZ, STRANGERS_TRIES
from dray.gateway.access.audit_recorder import address_of
from dray.gateway.access.gate import COOKIE, forbidden, unknown
from dray.gateway.access.limits import Limit, neighbourhood
from dray.gateway.access.principal import Principal
from dray.gateway.access.principal import Scope as Right
from dray.gateway.http.hosts import Hosts, authority_in, host_in, unknown_host
from dray.gateway.http.problems import FieldError, Problem, unusable
from dray.gateway.http.responses import Json
from dray.gateway.live.reasons import refusal_text
from dray.gateway.stop.sender import StopSender
from dray.plant.model import ID_RULE, is_id

BODY_BYTES = 1024
"""Maximum body; a stop has some hundred bytes."""

ASKED_AGAIN_S = 86_400
"""Seconds for which a browser caches this permission: a shift, and the next one."""

_PATH = re.compile(r"/api/atvs/([^/]+)/commands")

Remembered = Callable[[str, str, float], Principal | None]
"""Takes the header Authorization, the session's cookie and the wall clock (`Access.remembered`)."""


class StopRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A stop of one vehicle."""

    kind: Literal["stop"]
    command: Annotated[str, msgspec.Meta(pattern=r"^[A-Za-z0-9._:-]{1,64}$")] | None = None
    """The caller's name for this command, as at the gateway's own address."""


class StopEndpoint:
    """The ASGI application.

    Args:
        sender: sends stops to vehicles.
        remembered: recognises callers from memory.
        hosts: accepted names of this endpoint.
        origin_port: port of the gateway's own address, where panels come from.
        public_url: address of the panels, if it is another one; else empty.
        wall_s: the wall clock.
    """

    def __init__(
        self,
        sender: StopSender,
        *,
        remembered: Remembered,
        hosts: Hosts,
        origin_port: int,
        public_url: str,
        wall_s: Callable[[], float],
    ) -> None:
        self._sender, self._remembered, self._hosts, self._wall_s = sender, remembered, hosts, wall_s
        self._port, self._public = origin_port, _with_port(public_url) if public_url else None
        self._strangers = Limit(wall_s, tries=STRANGERS_TRIES, rate_hz=STRANGERS_HZ)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """See the ASGI specification."""
        try:
            answer = await self._answer(scope, Headers(scope=scope), receive)
        except Problem as problem:
            answer = problem.response(scope["path"])
        except ClientDisconnect:
            return
        answer.headers.update(self._for_browsers(Headers(scope=scope)))
        await answer(scope, receive, send)

    async def _answer(self, scope: Scope, headers: Headers, receive: Receive) -> Response:
        if not self._hosts.know(headers.get("host", "")):
            raise unknown_host(headers.get("host", ""))
        if scope["path"] == "/healthz" and scope["method"] in {"GET", "HEAD"}:
            return Response(status_code=HTTPStatus.NO_CONTENT)
        path = _PATH.fullmatch(scope["path"])
        if path is None:
            raise _nothing_here(scope["path"])
        match scope["method"]:
            case "OPTIONS":
                return Response(status_code=HTTPStatus.NO_CONTENT, headers={"Allow": "OPTIONS, POST"})
            case "POST":
                return await self._stop(path[1], scope, headers, receive)
        raise _only_post(scope["method"])

    async def _stop(self, atv: str, scope: Scope, headers: Headers, receive: Receive) -> Response:
        if not self._is_ours(headers):
            raise forbidden("another site's page asks; open the panel under the address that it is asked at")
        by = self._recognise(headers, address_of(scope))
        if not is_id(atv):
            raise unusable(FieldError("atv", ID_RULE))
        asked = _read(await _body(headers, receive))
        answer = await self._sender.stop(atv, by, address_of(scope), asked.command)
        return Json(
            {
                "command": answer.command,
                "done": answer.done,
                "reason": answer.reason,
                "detail": answer.detail,
                "text": refusal_text(answer),
            }
        )

    def _recognise(self, headers: Headers, address: str) -> Principal:
        credentials, cookie = headers.get("authorization", ""), _session_in(headers.get("cookie", ""))
        by = self._remembered(credentials, cookie, self._wall_s())
        if by is None:
            self._strangers.take(neighbourhood(address))
            raise unknown("nobody is known by these credentials here")
        if not by.may(Right.VEHICLES_STOP):
            raise forbidden(f"{by.name} lacks the scope {Right.VEHICLES_STOP.value}")
        return by

    def _is_ours(self, headers: Headers) -> bool:
        """Whether the request comes from our own page, or from no page."""
        origin = headers.get("origin")
        if origin is None:
            return headers.get("sec-fetch-site", "none") in {"none", "same-origin"}
        netloc, host = authority_in(origin), headers.get("host", "")
        asked = _with_port(origin)
        return (netloc != "" and netloc == host) or asked in {self._public, (host_in(host), self._port)}

    def _for_browsers(self, headers: Headers) -> dict[str, str]:
        told = {"Cache-Control": "no-store", "Vary": "Origin", "X-Content-Type-Options": "nosniff"}
        origin = headers.get("origin")
        if origin is not None and self._is_ours(headers):
            told |= {
                "Access-Control-Allow-Origin": origin,
                "Access-Control-Allow-Credentials": "true",
                "Access-Control-Allow-Methods": "POST",
                "Access-Control-Allow-Headers": "content-type",
                "Access-Control-Max-Age": str(ASKED_AGAIN_S),
            }
        return told


async def _body(headers: Headers, receive: Receive) -> bytes:
    if headers.get("content-type", "").partition(";")[0].strip().lower() != "application/json":
        raise Problem(
            HTTPStatus.UNSUPPORTED_MEDIA_TYPE,
            "not-called-json",
            "The body is not called JSON",
            "send application/json",
        )
    body, more = b"", True
    while more:
        message = await receive()
        if message["type"] == "http.disconnect":
            raise ClientDisconnect
        body += message.get("body", b"")
        more = message.get("more_body", False)
        if len(body) > BODY_BYTES:
            raise Problem(
                HTTPStatus.REQUEST_ENTITY_TOO_LARGE,
                "body-too-large",
                "The body is too large",
                f"a stop has {BODY_BYTES} bytes at most",
                headers={"Connection": "close"},
            )
    return body


def _read(body: bytes) -> StopRequest:
    try:
        return msgspec.json.decode(body, type=StopRequest)
    except msgspec.ValidationError as error:
        raise unusable(FieldError("body", f"{error}; this address is for kind stop alone")) from None
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        raise Problem(
            HTTPStatus.BAD_REQUEST, "not-json", "The body is not JSON", "send one JSON object in UTF-8"
        ) from None


def _session_in(cookies: str) -> str:
    try:
        morsel = SimpleCookie(cookies).get(COOKIE)
    except CookieError:
        return ""
    return "" if morsel is None else morsel.value


def _with_port(origin: str) -> tuple[str, int]:
    """The host and port of a page's origin; empty if it has none."""
    try:
        parts = urlsplit(origin)
        port = parts.port or (443 if parts.scheme == "https" else 80)
    except ValueError:
        return "", 0
    return parts.hostname or "", port


def _nothing_here(path: str) -> Problem:
    detail = (
        f"there is nothing at {path[:100]}; only stops pass here, and the rest of Dray is at its own address"
    )
    return Problem(HTTPStatus.NOT_FOUND, "not-found", "Not Found", detail)


def _only_post(method: str) -> Problem:
    return Problem(
        HTTPStatus.METHOD_NOT_ALLOWED,
        "method-not-allowed",
        "Method Not Allowed",
        f"this address does not know {method[:20]}; use POST",
        headers={"Allow": "OPTIONS, POST"},
    )

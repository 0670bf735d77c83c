"""The customer's page: an order or a plain transport, for holders of its link.

The server renders it completely, so it needs no script; its script reloads the page and shows the changes.
The time zone is the one noted by the script, else this computer's.
"""

from __future__ import annotations

from http import HTTPStatus
from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse, PlainTextResponse, Response

from dray.gateway.http.assets import NotBuilt, Panels
from dray.gateway.http.language import language_of, remember_language, switches
from dray.gateway.http.provided import Now, Provided
from dray.gateway.live.projection import Projection
from dray.gateway.orders.transport_steps import transport_steps
from dray.gateway.routes.orders.track import PRIVATE, material_name
from dray.gateway.tracking.facts import NoPage, facts_of
from dray.gateway.tracking.page import entity_tag, gone, page
from dray.gateway.tracking.texts import TEXTS
from dray.gateway.tracking.texts.clock import Clock, zone_named
from dray.gateway.tracking.track import track
from dray.gateway.tracking.transport import FoundTransport, transport_of, transport_page
from dray.store import Store

router = APIRouter(include_in_schema=False)

ZONE_COOKIE = "dray.zone"

HEADERS = PRIVATE | {"Vary": "Accept-Language, Cookie"}

NOT_BUILT = "This page cannot be shown at the moment. Please try again later.\n"


@router.api_route("/track/{token}", methods=["GET", "HEAD"])
async def customer(
    store: Provided[Store],
    projection: Provided[Projection],
    panels: Provided[Panels],
    now_s: Now,
    request: Request,
    token: str,
) -> Response:
    """The page of an order or a transport, or of an invalid link."""
    found = await facts_of(store, projection, token, now_s)
    language = language_of(request)
    texts = TEXTS[language]
    clock = Clock(texts, zone_named(request.cookies.get(ZONE_COOKIE, "")), now_s)
    sent = await transport_of(store, token, now_s) if found.why is NoPage.UNKNOWN else FoundTransport(None)
    if found.facts is not None:
        told = page(track(found.facts), texts, clock, now_s)
    elif sent.row is not None:
        name = sent.row.thing or material_name(projection, sent.row.item)
        steps = await transport_steps(store, sent.row)
        told = transport_page(sent.row, steps, name, texts, clock, now_s)
    else:
        why = sent.why or found.why or NoPage.UNKNOWN
        status = HTTPStatus.NOT_FOUND if why is NoPage.UNKNOWN else HTTPStatus.GONE
        return _answer(panels, request, status, "customer-gone.html", language, gone=gone(why, texts))
    context: dict[str, Any] = {
        "page": told,
        "zone": clock.zone,
        "as_of": clock.full(now_s),
    }
    # Without the time of the request: otherwise the tag would never match again.
    tag = entity_tag(told, language, clock.zone, clock.date())
    if tag in _known(request):
        return Response(status_code=HTTPStatus.NOT_MODIFIED, headers=HEADERS | {"ETag": tag})
    return _answer(panels, request, HTTPStatus.OK, "customer.html", language, tag=tag, **context)


def _answer(
    panels: Panels,
    request: Request,
    status: HTTPStatus,
    template: str,
    language: str,
    tag: str = "",
    **more: Any,
) -> Response:
    try:
        html = panels.render(
            template, language=language, texts=TEXTS[language], switches=switches(language), **more
        )
    except NotBuilt:
        return PlainTextResponse(NOT_BUILT, HTTPStatus.SERVICE_UNAVAILABLE, headers=HEADERS)
    answer = HTMLResponse(html, status, headers=HEADERS | ({"ETag": tag} if tag else {}))
    remember_language(answer, request)
    return answer


def _known(request: Request) -> set[str]:
    """The entity tags in the request."""
    return {tag.strip() for tag in request.headers.get("if-none-match", "").split(",")}

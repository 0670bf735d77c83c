"""The page of a call key: a plain form for a phone or a screen at a machine, complete without a script.

The key is in the address, like a customer page's token. The page opens only for a key whose one right is
transports of one place. Anybody with the address can move things to and from that place, and learns only the
names of places.
"""

from __future__ import annotations

from collections.abc import Mapping
from http import HTTPStatus
from typing import Annotated, Any

import msgspec
from fastapi import APIRouter, Query, Request
from fastapi.responses import HTMLResponse, PlainTextResponse, RedirectResponse, Response
from pydantic import ValidationError

from dray.gateway.access.access import Access
from dray.gateway.access.audit_log import Noted
from dray.gateway.access.audit_recorder import address_of
from dray.gateway.access.principal import Principal, Scope
from dray.gateway.access.tokens import new_token
from dray.gateway.calling.code import drawn
from dray.gateway.calling.page import SHOWN, called, choices, tiles, until
from dray.gateway.calling.texts import REFUSALS, TEXTS
from dray.gateway.http.assets import NotBuilt, Panels
from dray.gateway.http.language import language_of, remember_language, switches
from dray.gateway.http.problems import Problem, field_error
from dray.gateway.http.provided import Now, Provided
from dray.gateway.http.public_urls import BaseUrl
from dray.gateway.http.request_bodies import read_form
from dray.gateway.live.projection import Projection
from dray.gateway.orders.idempotency import AT_WORK, own_key
from dray.gateway.orders.transport_draft import THING_MAX, TransportDraft
from dray.gateway.orders.transports import PlainTransports
from dray.gateway.routes.orders.transports import transport_answer
from dray.store import Store
from dray.store.orders.transports import TransportFilter

router = APIRouter(include_in_schema=False)

HEADERS = {"Cache-Control": "no-store", "Vary": "Accept-Language, Cookie", "Referrer-Policy": "same-origin"}
"""Other sites do not learn the address, which holds the key. With `no-referrer`, browsers would also hide a
form's origin (`Origin: null`), and the form would be refused."""

NOT_BUILT = "This page cannot be shown at the moment. Please try again later.\n"

ONLY = frozenset({Scope.TRANSPORTS_CALL})

FIELDS = 8
"""Maximum fields in a form of this page, which has five at most."""

DIGITS = 9
"""Maximum digits of a quantity, more than allowed quantities have. Python refuses to convert thousands of
digits."""

Item = Annotated[str, Query(max_length=32, pattern=r"^[^\x00]*$")]


@router.api_route("/call/{token}", methods=["GET", "HEAD"])
async def call_page(
    store: Provided[Store],
    access: Provided[Access],
    projection: Provided[Projection],
    panels: Provided[Panels],
    transports: Provided[PlainTransports],
    now_s: Now,
    request: Request,
    token: str,
    item: Item = "",
) -> Response:
    """The possible calls, and the progress of those made."""
    caller = await _caller(access, request, token)
    if caller is None:
        return _page(panels, request, HTTPStatus.NOT_FOUND, "call-gone.html")
    return await _shown(store, projection, panels, transports, request, caller, now_s, {"item": item})


@router.api_route("/call/{token}/sign", methods=["GET", "HEAD"])
async def call_sign(
    access: Provided[Access],
    projection: Provided[Projection],
    panels: Provided[Panels],
    base_url: BaseUrl,
    request: Request,
    token: str,
) -> Response:
    """A sign to print for the place: the page's address as a QR code and as text."""
    caller = await _caller(access, request, token)
    if caller is None:
        return _page(panels, request, HTTPStatus.NOT_FOUND, "call-gone.html")
    return _page(
        panels,
        request,
        HTTPStatus.OK,
        "call-sign.html",
        place=caller.station,
        name=_name_of(projection, caller.station),
        page=f"/call/{token}",
        address=f"{base_url}/call/{token}",
        until=until(caller, TEXTS[language_of(request)]),
    )


@router.api_route("/call/{token}/code.svg", methods=["GET", "HEAD"])
async def call_code(access: Provided[Access], base_url: BaseUrl, request: Request, token: str) -> Response:
    """The page's address as a QR code."""
    if await _caller(access, request, token) is None:
        return PlainTextResponse("This key calls nothing.\n", HTTPStatus.NOT_FOUND, headers=HEADERS)
    return Response(drawn(f"{base_url}/call/{token}"), media_type="image/svg+xml", headers=HEADERS)


@router.post("/call/{token}")
async def call(
    store: Provided[Store],
    access: Provided[Access],
    projection: Provided[Projection],
    panels: Provided[Panels],
    transports: Provided[PlainTransports],
    now_s: Now,
    request: Request,
    note: Noted,
    token: str,
) -> Response:
    """Call for a transport to or from the place, once however often the form is sent."""
    caller = note.who = await _caller(access, request, token)
    note.target = ""
    if caller is None:
        note.result = "refused"
        return _page(panels, request, HTTPStatus.NOT_FOUND, "call-gone.html")
    form = await read_form(request, FIELDS)
    try:
        draft = TransportDraft.model_validate(_wanted(form, caller.station))
        note.detail |= draft.model_dump(mode="json", exclude_none=True, by_alias=True)
        kept, _ = await transports.call(
            draft,
            caller,
            # The same page, reopened and sent with other content, is another call.
            own_key(caller, f"transport {form.get('key') or new_token()} {draft.text()}"),
            lambda row: msgspec.json.encode(transport_answer(row)),
            waits=True,  # A second tap shows the first one's result, even a refusal.
        )
    except (Problem, ValidationError) as error:
        if isinstance(error, Problem) and error.kind == AT_WORK:
            return _back(token)  # The same tap twice, handled by another gateway.
        note.result = "refused"
        reason = _reason(error, language_of(request))
        return await _shown(store, projection, panels, transports, request, caller, now_s, form, reason)
    note.target = kept.order_id
    return _back(token)


@router.post("/call/{token}/{transport}/cancel")
async def call_off(
    access: Provided[Access],
    panels: Provided[Panels],
    transports: Provided[PlainTransports],
    request: Request,
    note: Noted,
    token: str,
    transport: str,
) -> Response:
    """Cancel a call of this key that is not on board; the page then says so."""
    caller = note.who = await _caller(access, request, token)
    note.target = transport
    if caller is None:
        note.result = "refused"
        return _page(panels, request, HTTPStatus.NOT_FOUND, "call-gone.html")
    try:
        found = await transports.cancel(transport, caller)
    except Problem:
        found = None
    if found is None:
        note.result = "refused"
    return _back(token)


def _wanted(form: Mapping[str, str], station: str) -> dict[str, object]:
    """The draft in a form: a material in pieces, or a named thing."""
    end, other = ("from", "to") if form.get("way") == "take" else ("to", "from")
    if "thing" in form:
        place, ability = form.get("place") or None, form.get("ability") or None
        return {"thing": form["thing"], "ability": ability, other: place, end: station}
    written = (form.get("away") if end == "from" else None) or form.get("quantity", "")
    return {"item": form.get("item", ""), "quantity": _pieces(written), end: station}


def _reason(error: Problem | ValidationError, language: str) -> str:
    """The first reason why nothing was called, in the reader's language as far as there are words for it."""
    words = REFUSALS.get(language, {})
    if isinstance(error, Problem) and not error.errors:
        return words.get(error.kind, error.detail)
    first = error.errors[0] if isinstance(error, Problem) else field_error(error.errors()[0])
    return words[first.code].format(**first.values) if first.code in words else first.reason


def _pieces(written: str) -> int:
    """The number written; 0, which is refused, if it is no number or too long."""
    return int(written) if written.isdecimal() and len(written) <= DIGITS else 0


async def _caller(access: Access, request: Request, token: str) -> Principal | None:
    """The caller of a call key; None if the key has other rights or no place.

    Raises:
        Problem: 429, too many tries.
    """
    found = await access.by_bearer(token, address_of(request.scope))
    if found is None or found.kind != "key" or found.scopes != ONLY or not found.station:
        return None
    return found


async def _shown(
    store: Store,
    projection: Projection,
    panels: Panels,
    transports: PlainTransports,
    request: Request,
    caller: Principal,
    now_s: float,
    sent: Mapping[str, str],
    refused: str = "",
) -> Response:
    texts = TEXTS[language_of(request)]
    async with store.read() as work:
        rows = await work.transports.page(TransportFilter(caller=caller.key), None, SHOWN)
    kept = tiles(projection, caller, sent.get("item", ""), texts)
    chosen = next((tile for tile in kept if tile.chosen), None)
    return _page(
        panels,
        request,
        HTTPStatus.UNPROCESSABLE_ENTITY if refused else HTTPStatus.OK,
        "call.html",
        place=caller.station,
        tiles=kept,
        things=choices(projection, caller, transports.abilities(), sent),
        longest=THING_MAX,
        chosen=chosen,
        called=called(rows, projection, caller.station, now_s, texts),
        until=until(caller, texts),
        refused="" if not refused else texts["refused"].format(reason=refused),
        key=new_token(),
        at_s=int(now_s),
        here=request.url.path,
        carried="" if chosen is None else f"item={chosen.item}",
    )


def _page(panels: Panels, request: Request, status: HTTPStatus, template: str, **context: Any) -> Response:
    language = language_of(request)
    try:
        html = panels.render(
            template,
            language=language,
            texts=TEXTS[language],
            switches=switches(language),
            **{"carried": "", **context},
        )
    except NotBuilt:
        return PlainTextResponse(NOT_BUILT, HTTPStatus.SERVICE_UNAVAILABLE, headers=HEADERS)
    answer = HTMLResponse(html, status, headers=HEADERS)
    remember_language(answer, request)
    return answer


def _name_of(projection: Projection, place: str) -> str:
    plant = projection.site.plant
    known = plant.machines.get(place) or plant.stores.get(place)
    return place if known is None else known.name or place


def _back(token: str) -> Response:
    # The list is below what can be called, on a phone out of sight.
    return RedirectResponse(f"/call/{token}#called", HTTPStatus.SEE_OTHER, headers=HEADERS)

"""Plain transports: bringing something from one place to another."""

from __future__ import annotations

from collections.abc import AsyncIterator
from http import HTTPStatus
from typing import Annotated

import msgspec
from fastapi import APIRouter, Depends, Query
from fastapi.responses import Response
from msgspec.structs import fields

from dray.gateway.access.audit_log import Noted
from dray.gateway.access.caller import Caller
from dray.gateway.access.principal import Principal, Scope
from dray.gateway.http.csv_tables import Format, Row, row_of, table, with_csv
from dray.gateway.http.problems import not_found
from dray.gateway.http.provided import Now, Provided
from dray.gateway.http.public_urls import BaseUrl
from dray.gateway.http.request_bodies import json_only, json_or_nothing
from dray.gateway.http.responses import (
    PAGE,
    Cursor,
    Json,
    Limit,
    counted,
    counted_list_of,
    created_once,
    described,
    iso,
    problems,
    read_cursor,
    write_cursor,
)
from dray.gateway.live.projection import Projection
from dray.gateway.orders.idempotency import Key, own_key
from dray.gateway.orders.order_ids import new_token
from dray.gateway.orders.shortage import Shortage, shortage_of
from dray.gateway.orders.timeline import LegView, MomentView, WayOutView
from dray.gateway.orders.transport_draft import TransportDraft
from dray.gateway.orders.transport_steps import ATTEMPTS_MOST, EVENTS_MOST
from dray.gateway.orders.transport_timeline import KINDS, TransportTimeline, transport_timeline
from dray.gateway.orders.transports import PlainTransports
from dray.gateway.orders.wanted_vehicle import why_not
from dray.gateway.routes.orders.links import (
    NO_END,
    LinkDraft,
    LinksRevoked,
    LinkView,
    NewLink,
    link_view,
    too_many_links,
)
from dray.gateway.routes.search import Words
from dray.messages import TransportState
from dray.store import Store
from dray.store.orders.tracking_links import Link
from dray.store.orders.transports import SortedBy, TransportFilter, TransportRow, place_of

router = APIRouter(tags=["transports"])


class TransportAnswer(msgspec.Struct, frozen=True, kw_only=True, rename={"source": "from"}):
    """A plain transport."""

    id: str
    status: str
    """waiting, assigned, on_board, delivered or cancelled."""
    source: str
    to: str
    item: str
    """A material; `.thing` for a `thing` without master data."""
    quantity: int
    priority: str
    vehicle: str | None = None
    """The only vehicle that may carry it."""
    vehicle_until: str | None = None
    """End of that limit; null if there is none."""
    vehicle_waits: str | None = None
    """Why that vehicle does not carry it now: gone, silent, shut_out, carried_away, out_of_service, error,
    stopped, busy, battery, charging, or its reason not to bid, such as no_way."""
    ability: str | None = None
    """Ability that its vehicle needs beside the material's."""
    called_by: str
    created_at: str
    due_at: str
    not_before: str | None = None
    """Earliest time at which it is announced."""
    cancel_at: str | None = None
    """Time of the cancellation; it is cancelled once the factory has confirmed."""
    ended_at: str | None = None
    updated_at: str
    shortage: Shortage | None = None
    """Shortage at its source that keeps it waiting, and storages with enough."""
    carrier: str | None = None
    expected_at: str | None = None
    """Time promised by its carrier."""
    task: str | None = None
    """Name of its task: GET /api/tasks has bids and refusals."""
    wait: str | None = None
    """Why no vehicle carries it: not_before before its time, no_room at the destination, short at the source,
    no_bid, or undecided yet."""
    refused: str | None = None
    """Why it was impossible, if that ended it."""
    thing: str | None = None
    """People's name for it, if it has no master data."""


EXAMPLE = TransportAnswer(
    id="T-1M9K3X2A4-K7QM",
    status="assigned",
    source="S5",
    to="M8",
    item="bearing",
    quantity=40,
    priority="normal",
    called_by="Call button M8",
    created_at="2030-01-01T10:37:00Z",
    due_at="2030-01-01T10:52:00Z",
    updated_at="2030-01-01T10:37:05Z",
    carrier="ATV6",
    expected_at="2030-01-01T10:44:00Z",
    task="T-1M9K3X2A4-K7QM-1",
)

COLUMNS = tuple(
    name for name in TransportAnswer.__struct_fields__ if name not in ("vehicle_waits", "shortage")
)
"""Columns of a table: all but momentary values."""

HEADER = tuple(each.encode_name for each in fields(TransportAnswer) if each.name in COLUMNS)

ROWS_AT_ONCE = 500
"""Transports per read for a table."""


class TransportStory(TransportTimeline, kw_only=True):
    """A whole plain transport, and the links to its page."""

    links: tuple[LinkView, ...] = ()
    """Newest first."""


STORY = TransportStory(
    attempts=(
        WayOutView(
            task="T-1M9K3X2A4-K7QM-1",
            goal="",
            item="bearing",
            quantity=40,
            source="S5",
            destination="M8",
            opened_at_s=1_893_493_020.0,
            legs=(LegView(carrier="ATV6", since_at_s=1_893_493_025.0, aboard_at_s=1_893_493_080.0),),
        ),
    ),
    moments=(
        MomentView(
            kind="called",
            at_s=1_893_493_020.0,
            agent="Call button M8",
            other="M8",
            item="bearing",
            quantity=40,
        ),
    ),
)

DRAFTS = {
    "bring": {
        "summary": "A load from a storage to a machine",
        "value": {"from": "S5", "to": "M8", "item": "bearing", "quantity": 40},
    },
    "thing": {
        "summary": "Something without master data",
        "value": {"from": "M8", "to": "S5", "thing": "pump housing for Meier", "ability": "tote"},
    },
}


@router.post(
    "/transports",
    status_code=HTTPStatus.CREATED,
    dependencies=[Depends(json_only)],
    responses={
        201: created_once(TransportAnswer, "The transport", EXAMPLE),
        **problems(
            p403="The caller's key may not call for this: a place, a material or a priority is beyond its limits",
            p409="A request with this key is still being answered",
            p429="As many transports of this caller are open as may be",
            p503="Too many transports are open",
        ),
    },
    openapi_extra={"requestBody": {"content": {"application/json": {"examples": DRAFTS}}}},
    response_class=Json,
)
async def call_transport(
    transports: Provided[PlainTransports],
    projection: Provided[Projection],
    caller: Caller,
    note: Noted,
    draft: TransportDraft,
    key: Key = None,
) -> Json:
    """Bring one load from one place to another; under one key, only once however often this is sent."""
    note.detail |= draft.model_dump(mode="json", exclude_none=True, by_alias=True)
    kept, replayed = await transports.call(
        draft,
        caller,
        None if key is None else own_key(caller, f"transport {key}"),
        lambda row: msgspec.json.encode(
            transport_answer(row, shortage=shortage_of(row, projection, caller, transports.places_of(caller)))
        ),
    )
    note.target = kept.order_id
    headers = {"Location": f"/api/transports/{kept.order_id}"}
    if replayed:
        headers["Idempotency-Replayed"] = "true"
    return Json(kept.answer.encode(), HTTPStatus.CREATED, headers=headers)


@router.get(
    "/transports",
    responses={200: with_csv(counted_list_of(TransportAnswer, "Plain transports, newest first"))},
    response_class=Json,
)
async def list_transports(
    store: Provided[Store],
    transports: Provided[PlainTransports],
    projection: Provided[Projection],
    caller: Caller,
    now_s: Now,
    words: Words,
    status: Annotated[list[TransportState] | None, Query(description="Only these; may be repeated")] = None,
    place: Annotated[
        str, Query(max_length=32, pattern=r"^[^\x00]*$", description="Only those from or to this place")
    ] = "",
    sort: Annotated[SortedBy, Query(description="`called`: by when they were called for")] = "called",
    descending: bool = True,
    cursor: Cursor = None,
    limit: Limit = PAGE,
    format: Format = "json",  # noqa: A002 - the word that others use
) -> Response:
    """All stored plain transports; a caller limited to areas sees those from and to them."""
    after = read_cursor(cursor, tuple[float, str])
    own = transports.places_of(caller)
    places = own if not place else frozenset({place}) if own is None else own & {place}

    wanted = TransportFilter(
        statuses=status or (),
        places=None if places is None else sorted(places),
        caller=_only_own(caller),
        words=words,
    )
    if format == "csv":
        return table("transports", HEADER, _rows(store, wanted, sort, descending))
    async with store.read() as work:
        rows = await work.transports.page(wanted, after, limit + 1, sort, descending=descending)
        is_all = cursor is None and len(rows) <= limit
        total = len(rows) if is_all else None if words else await work.transports.total(wanted)
    last = rows[limit - 1] if len(rows) > limit else None
    return counted(
        [
            transport_answer(row, why_not(row, projection, now_s), shortage_of(row, projection, caller, own))
            for row in rows[:limit]
        ],
        None if last is None else write_cursor(*place_of(last, sort)),
        total,
    )


async def _rows(
    store: Store, wanted: TransportFilter, sort: SortedBy, descending: bool
) -> AsyncIterator[Row]:
    """All matching transports as table cells, read page by page."""
    after: tuple[float, str] | None = None
    while True:
        async with store.read() as work:
            rows = await work.transports.page(wanted, after, ROWS_AT_ONCE, sort, descending=descending)
        for row in rows:
            yield row_of(COLUMNS, transport_answer(row))
        if len(rows) < ROWS_AT_ONCE:
            return
        after = place_of(rows[-1], sort)


@router.get(
    "/transports/{transport}",
    responses={
        200: described(TransportAnswer, "The transport", EXAMPLE),
        **problems(p404="There is no such transport"),
    },
    response_class=Json,
)
async def get_transport(
    store: Provided[Store],
    transports: Provided[PlainTransports],
    projection: Provided[Projection],
    caller: Caller,
    now_s: Now,
    transport: str,
) -> Json:
    """One plain transport."""
    async with store.read() as work:
        row = await work.transports.get(transport)
    if row is None or not transports.may_see(row, caller):
        raise not_found("transport", transport, "GET /api/transports")
    lacks = shortage_of(row, projection, caller, transports.places_of(caller))
    return Json(transport_answer(row, why_not(row, projection, now_s), lacks))


@router.get(
    "/transports/{transport}/timeline",
    responses={
        200: described(TransportStory, "How it was given out, who carried it, and what happened", STORY),
        **problems(p404="There is no such transport"),
    },
    response_class=Json,
)
async def transport_timeline_of(
    store: Provided[Store], transports: Provided[PlainTransports], caller: Caller, transport: str
) -> Json:
    """A whole plain transport: call, award, fetch, hand-over, and takeovers."""
    async with store.read() as work:
        row = await work.transports.get(transport)
        if row is None or not transports.may_see(row, caller):
            raise not_found("transport", transport, "GET /api/transports")
        tasks = await work.tasks.of_transport(transport, ATTEMPTS_MOST)
        rows = await work.events.of_tasks([task.id for task in tasks], KINDS, EVENTS_MOST + 1)
        links = await work.transport_links.to(transport)
        beginnings = await work.beginnings.all()
    told = transport_timeline(
        row, tasks, rows[:EVENTS_MOST], is_whole=len(rows) <= EVENTS_MOST, beginnings=beginnings
    )
    return Json(
        TransportStory(
            attempts=told.attempts,
            moments=told.moments,
            is_whole=told.is_whole,
            links=tuple(map(link_view, links)),
        )
    )


@router.post(
    "/transports/{transport}/links",
    status_code=HTTPStatus.CREATED,
    dependencies=[Depends(json_or_nothing)],
    responses={
        201: described(NewLink, "The link"),
        **problems(p404="There is no such transport", p409="As many links lead to its page as may be"),
    },
    response_class=Json,
)
async def make_transport_link(
    store: Provided[Store],
    transports: Provided[PlainTransports],
    caller: Caller,
    base: BaseUrl,
    now_s: Now,
    note: Noted,
    transport: str,
    draft: LinkDraft = NO_END,
) -> Json:
    """Create a link to a transport's page: content, route, progress, and expected time."""
    token, ends_s = new_token(), draft.ends_s(now_s)
    async with store.write() as work:
        row = await work.transports.get(transport)
        if row is None or not transports.may_see(row, caller):
            raise not_found("transport", transport, "GET /api/transports")
        if not await work.transport_links.add_another(token, Link(transport, now_s, expires_at_s=ends_s)):
            raise too_many_links("transport", transport)
    note.detail["days"] = draft.days
    return Json(NewLink(f"{base}/track/{token}", ends_s), HTTPStatus.CREATED)


@router.delete(
    "/transports/{transport}/links",
    responses={
        200: described(LinksRevoked, "How many were taken back by this"),
        **problems(p404="There is no such transport"),
    },
    response_class=Json,
)
async def revoke_transport_links(
    store: Provided[Store],
    transports: Provided[PlainTransports],
    caller: Caller,
    now_s: Now,
    note: Noted,
    transport: str,
) -> Json:
    """Revoke all links of a transport; their pages say so from now on."""
    async with store.write() as work:
        row = await work.transports.get(transport)
        if row is None or not transports.may_see(row, caller):
            raise not_found("transport", transport, "GET /api/transports")
        count = await work.transport_links.revoke_all(transport, now_s)
    note.detail["links"] = count
    return Json(LinksRevoked(count))


@router.post(
    "/transports/{transport}/cancel",
    responses={
        200: described(TransportAnswer, "The transport; cancelled once the factory has confirmed", EXAMPLE),
        **problems(p404="There is no such transport", p409="It is on board, or delivered"),
    },
    response_class=Json,
)
async def cancel_transport(
    transports: Provided[PlainTransports], caller: Caller, note: Noted, transport: str
) -> Json:
    """Cancel a transport that is not on board; doing it twice is harmless."""
    note.target = transport
    row = await transports.cancel(transport, caller)
    if row is None:
        raise not_found("transport", transport, "GET /api/transports")
    return Json(transport_answer(row))


def transport_answer(
    row: TransportRow, vehicle_waits: str | None = None, shortage: Shortage | None = None
) -> TransportAnswer:
    """A transport as in REST answers, with its wanted vehicle's obstacle and its source's shortage."""
    return TransportAnswer(
        id=row.id,
        status=row.status.value,
        source=row.source,
        to=row.destination,
        item=row.item,
        thing=row.thing or None,
        quantity=row.quantity,
        priority=row.priority,
        vehicle=row.vehicle or None,
        vehicle_until=None if row.vehicle_until_s is None else iso(row.vehicle_until_s),
        vehicle_waits=vehicle_waits,
        ability=row.ability or None,
        called_by=row.called_by,
        created_at=iso(row.created_at_s),
        due_at=iso(row.due_at_s),
        not_before=None if row.not_before_s is None else iso(row.not_before_s),
        cancel_at=None if row.cancel_at_s is None else iso(row.cancel_at_s),
        ended_at=None if row.ended_at_s is None else iso(row.ended_at_s),
        updated_at=iso(row.updated_at_s),
        shortage=shortage,
        carrier=row.carrier or None,
        expected_at=None if row.expected_at_s is None else iso(row.expected_at_s),
        task=row.task or None,
        wait=row.wait or None,
        refused=row.refused or None,
    )


def _only_own(caller: Principal) -> str:
    """The caller to whose transports the list is limited; empty for all."""
    return "" if caller.may(Scope.FACTORY_READ) else caller.key

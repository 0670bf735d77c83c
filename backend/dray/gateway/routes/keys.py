"""Keys for other systems and call buttons."""

from __future__ import annotations

import math
from http import HTTPStatus
from typing import Annotated

import msgspec
from fastapi import APIRouter, Depends, Path
from pydantic import BaseModel, ConfigDict, Field

from dray.gateway.access.audit_log import Noted
from dray.gateway.access.caller import Caller
from dray.gateway.access.gate import forbidden
from dray.gateway.access.people_changes import may_give
from dray.gateway.access.principal import Principal, Scope
from dray.gateway.access.tokens import new_id, new_key
from dray.gateway.http.problems import FieldError, not_found, unusable
from dray.gateway.http.provided import Now, Provided
from dray.gateway.http.public_urls import BaseUrl
from dray.gateway.http.request_bodies import LINE, json_only
from dray.gateway.http.responses import PAGE, Cursor, Json, Limit, described, list_of, page, problems
from dray.gateway.http.shares import share_of
from dray.gateway.live.projection import Projection
from dray.gateway.orders.transports import OPEN_MAX as TRANSPORTS_MAX
from dray.priorities import TRANSPORT_WITHIN_S, Priority
from dray.store import Store
from dray.store.access.api_keys import OPEN_EACH_MAX, OPEN_MAX, ApiKey

router = APIRouter(tags=["access"])

LISTED = "GET /api/keys"

DAY_S = 86_400.0

LONGEST_DAYS = 3650
"""Maximum lifetime, ten years: beyond that a key without end is better."""

NAME_CHARS = 80

NAMES_MAX = 100
"""Maximum places or materials of a key: a hall of machines. Beyond that, use all or several keys."""

KEY_OPEN_MOST = share_of(TRANSPORTS_MAX)
"""Maximum open transports of any caller."""

Name = Annotated[str, Field(min_length=1, max_length=32)]

KeyId = Annotated[str, Path(max_length=64)]


class KeyAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """A key without its token."""

    id: str
    name: str
    """Purpose of the key."""
    scopes: tuple[str, ...]
    """Its rights."""
    places: tuple[str, ...] = ()
    """Machines and storages to which its transports are limited; empty for all."""
    items: tuple[str, ...] = ()
    """Materials to which its transports are limited; empty for all."""
    open_max: int
    """Maximum open transports."""
    open_each_max: int
    """Maximum open transports per place: its own places, or the destination if it has none."""
    priority: str
    """Highest priority: low, normal, high or urgent."""
    created_at_s: float
    expires_at_s: float | None = None
    """Null if it lasts until it is revoked."""
    revoked_at_s: float | None = None
    used_at_s: float | None = None
    """Time of its last use, to the minute."""


class NewKeyAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """A new key; its token is shown only here and not stored."""

    token: str
    """For `Authorization: Bearer`."""
    key: KeyAnswer
    page_url: str | None = None
    """For a key with transports of one place as its only right: address of its page for phones. With
    `/code.svg` appended it is a QR code; with `/sign`, a page to print."""


EXAMPLE = KeyAnswer(
    id="5f0c81d2a94e",
    name="ERP",
    scopes=("orders:read", "orders:write"),
    open_max=OPEN_MAX,
    open_each_max=OPEN_EACH_MAX,
    priority=Priority.NORMAL.value,
    created_at_s=1_893_456_000.0,
    used_at_s=1_893_459_600.0,
)

NEW_EXAMPLE = NewKeyAnswer(token="dray_X7pXlvU3a0q0WmT5mDqkPzT8O1hO2b0m9l1x9mKc0aE", key=EXAMPLE)  # noqa: S106 - an example


class KeyDraft(BaseModel):
    """A key to create."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "examples": [
                {"name": "ERP", "scopes": ["orders:read", "orders:write"]},
                {
                    "name": "Button M8",
                    "scopes": ["transports:call"],
                    "places": ["M8"],
                    "items": ["bearing"],
                    "open_max": 4,
                    "priority": "high",
                },
            ]
        },
    )

    name: Annotated[str, Field(min_length=1, max_length=NAME_CHARS, pattern=LINE)]
    """Purpose of the key."""
    scopes: Annotated[list[Scope], Field(max_length=len(Scope))]
    """Its rights: at most your own."""
    days: Annotated[int, Field(ge=1, le=LONGEST_DAYS)] | None = None
    """Lifetime in days; without it, until it is revoked."""
    places: Annotated[list[Name], Field(max_length=NAMES_MAX)] = []
    """With `transports:call`: machines and storages to which it is limited; empty for all."""
    items: Annotated[list[Name], Field(max_length=NAMES_MAX)] = []
    """With `transports:call`: materials to which it is limited; empty for all."""
    open_max: Annotated[int, Field(strict=True, ge=1, le=KEY_OPEN_MOST)] | None = None
    """With `transports:call`: maximum open transports; 50 by default."""
    open_each_max: Annotated[int, Field(strict=True, ge=1, le=KEY_OPEN_MOST)] | None = None
    """With `transports:call`: maximum open transports per place; by default 20, or `open_max` if less."""
    priority: Priority | None = None
    """With `transports:call`: highest priority; normal by default. Unless it is urgent, no due time may be
    sooner than at this priority."""


@router.get("/keys", responses={200: list_of(KeyAnswer, "Keys, by id")}, response_class=Json)
async def list_keys(store: Provided[Store], cursor: Cursor = None, limit: Limit = PAGE) -> Json:
    """All keys, including invalid ones."""
    async with store.read() as work:
        keys = await work.api_keys.all()
    found = sorted((_answer(each) for each in keys), key=lambda each: each.id)
    return page(found, lambda each: each.id, cursor, limit)


@router.post(
    "/keys",
    status_code=HTTPStatus.CREATED,
    dependencies=[Depends(json_only)],
    responses={
        201: described(NewKeyAnswer, "The key, this one time", NEW_EXAMPLE),
        **problems(p403="It could do what you may not do"),
    },
    response_class=Json,
)
async def make_key(
    store: Provided[Store],
    projection: Provided[Projection],
    caller: Caller,
    base_url: BaseUrl,
    note: Noted,
    now_s: Now,
    draft: KeyDraft,
) -> Json:
    """Create a key for another system or a call button.

    A key creates none with wider limits or a longer life than its own.
    """
    scopes = tuple(dict.fromkeys(each.value for each in draft.scopes))
    places, items = tuple(dict.fromkeys(draft.places)), tuple(dict.fromkeys(draft.items))
    open_max = draft.open_max or OPEN_MAX
    open_each_max = draft.open_each_max or min(OPEN_EACH_MAX, open_max)
    priority = draft.priority or Priority.NORMAL
    note.detail = {"name": draft.name, "scopes": list(scopes), "days": draft.days}
    if Scope.TRANSPORTS_CALL in draft.scopes:
        note.detail |= {"places": list(places), "items": list(items)}
        note.detail |= {"open": open_max, "open_each": open_each_max, "priority": priority.value}
    if faults := _faults_of(draft, scopes, projection):
        raise unusable(*faults)
    if not may_give(caller, frozenset(draft.scopes)):
        raise forbidden(f"{caller.name} lacks some of these scopes itself; leave them out")
    key = ApiKey(
        id=new_id(),
        name=draft.name,
        scopes=" ".join(scopes),
        created_at_s=now_s,
        expires_at_s=None if draft.days is None else now_s + draft.days * DAY_S,
        places=" ".join(places),
        items=" ".join(items),
        open_max=open_max,
        open_each_max=open_each_max,
        priority=priority.value,
    )
    if beyond := _beyond(caller, key):
        raise forbidden(f"{caller.name} may give no key that may more than itself: {', '.join(beyond)}")
    note.target, token = key.id, new_key()
    async with store.write() as work:
        await work.api_keys.add(token, key)
    button = scopes == (Scope.TRANSPORTS_CALL.value,) and len(places) == 1
    page_url = f"{base_url}/call/{token}" if button else None
    return Json(NewKeyAnswer(token=token, key=_answer(key), page_url=page_url), HTTPStatus.CREATED)


@router.post(
    "/keys/{key}/revoke",
    responses={
        200: described(KeyAnswer, "It opens nothing any more, within a second everywhere", EXAMPLE),
        **problems(p404="There is no such key"),
    },
    response_class=Json,
)
async def revoke_key(store: Provided[Store], note: Noted, now_s: Now, key: KeyId) -> Json:
    """Revoke a key."""
    async with store.write() as work:
        known = None if "\0" in key else await work.api_keys.get(key)
        if known is None:
            raise not_found("key", key, LISTED)
        await work.api_keys.revoke(key, now_s)
        taken_back = await work.api_keys.get(key)
    assert taken_back is not None  # noqa: S101 - keys are never removed
    note.detail["name"] = known.name
    return Json(_answer(taken_back))


def _beyond(caller: Principal, key: ApiKey) -> list[str]:
    """The fields in which a new key would exceed the key that creates it."""
    beyond, ends_s, limits = [], caller.expires_at_s, caller.calls
    if caller.kind == "key" and ends_s is not None and (key.expires_at_s or math.inf) > ends_s:
        beyond.append("days")
    if limits is None or Scope.TRANSPORTS_CALL.value not in key.scopes.split():
        return beyond
    for field, own in (("places", limits.places), ("items", limits.items)):
        given = set(getattr(key, field).split())
        if own and not (given and given <= own):
            beyond.append(field)
    bounds = ("open_max", "open_each_max")
    beyond += [field for field in bounds if getattr(key, field) > getattr(limits, field)]
    if TRANSPORT_WITHIN_S[Priority(key.priority)] < TRANSPORT_WITHIN_S[limits.priority]:
        beyond.append("priority")
    return beyond


def _faults_of(draft: KeyDraft, scopes: tuple[str, ...], projection: Projection) -> list[FieldError]:
    plant = projection.site.plant
    if not scopes:
        return [FieldError.of("scopes", "scope_needed")]
    if Scope.TRANSPORTS_CALL not in draft.scopes:
        limits = ("places", "items", "open_max", "open_each_max", "priority")
        return [FieldError.of(each, "calls_only") for each in limits if getattr(draft, each)]
    known = {*plant.machines, *plant.stores}
    faults = [
        FieldError.of(f"places[{index}]", "place_unknown", place=place)
        for index, place in enumerate(draft.places)
        if place not in known
    ]
    faults += [
        FieldError.of(f"items[{index}]", "material_unknown", item=item)
        for index, item in enumerate(draft.items)
        if item not in plant.materials
    ]
    if draft.open_each_max is not None and draft.open_each_max > (most := draft.open_max or OPEN_MAX):
        faults.append(FieldError.of("open_each_max", "bound_above_all", most=most))
    return faults


def _answer(key: ApiKey) -> KeyAnswer:
    return KeyAnswer(
        id=key.id,
        name=key.name,
        scopes=tuple(key.scopes.split()),
        places=tuple(key.places.split()),
        items=tuple(key.items.split()),
        open_max=key.open_max,
        open_each_max=key.open_each_max,
        priority=key.priority,
        created_at_s=key.created_at_s,
        expires_at_s=key.expires_at_s,
        revoked_at_s=key.revoked_at_s,
        used_at_s=key.used_at_s,
    )

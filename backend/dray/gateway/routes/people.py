"""People: who may log in, their areas, and their secrets."""

from __future__ import annotations

from collections.abc import Sequence
from http import HTTPStatus
from typing import Annotated, Literal

import msgspec
from fastapi import APIRouter, Depends, Path
from pydantic import BaseModel, ConfigDict, Field

from dray.gateway.access.access import Access
from dray.gateway.access.audit_log import Noted
from dray.gateway.access.caller import Caller
from dray.gateway.access.gate import forbidden
from dray.gateway.access.login.invitations import LIFE_S, invite
from dray.gateway.access.login.login import BADGE_SALT
from dray.gateway.access.login.secrets import WeakSecret, check_badge, check_password, check_pin
from dray.gateway.access.people_changes import LOGIN_NAME, change, may_decide_on
from dray.gateway.access.principal import Principal, Role
from dray.gateway.http.problems import FieldError, Problem, not_found, unusable
from dray.gateway.http.provided import Now, Provided
from dray.gateway.http.public_urls import BaseUrl
from dray.gateway.http.request_bodies import Line, json_only
from dray.gateway.http.responses import PAGE, Cursor, Json, Limit, described, list_of, page, problems
from dray.gateway.live.projection import Projection
from dray.store import Store
from dray.store.access.people import Person
from dray.store.work import Work

router = APIRouter(tags=["access"])

LISTED = "GET /api/people"

PersonId = Annotated[str, Path(max_length=64)]

Areas = Annotated[list[str], Field(max_length=64)]
"""Ids of areas."""

SecretKind = Literal["password", "pin", "badge"]

UNKNOWN = "There is no such person"


class PersonAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """A person who may, or might, log in."""

    id: str
    """Login name; never given to another person."""
    name: str
    role: str
    """manager or operator."""
    areas: tuple[str, ...] = ()
    """Areas of an operator; a manager works everywhere."""
    secrets: tuple[str, ...] = ()
    """Those set of password, pin and badge; without any, only a link logs in."""
    created_at_s: float
    disabled_at_s: float | None = None
    """Time since which login is disabled; null if it is allowed."""


class LoginLinkAnswer(msgspec.Struct, frozen=True):
    """A link that logs a person in once; it is shown only here and not stored."""

    url: str
    expires_at_s: float


EXAMPLE = PersonAnswer(
    id="operator-area1",
    name="Operator, North",
    role="operator",
    areas=("AREA1",),
    secrets=("pin",),
    created_at_s=1_893_456_000.0,
)

LINK_EXAMPLE = LoginLinkAnswer(
    "https://dray.example/login/X7pXlvU3a0q0WmT5mDqkPzT8O1hO2b0m9l1x9mKc0aE", 1_893_542_400.0
)


class PersonDraft(BaseModel):
    """A new person."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "examples": [
                {"id": "operator-area1", "name": "Operator, North", "role": "operator", "areas": ["AREA1"]}
            ]
        },
    )

    id: Annotated[str, Field(min_length=1, max_length=64)]
    """Login name: small letters, digits, . _ and -."""
    name: Line
    """Name for people."""
    role: Role
    areas: Areas = []
    """Areas of an operator."""


class AreasDraft(BaseModel):
    """An operator's new areas."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"examples": [{"areas": ["AREA1", "AREA2"]}]})

    areas: Areas


class SecretDraft(BaseModel):
    """A person's secret: a manager's password; an operator's PIN or badge code."""

    model_config = ConfigDict(
        extra="forbid", json_schema_extra={"examples": [{"kind": "pin", "secret": "40718293"}]}
    )

    kind: SecretKind
    secret: Annotated[str, Field(min_length=1, max_length=1024)]


@router.get("/people", responses={200: list_of(PersonAnswer, "People, by id")}, response_class=Json)
async def list_people(store: Provided[Store], cursor: Cursor = None, limit: Limit = PAGE) -> Json:
    """All people, including disabled ones."""
    async with store.read() as work:
        people = await work.people.all()
    return page([_answer(each) for each in people], lambda each: each.id, cursor, limit)


@router.post(
    "/people",
    status_code=HTTPStatus.CREATED,
    dependencies=[Depends(json_only)],
    responses={
        201: described(PersonAnswer, "They may log in, by a link at first", EXAMPLE),
        **problems(p403="You may not do this yourself"),
    },
    response_class=Json,
)
async def add_person(
    store: Provided[Store],
    projection: Provided[Projection],
    caller: Caller,
    note: Noted,
    now_s: Now,
    draft: PersonDraft,
) -> Json:
    """Add a person; afterwards give them a link, a password, a PIN or a badge."""
    note.target, note.detail = draft.id, {"role": draft.role.value, "areas": list(draft.areas)}
    _decides(caller, draft.role)
    faults = _faults_of(draft.role, draft.areas, projection)
    if not LOGIN_NAME.fullmatch(draft.id):
        faults.insert(0, FieldError.of("id", "login_name"))
    if faults:
        raise unusable(*faults)
    areas = tuple(dict.fromkeys(draft.areas))
    person = Person(id=draft.id, name=draft.name, role=draft.role.value, created_at_s=now_s, areas=areas)
    async with store.write() as work:
        if await work.people.get(draft.id) is not None:
            raise unusable(FieldError.of("id", "name_taken", name=draft.id))
        await work.people.add(person)
    return Json(_answer(person), HTTPStatus.CREATED)


@router.post(
    "/people/{person}/link",
    status_code=HTTPStatus.CREATED,
    responses={201: described(LoginLinkAnswer, "The link", LINK_EXAMPLE), **problems(p404=UNKNOWN)},
    response_class=Json,
)
async def make_login_link(
    store: Provided[Store], base: BaseUrl, caller: Caller, now_s: Now, person: PersonId
) -> Json:
    """Create a link that logs a person in once within a day; earlier links become invalid."""
    async with store.write() as work:
        known = await _known(work, person, caller)
        if known.disabled_at_s is not None:
            raise Problem(
                HTTPStatus.CONFLICT,
                "disabled",
                "They may not log in",
                f"{person} may not log in: allow it first",
            )
        token = await invite(work, person, now_s)
    return Json(LoginLinkAnswer(f"{base}/login/{token}", now_s + LIFE_S), HTTPStatus.CREATED)


@router.put(
    "/people/{person}/secret",
    dependencies=[Depends(json_only)],
    responses={
        200: described(PersonAnswer, "It lets them in; all earlier logins have ended", EXAMPLE),
        **problems(p404=UNKNOWN, p503="Too many log in at this moment"),
    },
    response_class=Json,
)
async def give_secret(
    store: Provided[Store],
    access: Provided[Access],
    caller: Caller,
    note: Noted,
    now_s: Now,
    person: PersonId,
    draft: SecretDraft,
) -> Json:
    """Give a manager a password, or an operator a PIN or a badge."""
    note.detail["kind"] = draft.kind
    async with store.write() as work:
        known = await _known(work, person, caller)
        salt = await work.secrets.get(BADGE_SALT)
    if (known.role == Role.MANAGER) != (draft.kind == "password"):
        raise unusable(FieldError.of("kind", "secret_of_other_role"))
    _check(draft, person)
    with access.hasher.place() as place:
        if draft.kind == "badge":
            columns = {"badge_hash": await place.badge_hash(draft.secret, salt)}
        else:
            columns = {f"{draft.kind}_hash": await place.hash(draft.secret)}
    async with store.write() as work:
        badge = columns.get("badge_hash")
        if badge is not None and (other := await work.people.with_badge(badge)) and other.id != person:
            raise unusable(FieldError.of("secret", "badge_taken"))
        await change(work, person, now_s, **columns)
        changed = await _known(work, person, caller)
    return Json(_answer(changed))


@router.put(
    "/people/{person}/areas",
    dependencies=[Depends(json_only)],
    responses={200: described(PersonAnswer, "They work there", EXAMPLE), **problems(p404=UNKNOWN)},
    response_class=Json,
)
async def move_person(
    store: Provided[Store],
    projection: Provided[Projection],
    caller: Caller,
    note: Noted,
    person: PersonId,
    draft: AreasDraft,
) -> Json:
    """Set an operator's areas."""
    note.detail["areas"] = list(draft.areas)
    async with store.write() as work:
        known = await _known(work, person, caller)
        if faults := _faults_of(Role(known.role), draft.areas, projection):
            raise unusable(*faults)
        await work.people.move(person, dict.fromkeys(draft.areas))
        moved = await _known(work, person, caller)
    return Json(_answer(moved))


@router.post(
    "/people/{person}/disable",
    responses={
        200: described(PersonAnswer, "They are logged out everywhere", EXAMPLE),
        **problems(p404=UNKNOWN, p409="It is you"),
    },
    response_class=Json,
)
async def disable_person(store: Provided[Store], caller: Caller, now_s: Now, person: PersonId) -> Json:
    """Disable a person's login, at once and everywhere."""
    if caller.kind == "person" and caller.id == person:
        raise Problem(
            HTTPStatus.CONFLICT,
            "yourself",
            "That is you",
            "nobody locks themselves out: ask another manager to do it",
        )
    return await _set(store, caller, person, now_s, disabled_at_s=now_s)


@router.post(
    "/people/{person}/enable",
    responses={200: described(PersonAnswer, "They may log in again", EXAMPLE), **problems(p404=UNKNOWN)},
    response_class=Json,
)
async def enable_person(store: Provided[Store], caller: Caller, now_s: Now, person: PersonId) -> Json:
    """Enable a person's login again."""
    return await _set(store, caller, person, now_s, disabled_at_s=None)


async def _set(
    store: Store, caller: Principal, person: str, now_s: float, *, disabled_at_s: float | None
) -> Json:
    async with store.write() as work:
        await _known(work, person, caller)
        await change(work, person, now_s, disabled_at_s=disabled_at_s)
        changed = await _known(work, person, caller)
    return Json(_answer(changed))


async def _known(work: Work, person: str, caller: Principal) -> Person:
    """A person whom the caller may manage.

    Raises:
        Problem: 404, no such person; 403, the person has rights that the caller lacks.
    """
    known = await work.people.get(person)
    if known is None:
        raise not_found("person", person, LISTED)
    _decides(caller, known.role)
    return known


def _decides(caller: Principal, role: str) -> None:
    if caller.kind == "key" and (
        caller.expires_at_s is not None or (caller.calls and (caller.calls.places or caller.calls.items))
    ):
        raise forbidden(
            f"{caller.name} ends, or is bound to places or materials, and a person is not; ask somebody who is not so bound"
        )
    if not may_decide_on(caller, role):
        raise forbidden(f"a {role} may do more than {caller.name}; only who may do all that decides on them")


def _faults_of(role: Role, areas: Sequence[str], projection: Projection) -> list[FieldError]:
    """Faults of the areas for a person of this role."""
    if role is Role.MANAGER:
        return [FieldError.of("areas", "area_none")] if areas else []
    there = projection.site.plant.areas
    named = ", ".join(there)
    if not areas:
        return [FieldError.of("areas", "area_needed", areas=named)]
    return [
        FieldError.of("areas", "area_unknown", area=each, areas=named) for each in areas if each not in there
    ]


def _check(draft: SecretDraft, person: str) -> None:
    try:
        match draft.kind:
            case "password":
                check_password(draft.secret, person)
            case "pin":
                check_pin(draft.secret)
            case "badge":
                check_badge(draft.secret)
    except WeakSecret as weak:
        raise unusable(FieldError.of("secret", weak.code, **weak.values)) from None


def _answer(person: Person) -> PersonAnswer:
    kept = {"password": person.password_hash, "pin": person.pin_hash, "badge": person.badge_hash}
    return PersonAnswer(
        id=person.id,
        name=person.name,
        role=person.role,
        areas=person.areas,
        secrets=tuple(name for name, value in kept.items() if value),
        created_at_s=person.created_at_s,
        disabled_at_s=person.disabled_at_s,
    )

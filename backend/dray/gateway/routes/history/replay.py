"""Replay: the plant as panels showed it at a stored moment, agents' knowledge then, and activities."""

from __future__ import annotations

import asyncio
from http import HTTPStatus
from typing import Annotated

import msgspec
from fastapi import APIRouter, Query, Response

from dray.gateway.access.caller import Caller
from dray.gateway.access.principal import Scope
from dray.gateway.http.problems import FieldError, Problem, not_found, unusable
from dray.gateway.http.provided import Now, Provided
from dray.gateway.http.responses import Json, described, in_turns, problems
from dray.gateway.live.frames import Snapshot
from dray.gateway.live.replay.knowledge import (
    TELLING,
    KnowledgeView,
    KnownView,
    RecordedFactView,
    knowledge,
)
from dray.gateway.live.replay.reader import FilmView, OverviewView, ReplayReader, StretchView
from dray.gateway.live.replay.recorder import Mark
from dray.gateway.live.views import FactoryView
from dray.gateway.live.views.base import View
from dray.gateway.live.visibility import goal_alias
from dray.gateway.orders.drafts import Moment
from dray.gateway.routes.history.events import Words
from dray.store import Store
from dray.store.replay.spells import Spell

router = APIRouter(tags=["history"])

FILM_MOST_S = 3600.0
"""Maximum wall seconds of one film; the next answer continues it."""

SHIFT_S, HALF_HOUR_S = 8 * 3600.0, 1800.0

OVERVIEW_MOST_S = 35 * 86_400.0

SPELLS_MOST = 20_000
"""Maximum spells per answer: a shift of 20 vehicles."""

EVENTS_MOST = 2_000
"""Maximum events read for one agent's knowledge: some transports with some tens each."""

NOT_KEPT = problems(p404="Nothing is kept of that moment, nor of any before it")


class SpellsView(View, kw_only=True):
    """What agents did."""

    items: tuple[Spell, ...]
    """In order of end; present ones last."""
    is_whole: bool
    """Whether these are all."""


_AT_S = 1_893_456_000.0

_PICTURE = Snapshot(
    number=0,
    at_s=_AT_S,
    plant="figure-1",
    factory=FactoryView(),
    atvs=(),
    machines=(),
    tasks=(),
    orders=(),
)

_TOOK = RecordedFactView(kind="CarrierChanged", agent="M9", at_s=_AT_S + 6.8, other="ATV1", reason="silent")

EXAMPLES = (
    _PICTURE,
    FilmView(snapshot=_PICTURE, until_at_s=_AT_S + 20),
    OverviewView(
        kept_from_at_s=_AT_S - 3600,
        kept_until_at_s=_AT_S,
        stretches=(StretchView(from_at_s=_AT_S - 3600, until_at_s=_AT_S),),
        density=(4, 9, 2),
        marks=(
            Mark(
                at_s=_AT_S - 60, kind="takeover", about="took_over", agent="ATV1", other="ATV3", task="M9-12"
            ),
        ),
    ),
    KnowledgeView(
        agent="ATV3",
        at_s=_AT_S + 7,
        items=(
            KnownView(
                about="task",
                differs=True,
                task="M9-12",
                item="bearing",
                source="S5",
                destination="M9",
                role="primary",
                knew=RecordedFactView(kind="ContractTaken", agent="ATV3", at_s=_AT_S - 320, role="primary"),
                happened=_TOOK,
                learnt_at_s=_AT_S + 12.4,
            ),
        ),
    ),
    SpellsView(
        items=(
            Spell(
                agent="ATV1",
                doing="carries",
                from_at_s=_AT_S,
                until_at_s=_AT_S + 84,
                task="M9-12",
                item="bearing",
                source="S5",
                destination="M9",
            ),
        ),
        is_whole=True,
    ),
)
"""One example per answer."""


@router.get("/replay", responses={200: described(Snapshot, "The picture"), **NOT_KEPT}, response_class=Json)
async def get_picture(
    replay: Provided[ReplayReader], caller: Caller, now_s: Now, at: Moment | None = None
) -> Response:
    """The plant as panels showed it `at` a moment, as the stream's first frame; the present without `at`.

    `at_s` of the answer is the time of its last frame: if that is much earlier, nothing was recorded in
    between.
    """
    if at is None:
        return in_turns(await replay.snapshot_now(caller, now_s))
    at_s = at.timestamp()
    picture = await replay.film(caller, at_s, at_s, 0.0, lambda film: msgspec.json.encode(film.snapshot))
    if picture is None:
        raise _not_kept()
    return in_turns(picture)


@router.get("/replay/film", responses={200: described(FilmView, "The film"), **NOT_KEPT}, response_class=Json)
async def get_film(
    replay: Provided[ReplayReader],
    caller: Caller,
    now_s: Now,
    since: Moment | None = None,
    until: Moment | None = None,
    every_s: Annotated[float, Query(ge=0, le=600, description="Wall seconds between two frames")] = 0.0,
) -> Response:
    """The picture of a moment and the frames after it; frames closer than `every_s` are joined.

    At most an hour, and less if one answer cannot hold more: `until_at_s` has the end. Without `since`, only
    the present picture.
    """
    if since is None:
        snapshot = msgspec.Raw(await replay.snapshot_now(caller, now_s))
        picture = {"snapshot": snapshot, "frames": (), "until_at_s": now_s}
        return in_turns(await asyncio.to_thread(msgspec.json.encode, picture))
    since_s = since.timestamp()
    until_s = since_s if until is None else until.timestamp()
    if not since_s <= until_s <= since_s + FILM_MOST_S:
        raise unusable(
            FieldError("until", f"give a moment from since on, {FILM_MOST_S:g} s after it at most")
        )
    film = await replay.film(caller, since_s, until_s, every_s, msgspec.json.encode)
    if film is None:
        raise _not_kept()
    return in_turns(film)


@router.get(
    "/replay/overview", responses={200: described(OverviewView, "What there is to see")}, response_class=Json
)
async def get_overview(
    replay: Provided[ReplayReader],
    caller: Caller,
    now_s: Now,
    since: Moment | None = None,
    until: Moment | None = None,
    steps: Annotated[int, Query(ge=1, le=500, description="Parts in which changes are counted")] = 160,
) -> Json:
    """What is recorded of a period, by default of the last eight hours.

    The number of changes in each part, and takeovers, failures, alerts and late orders as marks.
    """
    since_s, until_s = _span(since, until, now_s, SHIFT_S)
    overview = await replay.overview(since_s, until_s, steps, orders=caller.may(Scope.ORDERS_READ))
    return Json(overview)


@router.get(
    "/agents/{agent}/knowledge",
    responses={
        200: described(KnowledgeView, "What it knew"),
        **problems(p404="There was no such agent, or nothing is kept of that moment"),
    },
    response_class=Json,
)
async def get_knowledge(
    replay: Provided[ReplayReader],
    store: Provided[Store],
    caller: Caller,
    now_s: Now,
    agent: str,
    at: Moment | None = None,
) -> Json:
    """What an agent knew of its transports at a moment (default: now), beside what had really happened.

    Without `orders:read`, goals have aliases, as in `GET /api/events`.
    """
    if at is None:
        of = await replay.involvement_now(agent, now_s)
    elif (found := await replay.involvement(agent, at.timestamp())) is not None:
        of = found
    else:
        raise _not_kept()
    if not of.is_known:
        raise not_found("agent", agent, "GET /api/replay")
    async with store.read() as work:
        kinds = tuple(kind.__name__ for kind in TELLING)
        rows = await work.events.of_tasks(tuple(of.roles), kinds, EVENTS_MOST)
    known = knowledge(of, rows)
    if not caller.may(Scope.ORDERS_READ):
        items = tuple(msgspec.structs.replace(each, task=goal_alias(each.task)) for each in known.items)
        known = msgspec.structs.replace(known, items=items)
    return Json(known)


@router.get("/spells", responses={200: described(SpellsView, "What they did")}, response_class=Json)
async def list_spells(
    replay: Provided[ReplayReader],
    now_s: Now,
    since: Moment | None = None,
    until: Moment | None = None,
    agent: Words = None,
) -> Json:
    """The activities of vehicles and machines with begin and end, by default of the last half hour.

    `agent` may be repeated; without it, all agents.

    A vehicle `fetches`, `carries`, `waits` (for `other`), `charges`, is `idle` (and watches `other`), `stopped`, `blocked`, `out` of
    service or `silent`; a machine `makes`, `starves` (`other` is what it lacks), is `idle`, `blocked`, `broken`, `out` or `silent`.
    """
    since_s, until_s = _span(since, until, now_s, HALF_HOUR_S)
    found = await replay.spells(since_s, until_s, tuple(agent or ()), SPELLS_MOST + 1)
    return Json(SpellsView(items=tuple(found[:SPELLS_MOST]), is_whole=len(found) <= SPELLS_MOST))


def _span(since: Moment | None, until: Moment | None, now_s: float, usual_s: float) -> tuple[float, float]:
    until_s = now_s if until is None else until.timestamp()
    since_s = until_s - usual_s if since is None else since.timestamp()
    if not since_s < until_s <= since_s + OVERVIEW_MOST_S:
        raise unusable(FieldError("until", "give a moment after since, 35 days after it at most"))
    return since_s, until_s


def _not_kept() -> Problem:
    return Problem(
        HTTPStatus.NOT_FOUND,
        "not-kept",
        "Nothing is kept of that moment",
        "nothing was recorded then, or it is older than what is kept; GET /api/replay/overview says from when on there is something",
    )

"""Wait rules: when vehicles that wait for one another need a person. Pure rules.

Most waits end by themselves and need nobody.
"""

from __future__ import annotations

from collections.abc import Collection, Container, Iterator, Mapping

from msgspec.structs import replace

from dray.gateway.live.projection.alerting.alert_rules import Moment
from dray.gateway.live.projection.right_of_way.waits import Waits
from dray.gateway.live.reasons import jam_text, told
from dray.gateway.live.views import CauseView, WaitView
from dray.gateway.live.views.alert import Condition

LONG_WAIT_S = 120.0
"""Factory seconds that a vehicle may wait for others."""

CIRCLE_S = 30.0
"""Factory seconds that vehicles may wait in a circle: normally one makes room within a few."""

UNHEARD_S = 30.0
"""Factory seconds that a vehicle may wait for one that was never heard: a vehicle that joined is heard by
then."""

JAM_LEAST = 3
"""Minimum vehicles waiting for the same thing that make a jam, when one has waited long."""


def of_waits(waits: Waits, told_of: Container[str], now: Moment) -> Iterator[Condition]:
    """Jams with all their vehicles, long waits elsewhere, and unheard vehicles that block others.

    A group without a task is not late: idle vehicles that look for room need nobody.

    Args:
        waits: who waits for whom, as of now.
        told_of: vehicles that have a graver alert.
        now: the moment of the look.
    """
    present_s = now.to_wall_s(min(now.plant_s, now.heard_s))
    behind: dict[str, list[WaitView]] = {}
    for view in waits.views():
        behind.setdefault(_end(view, waits), []).append(view)
    for views in behind.values():
        views.sort(key=lambda view: (view.since_at_s, view.id))
        if not any(waits.has_task(view.id) for view in views):
            continue
        unheard = waits.unheard_at_end(views[0].id)
        if unheard is not None and now.heard_s - unheard[1] > UNHEARD_S:
            yield Condition(kind="atv_unheard", agent=unheard[0], agents=tuple(view.id for view in views))
            continue
        long = [view for view in views if (present_s - view.since_at_s) * now.speed > LONG_WAIT_S]
        if _is_circle_stuck(views, waits, present_s, now.speed) or (len(views) >= JAM_LEAST and long):
            yield _jam(views, waits)
            continue
        for view in long:
            if view.id not in told_of and waits.has_task(view.id):
                cause = told(CauseView(wait=view.cause))
                yield Condition(kind="atv_waits", agent=view.id, cause=cause)


def of_recovery_polls(awaited: Mapping[str, Collection[str]]) -> Iterator[Condition]:
    """Vehicles that were not heard since reservation tables were lost, so that nothing is granted there.

    Args:
        awaited: by vehicle, the keepers that await its answer.
    """
    for atv, keepers in sorted(awaited.items()):
        yield Condition(kind="atv_awaited", agent=atv, keepers=tuple(sorted(keepers)))


def _end(view: WaitView, waits: Waits) -> str:
    """The common end of a chain of waits: a dock, a circle, or a vehicle."""
    chain = waits.chain(view.id)
    if chain.circle:
        return chain.circle[0]
    return view.cause.place or chain.last or view.id


def _is_circle_stuck(views: list[WaitView], waits: Waits, present_s: float, speed: float) -> bool:
    circle = waits.chain(views[0].id).circle
    since_s = {view.id: view.since_at_s for view in views}
    return bool(circle) and all(
        atv in since_s and (present_s - since_s[atv]) * speed > CIRCLE_S for atv in circle
    )


def _jam(views: list[WaitView], waits: Waits) -> Condition:
    first = views[0]
    chain = waits.chain(first.id)
    ends = chain.circle or (chain.last or first.id,)
    vehicles = tuple(view.id for view in views)
    cause = replace(first.cause, chain=ends, more=0)
    return Condition(
        kind="jam",
        agent=ends[0],
        place=cause.place,
        agents=vehicles,
        cause=CauseView(wait=cause, text=jam_text(vehicles, cause)),
    )

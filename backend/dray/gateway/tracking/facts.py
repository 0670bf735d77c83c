"""Facts about one order: the past from SQL, the present from the projection."""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum

import msgspec

from dray.gateway.live.projection import Projection
from dray.gateway.live.projection.orders import first_to_make
from dray.gateway.live.views import MachineView
from dray.gateway.tracking.eta import History
from dray.gateway.tracking.reasons import Doing
from dray.gateway.tracking.track import Facts
from dray.plant.model import MachineSpec
from dray.protocol.liveness.suspicion import IDLE_INTERVAL_S
from dray.store import Store
from dray.store.history.beginnings import Beginning
from dray.store.orders.orders import Order
from dray.store.orders.progress import ENDED, Goal
from dray.store.orders.tracking_links import Link
from dray.store.work import Work

KEPT_S = 90 * 86_400.0
"""Seconds after the end of an order or transport for which a link without its own end works: three months for
complaints and bills."""

SILENCE_S = (10.0, 12 * IDLE_INTERVAL_S)
"""Silence after which a machine's activity is unknown, in wall seconds and in factory seconds: twelve
heartbeats of an idle machine, and at least the delay of a slow link."""


class NoPage(StrEnum):
    """Why a token has no page."""

    UNKNOWN = "unknown"
    REVOKED = "revoked"
    EXPIRED = "expired"


class Found(msgspec.Struct, frozen=True):
    """The result for a token."""

    facts: Facts | None
    why: NoPage | None = None
    """Set without facts."""


async def facts_of(store: Store, projection: Projection, token: str, now_s: float) -> Found:
    """All facts about the order of a link.

    Args:
        store: the past.
        projection: the present.
        token: the link's token.
        now_s: wall clock.
    """
    async with store.read() as work:
        link = await work.links.find(token)
        order = None if link is None else await work.orders.get(link.subject)
        if link is None or order is None:
            return Found(None, NoPage.UNKNOWN)
        ended_at_s = order.delivered_at_s or order.cancelled_at_s
        why = ended(link, ended_at_s if order.status in ENDED else None, now_s)
        if why is not None:
            return Found(None, why)
        return Found(await facts_of_order(projection, work, order, now_s))


def ended(link: Link, ended_at_s: float | None, now_s: float) -> NoPage | None:
    """Why a link has ended; None if it has not.

    Args:
        link: the link.
        ended_at_s: end of its order or transport; None while it goes on.
        now_s: wall clock.
    """
    if link.revoked_at_s is not None:
        return NoPage.REVOKED
    ends_s = link.expires_at_s
    if ends_s is None and ended_at_s is not None:
        ends_s = ended_at_s + KEPT_S
    return NoPage.EXPIRED if ends_s is not None and ends_s <= now_s else None


async def facts_of_order(projection: Projection, work: Work, order: Order, now_s: float) -> Facts:
    """All facts about an order.

    Args:
        projection: the present.
        work: the past.
        order: the order.
        now_s: wall clock.
    """
    site = projection.site
    names = {**site.former, **{product.id: product.name for product in site.plant.file.products}}
    goals = tuple((await work.goals.of_orders([order.id]))[order.id])
    former = ended_by_beginning(goals, await work.beginnings.all())
    anew_s = max((goal.told_at_s or 0.0 for goal in former), default=0.0)
    # Of an order that began once more from nothing, only what has happened since counts.
    is_whole = any(goal.delivered and (goal.told_at_s or 0.0) <= anew_s for goal in goals)
    times = await work.milestones.of_order(order.id, 0.0 if is_whole else anew_s)
    if order.status in ENDED:
        return Facts(order=order, now_s=now_s, names=names, goals=goals, times=times)
    speed = projection.speed
    machine_of = {goal.id: goal.machine for goal in goals}
    ids = {goal.id for goal in goals}
    way_s = [projection.tasks.transports.quantile_s(part) for part in (0.1, 0.9)]
    machines = {goal.machine: projection.machines.view(goal.machine) for goal in goals if goal.machine}
    heard_s = now_s - max(SILENCE_S[0], SILENCE_S[1] / speed)
    doings = {goal.id: _doing(goal, machines.get(goal.machine), heard_s) for goal in goals}
    return Facts(
        order=order,
        now_s=now_s,
        names=names,
        goals=goals,
        times=times,
        former=frozenset(goal.id for goal in former),
        piece_times_s=await work.milestones.piece_times_s(ids),
        doings=doings,
        begun=projection.orders.begun(order.id),
        lacking={goal.id: projection.orders.lacking(goal.id, goal.machine) for goal in goals if goal.machine},
        working={
            goal.id: working for goal in goals if (working := projection.working_of(goal.machine)) is not None
        },
        ahead_s={
            goal.id: _ahead_s(goal, machine, site.plant.machines.get(goal.machine)) / speed
            for goal in goals
            if doings[goal.id] is Doing.BUSY and (machine := machines.get(goal.machine)) is not None
        },
        moved={
            goal: moved
            for goal, moved in (await work.milestones.moved_promises(ids)).items()
            if moved.machine == machine_of[goal]
        },
        speed=speed,
        history=History(
            await work.milestones.promises_missed_by_s(),
            None if way_s[0] is None or way_s[1] is None else (way_s[0] / speed, way_s[1] / speed),
        ),
        waits=bool(projection.orders.waits(order.id)),
        held_up=any(
            task.trouble for task in projection.tasks.views() if task.goal in ids and task.kind == "transport"
        ),
    )


def ended_by_beginning(goals: Iterable[Goal], beginnings: Iterable[Beginning]) -> tuple[Goal, ...]:
    """Those goals that ended because the factory was started without a memory of them."""
    moments_s = {each.at_s for each in beginnings}
    return tuple(goal for goal in goals if goal.over and goal.told_at_s in moments_s)


def _doing(goal: Goal, machine: MachineView | None, heard_s: float) -> Doing:
    """A machine's activity, seen from one of its goals.

    Args:
        goal: the goal.
        machine: its machine's last report.
        heard_s: earliest valid time of that report.
    """
    if machine is None or machine.seen_at_s < heard_s:
        return Doing.SILENT
    if machine.status == "error":
        return Doing.BROKEN
    if goal.id != first_to_make(machine.goals):
        return Doing.BUSY
    return Doing.STARVED if machine.status == "starved" else Doing.MAKING


def _ahead_s(goal: Goal, machine: MachineView, spec: MachineSpec | None) -> float:
    """A machine's work until all of a goal is made, in factory seconds; 0 where its queue does not have it."""
    queue = [each for each in machine.goals if each.made < each.quantity]
    places = [each.goal for each in queue]
    if spec is None or goal.id not in places or machine.speed_frac <= 0.0:
        return 0.0
    cycle_s = {making.product: making.cycle_s for making in spec.makes}
    until = queue[: places.index(goal.id) + 1]
    work_s = sum((each.quantity - each.made) * cycle_s.get(each.product, 0.0) for each in until)
    return work_s / machine.speed_frac

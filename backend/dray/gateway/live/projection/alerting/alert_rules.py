"""Alert rules: what is wrong with machines, storages, vehicles, transports and orders. Pure rules.

Each thing has at most one trouble at a time, the gravest: a silent machine is not reported as starved too.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Mapping

import msgspec
from msgspec import UNSET

from dray.gateway.live.projection.agents.disputes import Disputes
from dray.gateway.live.projection.agents.loads import doubts_of
from dray.gateway.live.projection.agents.silence import LEAST_S, Silence, plant_bound_s
from dray.gateway.live.projection.auctions.tasks import Tasks
from dray.gateway.live.projection.materials import Materials
from dray.gateway.live.reasons import detail_of
from dray.gateway.live.views import OrderView, TaskView
from dray.gateway.live.views.alert import AlertKind, CallKind, Condition
from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    CallPlace,
    CallState,
    DocumentState,
    HelpCall,
    Link,
    MachineHeartbeat,
    MachineStatus,
    StationHeartbeat,
    StrategistHeartbeat,
)
from dray.messages.heartbeat import DockWait
from dray.messages.keys import GATE
from dray.overload import Overload
from dray.plant.charger_queue import RESERVE_FRAC
from dray.protocol.liveness.suspicion import GOAL_SILENCE_S, AnyHeartbeat
from dray.store.factory.exclusions import Exclusion
from dray.store.history.clocks import Offset, ToWall

PATIENCE_S = 120.0
"""Factory seconds that a machine may wait for a vehicle before it gets an alert: longer than most transports.
A machine whose material is on its way needs no person."""


class Moment(msgspec.Struct, frozen=True):
    """The moment of a look."""

    plant_s: float
    heard_s: float
    """Time up to which the plant was heard (plant clock): silence is judged against this."""
    wall_s: float
    speed: float
    """Factory seconds per real second."""
    to_wall_s: ToWall
    silence: Silence

    def is_lost(self, agent: str, last: AnyHeartbeat) -> bool:
        """Whether an agent has been silent for longer than allowed since this heartbeat."""
        return self.heard_s - last.at_s > self.silence.bound_s(agent, last)


def of_the_plant(now: Moment) -> Iterator[Condition]:
    """The plant is behind: everything heard is old."""
    behind_s = now.plant_s - now.heard_s
    if behind_s > plant_bound_s(now.speed):
        yield Condition(kind="plant_behind", behind_s=round(behind_s / now.speed))


def of_demand(overload: Overload, tasks: Tasks, vehicles: int, now: Moment) -> Iterator[Condition]:
    """The plant is overloaded: demand exceeds what the vehicles can carry.

    Args:
        overload: the result of the last look.
        tasks: all tasks.
        vehicles: number of vehicles heard and not shut out.
        now: the moment of the look.
    """
    present_s = now.to_wall_s(min(now.plant_s, now.heard_s))
    waited_s = (
        (present_s - task.opened_at_s) * now.speed
        for task in tasks.under_way()
        if task.kind == "transport" and task.state == "bidding" and not task.trouble
    )
    if overload.look(waited_s, vehicles):
        carried_frac = tasks.transports.carried_frac(now.heard_s)
        yield Condition(
            kind="overloaded",
            waiting=overload.waiting,
            carried_frac=None if carried_frac is None else round(carried_frac, 2),
        )


def of_outsiders(
    exclusions: Iterable[Exclusion], atvs: Container[str], storages: Container[str]
) -> Iterator[Condition]:
    """Agents that are shut out. They have no other trouble, since their word no longer counts."""
    for each in exclusions:
        kind: AlertKind = "atv_shut_out" if each.agent in atvs else "machine_shut_out"
        if each.agent in storages:
            kind = "station_shut_out"
        yield Condition(kind=kind, agent=each.agent, cause=detail_of(each.reason), by=each.by)


def of_clocks(wrong: Iterable[tuple[str, Offset]]) -> Iterator[Condition]:
    """Agents whose clocks are certainly wrong."""
    for agent, offset in wrong:
        yield Condition(kind="clock_wrong", agent=agent, clock_ahead_s=round(offset.ahead_s))


def of_disputes(disputes: Disputes, wrong: Container[str], now: Moment) -> Iterator[Condition]:
    """Statements that coordinators do not believe.

    Args:
        disputes: those of the last half hour.
        wrong: agents with a clock alert already.
        now: the moment of the look.
    """
    for each in disputes.handovers(now.plant_s):
        yield Condition(kind="handover_disputed", agent=each.agent, cause=each.cause, by=each.by)
    for each in disputes.words(now.plant_s):
        if each.agent not in wrong:
            yield Condition(kind="word_disbelieved", agent=each.agent, cause=each.cause, by=each.by)


def of_strangers(dropped: int) -> Iterator[Condition]:
    """Agents that are not in the plant file and exceed the number that may join."""
    if dropped:
        yield Condition(kind="strangers")


def of_machines(
    heartbeats: Iterable[tuple[MachineHeartbeat, float]], materials: Materials, now: Moment
) -> Iterator[Condition]:
    """What is wrong with machines.

    Args:
        heartbeats: the last one of each machine, and the time since which it has had that status (plant
            clock).
        materials: knows the materials' names.
        now: the moment of the look.
    """
    for heard, since_s in heartbeats:
        agent, patient = heard.machine, now.heard_s - since_s < PATIENCE_S
        if heard.out_of_service is not UNSET and not heard.product:
            continue  # The person who took it out of service knows; a product still being made may go wrong.
        if now.is_lost(agent, heard):
            yield Condition(kind="machine_lost", agent=agent, seen_at_s=now.to_wall_s(heard.at_s))
        elif heard.status is MachineStatus.ERROR:
            yield Condition(kind="machine_error", agent=agent, cause=detail_of(heard.problem))
        elif heard.dock_wait is not UNSET:
            yield _dock_not_ready(agent, heard.dock_wait, now)
        elif wrong := _unusable(heard):
            yield Condition(kind="machine_document", agent=agent, cause=detail_of(wrong))
        elif heard.status is MachineStatus.STARVED and not patient:
            lacking = detail_of(heard.problem) or materials.cause(heard.waits)
            yield Condition(kind="machine_starved", agent=agent, cause=lacking)
        elif heard.status is MachineStatus.BLOCKED and not patient:
            yield Condition(kind="machine_blocked", agent=agent, cause=detail_of(heard.problem))


def _dock_not_ready(place: str, waits: DockWait, now: Moment) -> Condition:
    return Condition(
        kind="dock_not_ready",
        agent=place,
        agents=(waits.vehicle,),
        seen_at_s=now.to_wall_s(waits.since_s),
    )


def _unusable(heard: MachineHeartbeat) -> str:
    """The first document that a machine cannot use, in words; empty if there is none."""
    for each in heard.documents or ():
        if each.state in (DocumentState.DIFFERS, DocumentState.UNREACHABLE):
            return f"{each.document.name}, {each.product}: {each.detail}"
    return ""


def of_stations(heartbeats: Iterable[StationHeartbeat], now: Moment) -> Iterator[Condition]:
    """What is wrong with stations.

    A silent storage promises and hands out nothing; without the gate, nothing counts as delivered.
    """
    for heard in heartbeats:
        if now.is_lost(heard.station, heard):
            kind: AlertKind = "gate_lost" if heard.station == GATE else "station_lost"
            yield Condition(kind=kind, agent=heard.station, seen_at_s=now.to_wall_s(heard.at_s))
        elif heard.problem:
            yield Condition(kind="gate_error", agent=heard.station, cause=detail_of(heard.problem))
        elif heard.dock_wait is not UNSET:
            yield _dock_not_ready(heard.station, heard.dock_wait, now)
        elif any(level.uncounted for level in heard.stocks):
            yield Condition(kind="stock_unknown", agent=heard.station)


def of_doubts(
    heartbeats: Mapping[str, MachineHeartbeat | StationHeartbeat], name_of: Callable[[str], str], now: Moment
) -> Iterator[Condition]:
    """Loads that may lie at a place although they are not in its books. A silent place has its own alert.

    Args:
        heartbeats: the last one of each machine and station, by id.
        name_of: the name of a material or product.
        now: the moment of the look.
    """
    for agent, heard in heartbeats.items():
        for doubt in () if now.is_lost(agent, heard) else doubts_of(heard.doubts, name_of):
            yield Condition(kind="load_doubtful", agent=agent, doubt=doubt)


def of_strategists(heartbeats: Iterable[StrategistHeartbeat], now: Moment) -> Iterator[Condition]:
    """Silent strategists, where a plant has several: the others go on with their orders."""
    silence_s = max(GOAL_SILENCE_S, LEAST_S * now.speed)
    heard = sorted(heartbeats, key=lambda each: each.strategist)
    silent = [each for each in heard if now.heard_s - each.at_s > silence_s]
    if silent:
        yield Condition(
            kind="strategist_lost" if len(silent) < len(heard) else "no_strategist",
            agents=tuple(each.strategist for each in silent),
            seen_at_s=now.to_wall_s(min(each.at_s for each in silent)),
        )


def in_vain(call: HelpCall) -> CallKind | None:
    """Why nobody comes: nobody is on duty there, or nobody asked has taken the call.

    None while somebody is asked or comes.
    """
    if call.state is not CallState.RESTING:
        return None
    return "call_nobody" if call.on_duty == 0 else "call_unanswered"


def of_calls(calls: Iterable[HelpCall], now: Moment) -> Iterator[Condition]:
    """Calls for help in vain, and those of vehicles that have told no place: no heartbeat of theirs tells of it.

    Goods left on board have their own alert (`goods_rules`).
    """
    for call in calls:
        kind = in_vain(call)
        if call.goods:
            continue
        if call.place is not CallPlace.PRESENT:
            yield Condition(
                kind="atv_unplaced",
                agent=call.caller,
                cause=detail_of(call.reason),
                call=kind,
                seen_at_s=now.to_wall_s(call.since_s),
            )
        elif kind is not None:
            yield Condition(
                kind=kind,
                agent=call.caller,
                cause=detail_of(call.reason),
                seen_at_s=now.to_wall_s(call.since_s),
            )


def of_atvs(
    heartbeats: Iterable[AtvHeartbeat], explained: Container[str], now: Moment
) -> Iterator[Condition]:
    """What is wrong with vehicles.

    Args:
        heartbeats: the last one of each vehicle.
        explained: vehicles whose silence people know of, or which have a graver alert.
        now: the moment of the look.
    """
    for heard in heartbeats:
        agent, help_ = heard.atv, heard.help
        if heard.out_of_service is not UNSET and heard.task is None:
            continue  # The person who took it out of service knows; a load on board has its own alert.
        if now.is_lost(agent, heard):
            if agent in explained:
                continue
            yield Condition(kind="atv_lost", agent=agent, seen_at_s=now.to_wall_s(heard.at_s))
        elif help_ is not None and (help_.promised_by or heard.status is not AtvStatus.STOPPED):
            # A promise of help makes the alert milder. A vehicle stopped by a person asks for nobody.
            yield Condition(
                kind="atv_promised" if help_.promised_by else "atv_help",
                agent=agent,
                cause=detail_of(heard.problem),
                by=help_.promised_by,
                until_at_s=now.to_wall_s(help_.until_s),
            )
        elif heard.status is AtvStatus.ERROR:
            yield Condition(kind="atv_error", agent=agent, cause=detail_of(heard.problem))
        elif heard.status is AtvStatus.STOPPED:
            yield Condition(kind="atv_stopped", agent=agent, cause=detail_of(heard.problem))
        # A vehicle charges long before it touches its reserve: something keeps it from the charger.
        elif heard.battery_frac < RESERVE_FRAC and heard.status is not AtvStatus.CHARGING:
            yield Condition(kind="atv_battery", agent=agent, battery_frac=round(heard.battery_frac, 2))
        # The heartbeat reports this at once by mesh; the fact may be delayed for long.
        elif heard.link is Link.MESH:
            lost = heard.lost_wlan or None
            yield Condition(
                kind="atv_mesh",
                agent=agent,
                agents=heard.via,
                seen_at_s=None if lost is None else now.to_wall_s(lost.since_s),
                access_point="" if lost is None else lost.access_point,
            )


def of_transports(tasks: Iterable[TaskView], told: Iterable[Condition]) -> Iterator[Condition]:
    """What is wrong with transports, unless their vehicle has the same alert.

    Args:
        tasks: open tasks. Production goals have their order's alert.
        told: the vehicles' troubles.
    """
    tells = {(each.agent, each.cause.detail) for each in told if each.cause is not None}
    for task in tasks:
        if task.trouble is None or task.kind != "transport" or task.stranded is not None:
            continue  # Goods left on board have their own alert.
        if task.fails_at:
            yield Condition(kind="dock_fails", agent=task.fails_at, task=task.id)
            continue
        # Silence has no detail: a lost vehicle's alert says nothing of its transport.
        if not task.trouble.detail or (task.primary, task.trouble.detail) not in tells:
            yield Condition(
                kind="task_trouble",
                agent=task.primary or task.coordinator,
                task=task.id,
                cause=task.trouble,
            )


def of_orders(orders: Iterable[OrderView], impossible: Container[str], now: Moment) -> Iterator[Condition]:
    """What is wrong with orders.

    Args:
        orders: open orders that may be in trouble.
        impossible: ids of orders that this plant cannot make.
        now: the moment of the look.
    """
    for order in orders:
        if order.id in impossible:
            yield Condition(kind="order_impossible", order=order.id, cause=order.waits)
        elif order.waits and order.waits.machines:
            yield Condition(kind="order_waits", order=order.id, cause=order.waits)
        elif order.due_at_s is not None and order.due_at_s < now.wall_s:
            # It may wait for material or for a way: a repaired machine would not help it.
            yield Condition(kind="order_late", order=order.id, until_at_s=order.due_at_s, cause=order.waits)

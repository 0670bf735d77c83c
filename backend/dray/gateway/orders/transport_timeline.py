"""The timeline of a plain transport or of a machine's own: call, award, fetch, hand-over, takeovers. Pure.

A plain transport may be announced several times under different names: its destination restarts, or a load
comes in parts. Steps come from agents' facts; where the log has forgotten them, the table of tasks supplies
less.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from dray.gateway.live.views.base import View
from dray.gateway.orders.timeline import LegView, MomentKind, MomentView, WayOutView, timeline
from dray.messages import TransportState
from dray.messages.fact import AwardAnswered, CarrierChanged, PhaseEntered, TaskClosed, TaskOpened
from dray.store.history.beginnings import Beginning
from dray.store.history.events import EventRow
from dray.store.orders.tasks import TaskRow
from dray.store.orders.transports import TransportRow

TOLD_BY = (TaskOpened, AwardAnswered, PhaseEntered, CarrierChanged, TaskClosed)
"""Facts that make the timeline."""

KINDS = tuple(kind.__name__ for kind in TOLD_BY)


class TransportTimeline(View, kw_only=True):
    """A whole transport, oldest first. Times are wall clock seconds."""

    attempts: tuple[WayOutView, ...] = ()
    """One per announcement; normally a single one."""
    moments: tuple[MomentView, ...] = ()
    is_whole: bool = True
    """False where the log has forgotten the steps, so that only the last carrier and its times are known; or
    has more than one read returns."""


def transport_timeline(
    row: TransportRow,
    tasks: Sequence[TaskRow],
    rows: Iterable[EventRow],
    *,
    is_whole: bool = True,
    beginnings: Sequence[Beginning] = (),
) -> TransportTimeline:
    """The timeline of a plain transport.

    Args:
        row: the transport.
        tasks: its tasks, one per announcement.
        rows: their events, in any order.
        is_whole: whether there are no more events.
        beginnings: the starts of the factory without a memory, oldest first.
    """
    told = timeline(rows, (), beginnings=beginnings)
    ways = {way.task: way for way in told.transports}
    forgotten = [task for task in tasks if task.id not in ways]
    attempts = [*ways.values(), *(_known(task) for task in forgotten)]
    moments = [*_begun(row), *told.moments, *(each for task in forgotten for each in _kept(task)), *_end(row)]
    # Vehicles do not know people's name for it.
    for attempt in attempts:
        attempt.thing = row.thing
    for moment in moments:
        moment.thing = row.thing
    return TransportTimeline(
        attempts=tuple(sorted(attempts, key=lambda way: way.opened_at_s)),
        moments=tuple(sorted(moments, key=lambda moment: moment.at_s)),
        is_whole=is_whole and not forgotten,
    )


def task_timeline(
    task: TaskRow,
    rows: Iterable[EventRow],
    *,
    is_whole: bool = True,
    beginnings: Sequence[Beginning] = (),
) -> TransportTimeline:
    """The timeline of a coordinator's own transport: material, or goods to be fetched from it.

    Args:
        task: the transport.
        rows: its events, in any order.
        is_whole: whether there are no more events.
        beginnings: the starts of the factory without a memory, oldest first.
    """
    told = timeline(rows, (), beginnings=beginnings)
    is_known = bool(told.transports)
    moments = [_of_task(task, "called", task.opened_at_s), *(told.moments if is_known else _kept(task))]
    if task.closed_at_s is not None:
        ended: MomentKind = "delivered" if task.state == "delivered" else "cancelled"
        moments.append(_of_task(task, ended, task.closed_at_s))
    return TransportTimeline(
        attempts=told.transports or (_known(task),),
        moments=tuple(sorted(moments, key=lambda moment: moment.at_s)),
        is_whole=is_whole and is_known,
    )


def _of_task(task: TaskRow, kind: MomentKind, at_s: float) -> MomentView:
    agent = task.coordinator if kind == "called" else ""
    return MomentView(
        kind=kind, at_s=at_s, agent=agent, other=task.destination, item=task.item, quantity=task.quantity
    )


def _known(task: TaskRow) -> WayOutView:
    """An attempt with forgotten steps."""
    legs: tuple[LegView, ...] = ()
    if task.carrier and task.contracted_at_s is not None:
        legs = (LegView(carrier=task.carrier, since_at_s=task.contracted_at_s, until_at_s=task.closed_at_s),)
    return WayOutView(
        task=task.id,
        goal=task.goal,
        item=task.item,
        quantity=task.quantity,
        source=task.source,
        destination=task.destination,
        opened_at_s=task.opened_at_s,
        closed_at_s=task.closed_at_s,
        outcome=task.state if task.state in ("delivered", "withdrawn") else "",
        legs=legs,
    )


def _kept(task: TaskRow) -> list[MomentView]:
    """The award, which is certain only without a takeover."""
    if task.epoch > 1 or not task.carrier or task.contracted_at_s is None:
        return []
    return [
        MomentView(
            kind="won",
            at_s=task.contracted_at_s,
            task=task.id,
            agent=task.carrier,
            item=task.item,
            quantity=task.quantity,
        )
    ]


def _begun(row: TransportRow) -> list[MomentView]:
    called = [_of(row, "called", row.created_at_s)]
    return called if row.cancel_at_s is None else [*called, _of(row, "called_off", row.cancel_at_s)]


def _end(row: TransportRow) -> list[MomentView]:
    if row.ended_at_s is None:
        return []
    kind: MomentKind = "delivered" if row.status is TransportState.DELIVERED else "cancelled"
    return [_of(row, kind, row.ended_at_s)]


def _of(row: TransportRow, kind: MomentKind, at_s: float) -> MomentView:
    agent = row.called_by if kind == "called" else ""
    return MomentView(
        kind=kind, at_s=at_s, agent=agent, other=row.destination, item=row.item, quantity=row.quantity
    )

"""Agents' events in SQL: the facts, with agents and subjects."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby, takewhile
from typing import Any

import msgspec
from sqlalchemy import ColumnElement, column, delete, func, select, table, union
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.messages import Event, Production, Transport
from dray.messages.fact import TaskOpened
from dray.messages.history import HISTORY_KEPT
from dray.store.database.dialect import insert_new
from dray.store.history import ages
from dray.store.history.clocks import ToWall
from dray.store.history.gaps import LIVES, Known
from dray.store.tables import events, goals

_TASKS = table("tasks", column("id"), column("order_id"))
"""The table of `dray.store.orders.tasks`, in a higher layer."""


class EventRow(msgspec.Struct, frozen=True, gc=False):
    """One stored event."""

    position: int
    """The row's number, in ascending order."""
    agent: str
    incarnation: int
    number: int
    at_s: float
    """Wall clock."""
    plant_s: float
    """Plant clock."""
    kind: str
    task: str | None
    goal: str | None
    order_id: str | None
    fact: msgspec.Raw
    """The fact as JSON; its own times are on the plant's clock."""


class EventFilter(msgspec.Struct, frozen=True, gc=False):
    """A filter for events; empty fields match all."""

    kinds: tuple[str, ...] = ()
    agents: tuple[str, ...] = ()
    task: str = ""
    order: str = ""
    """Events about the order, its goals, and the tasks for these."""


class Events:
    """The events, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def add(self, new: Sequence[Event], to_wall_s: ToWall) -> None:
        """Store events; existing ones (agent, incarnation, number) stay unchanged."""
        if new:
            await self._connection.execute(
                insert_new(self._connection, events), [_row(event, to_wall_s) for event in new]
            )

    async def page(
        self, wanted: EventFilter, after: int | None, limit: int, *, newest_first: bool
    ) -> list[EventRow]:
        """A page of events, oldest first unless `newest_first`.

        Args:
            wanted: the filter.
            after: the position of the previous page's last event; None for the first page.
            limit: maximum number of events.
            newest_first: the direction.
        """
        position = events.c.position
        query = select(events).where(*_conditions(wanted)).limit(limit)
        if newest_first:
            query = query.order_by(position.desc())
            if after is not None:
                query = query.where(position < after)
        else:
            query = query.order_by(position)
            if after is not None:
                query = query.where(position > after)
        return [_record(row._mapping) for row in await self._connection.execute(query)]  # noqa: SLF001

    async def since(self, kinds: Sequence[str], plant_s: float, limit: int) -> list[EventRow]:
        """Events of these kinds since a time, by the plant's clock.

        Args:
            kinds: the kinds.
            plant_s: on the plant's clock.
            limit: maximum number of events, the newest ones.
        """
        query = (
            select(events)
            .where(events.c.kind.in_(kinds), events.c.plant_s >= plant_s)
            .order_by(
                events.c.plant_s.desc(), events.c.agent, events.c.incarnation.desc(), events.c.number.desc()
            )
            .limit(limit)
        )
        newest_first = await self._connection.execute(query)
        return [_record(row._mapping) for row in newest_first][::-1]  # noqa: SLF001

    async def of_tasks(self, tasks: Sequence[str], kinds: Sequence[str], limit: int) -> list[EventRow]:
        """Events of these kinds about some tasks, by time."""
        query = (
            select(events)
            .where(events.c.task.in_(tasks), events.c.kind.in_(kinds))
            .order_by(events.c.at_s, events.c.agent, events.c.incarnation, events.c.number)
            .limit(limit)
        )
        return [_record(row._mapping) for row in await self._connection.execute(query)]  # noqa: SLF001

    async def known(self) -> list[Known]:
        """The stored numbers of the last lives of every agent, each agent's in order, with their holes."""
        lives = await self._connection.execute(
            select(
                events.c.agent,
                events.c.incarnation,
                func.min(events.c.number),
                func.max(events.c.number),
                func.count(),
            )
            .group_by(events.c.agent, events.c.incarnation)
            .order_by(events.c.agent, events.c.incarnation)
        )
        oldest = await self.first()
        found: list[Known] = []
        for _, grouped in groupby(lives.all(), key=lambda row: row[0]):
            of_agent = list(grouped)
            # Deleted rows are not fetched once more: their pieces were counted.
            is_first_asked = oldest != 1 or len(of_agent) > LIVES
            for agent, life, first, last, count in of_agent[-LIVES:]:
                # Deleted rows are no hole; none were deleted as long as the very first row exists.
                start = 1 if oldest == 1 else first
                missing: tuple[int, ...] = ()
                if count < last - start + 1:
                    start = max(start, last - HISTORY_KEPT + 1)
                    missing = await self._missing(agent, life, start, last)
                found.append(Known(agent, life, last, missing, is_first_asked))
                is_first_asked = False
        return found

    async def _missing(self, agent: str, incarnation: int, first: int, last: int) -> tuple[int, ...]:
        """The numbers of a life from `first` to `last` that are not stored."""
        number = events.c.number
        kept = await self._connection.execute(
            select(number).where(
                events.c.agent == agent, events.c.incarnation == incarnation, number.between(first, last)
            )
        )
        there = set(kept.scalars())
        return tuple(each for each in range(first, last + 1) if each not in there)

    async def first(self) -> int | None:
        """The position of the oldest stored event; None without any."""
        first: int | None = await self._connection.scalar(select(func.min(events.c.position)))
        return first

    async def oldest(
        self, before_s: float, most: int, limit: int, now_s: float
    ) -> tuple[int, int, int] | None:
        """The events to delete next: the oldest ones, up to the first that must stay.

        Args:
            before_s: delete events before this moment (wall clock).
            most: also delete events beyond this number of newest ones.
            limit: maximum number of events.
            now_s: the wall clock; an event with a future time is as old as the next one.

        Returns:
            The first and the last position, and the number of events deleted only because there are too many; None for nothing to
                delete.
        """
        position = events.c.position
        newest = (await self._connection.execute(select(func.max(position)))).scalar()
        if newest is None:
            return None
        aged = await ages.oldest(self._connection, events, limit, now_s)
        old = list(takewhile(lambda row: row[1] < before_s or row[0] <= newest - most, aged))
        if not old:
            return None
        return old[0][0], old[-1][0], sum(at_s >= before_s for _, at_s in old)

    async def forget(self, first: int, last: int) -> None:
        """Delete the events with these positions."""
        await self._connection.execute(delete(events).where(events.c.position.between(first, last)))


def _conditions(wanted: EventFilter) -> list[ColumnElement[bool]]:
    conditions: list[ColumnElement[bool]] = []
    if wanted.kinds:
        conditions.append(events.c.kind.in_(wanted.kinds))
    if wanted.agents:
        conditions.append(events.c.agent.in_(wanted.agents))
    if wanted.task:
        conditions.append(events.c.task == wanted.task)
    if wanted.order:
        conditions.append(_about_order(wanted.order))
    return conditions


def _about_order(order: str) -> ColumnElement[bool]:
    """The condition for events about the order itself, one of its goals, or a task for it.

    A task's first event has its order; if the log has deleted it, the table of tasks has it. Each condition uses its own
    index, and the results are united: with OR, a database may scan all events instead.
    """
    its_goals = select(goals.c.id).where(goals.c.order_id == order)
    opened = events.alias("opened")
    tasks_opened = select(opened.c.task).where(opened.c.kind == TaskOpened.__name__)
    its_tasks = union(
        tasks_opened.where(opened.c.order_id == order),
        tasks_opened.where(opened.c.goal.in_(its_goals)),
        select(_TASKS.c.id).where(_TASKS.c.order_id == order),
    )
    named = events.alias("named")
    positions = union(
        select(named.c.position).where(named.c.order_id == order),
        select(named.c.position).where(named.c.goal.in_(its_goals)),
        select(named.c.position).where(named.c.task.in_(its_tasks)),
    )
    return events.c.position.in_(positions)


def _row(event: Event, to_wall_s: ToWall) -> dict[str, Any]:
    fact = event.fact
    goal, order = getattr(fact, "goal", None), getattr(fact, "order", None)
    if isinstance(fact, TaskOpened):
        match fact.work:
            case Transport(goal=served):
                goal = served
            case Production(order=served):
                order = served
    return {
        "agent": event.agent,
        "incarnation": event.incarnation,
        "number": event.number,
        "at_s": to_wall_s(event.at_s),
        "plant_s": event.at_s,
        "kind": type(fact).__name__,
        "task": getattr(fact, "task", None),
        "goal": goal or None,
        "order_id": order or None,
        "fact": msgspec.json.encode(fact).decode(),
    }


def _record(row: Any) -> EventRow:
    fields = dict(row)
    fields["fact"] = msgspec.Raw(fields["fact"].encode())
    return EventRow(**fields)

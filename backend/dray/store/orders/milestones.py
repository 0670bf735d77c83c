"""Milestones: when an order was planned, begun and sent, and the factory's accuracy of promises.

They are read from the event log and the goals; for deleted events, from the order's own history.
"""

from __future__ import annotations

from collections.abc import Collection

import msgspec
from sqlalchemy import Column, Double, LargeBinary, Table, func, select
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.messages.fact import GoalContracted, PhaseEntered, PieceMade, PromiseMoved, TaskOpened
from dray.messages.heartbeat import Phase
from dray.store.tables import Id, Position, events, goals, metadata

PIECES_READ = 500
"""Maximum pieces read for one order: ten or more of each of its running goals."""

PROMISES_READ = 50
"""Maximum finished goals with compared promises: the last hours of the default plant."""


class OrderTimes(msgspec.Struct, frozen=True, gc=False):
    """The times of an order's milestones (wall clock seconds); None for not reached or unknown."""

    planned_at_s: float | None = None
    """A machine took its first goal."""
    first_piece_at_s: float | None = None
    left_at_s: float | None = None
    """The first vehicle drove off with its goods."""


class MovedPromise(msgspec.Struct, frozen=True, gc=False):
    """A promise of a goal that its machine has moved since it took the goal."""

    machine: str
    told_at_s: float
    """Wall clock, in seconds."""
    left_s: float
    """From then to the promised finish, in plant seconds."""
    came_before: int
    """More urgent goals that had come before it by then."""

    def promised_at_s(self, speed: float) -> float:
        """The promised finish (wall clock), at so many plant seconds per wall second."""
        return self.told_at_s + self.left_s / speed


_MOVED = msgspec.json.Decoder(PromiseMoved)

order_histories = Table(
    "order_histories",
    metadata,
    Column("order_id", Id, primary_key=True),
    Column("position", Position, nullable=False),
    *(Column(name, Double) for name in OrderTimes.__struct_fields__),
    Column("told", LargeBinary, nullable=False),
    comment="What is kept with an order. position: of the newest event in it; told: events as compressed JSON.",
)


class Milestones:
    """Milestones of orders, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def of_order(self, order_id: str, since_s: float = 0.0) -> OrderTimes:
        """The times of this order's milestones.

        Args:
            order_id: the order.
            since_s: only those reached since then (wall clock).
        """
        its_goals = select(goals.c.id).where(goals.c.order_id == order_id)
        opened = events.alias("opened")
        its_ways_out = select(opened.c.task).where(
            opened.c.kind == TaskOpened.__name__, opened.c.goal.in_(its_goals)
        )
        first = select(func.min(events.c.at_s)).where(events.c.at_s >= since_s)
        planned = first.where(events.c.kind == GoalContracted.__name__, events.c.order_id == order_id)
        made = first.where(events.c.kind == PieceMade.__name__, events.c.goal.in_(its_goals))
        left = first.where(
            events.c.kind == PhaseEntered.__name__,
            events.c.task.in_(its_ways_out),
            events.c.fact.contains(f'"phase":"{Phase.CARRYING.value}"', autoescape=True),
        )
        query = select(planned.scalar_subquery(), made.scalar_subquery(), left.scalar_subquery())
        logged = (await self._connection.execute(query)).one()
        columns = [order_histories.c[name] for name in OrderTimes.__struct_fields__]
        with_it = select(*columns).where(order_histories.c.order_id == order_id)
        kept = (await self._connection.execute(with_it)).first() or (None, None, None)
        of_it = [at_s if at_s is not None and at_s >= since_s else None for at_s in kept]
        return OrderTimes(*map(_earlier, logged, of_it))

    async def piece_times_s(self, of_goals: Collection[str]) -> dict[str, tuple[float, ...]]:
        """The times of the last pieces of each of these goals (wall clock), oldest first."""
        found: dict[str, list[float]] = {goal: [] for goal in of_goals}
        if found:
            query = (
                select(events.c.goal, events.c.at_s)
                .where(events.c.kind == PieceMade.__name__, events.c.goal.in_(list(found)))
                .order_by(events.c.at_s.desc())
                .limit(PIECES_READ)
            )
            for goal, at_s in await self._connection.execute(query):
                found[goal].append(at_s)
        return {goal: tuple(reversed(times)) for goal, times in found.items()}

    async def moved_promises(self, of_goals: Collection[str]) -> dict[str, MovedPromise]:
        """The promises that hold now, of those of these goals whose machine has moved them."""
        found: dict[str, MovedPromise] = {}
        if of_goals:
            query = (
                select(events.c.goal, events.c.agent, events.c.at_s, events.c.plant_s, events.c.fact)
                .where(events.c.kind == PromiseMoved.__name__, events.c.goal.in_(list(of_goals)))
                .order_by(events.c.at_s, events.c.incarnation, events.c.number)
            )
            for goal, machine, at_s, plant_s, fact in await self._connection.execute(query):
                moved = _MOVED.decode(fact)
                found[goal] = MovedPromise(machine, at_s, moved.finish_s - plant_s, moved.came_before)
        return found

    async def promises_missed_by_s(self) -> tuple[float, ...]:
        """The delays of the last finished goals against their machines' first promises, ascending.

        A promise that was moved since makes no goal punctual. Early ones are negative. Wall clock seconds, up to the arrival of the last piece.
        """
        query = (
            select(goals.c.delivered_at_s - goals.c.promised_at_s)
            .where(
                goals.c.delivered_at_s.is_not(None),
                goals.c.promised_at_s.is_not(None),
                goals.c.quantity > 0,
                goals.c.delivered >= goals.c.quantity,
            )
            .order_by(goals.c.delivered_at_s.desc())
            .limit(PROMISES_READ)
        )
        return tuple(sorted((await self._connection.execute(query)).scalars()))


def _earlier(one_s: float | None, other_s: float | None) -> float | None:
    known = [at_s for at_s in (one_s, other_s) if at_s is not None]
    return min(known, default=None)

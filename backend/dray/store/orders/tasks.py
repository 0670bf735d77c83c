"""Tasks in SQL: transports and productions with agents and times. There is a row per task, long after its auction.

A coordinator reports its tasks in numbered events that come late, doubled and in any order: the newest counts, and an end is final.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal, get_args

import msgspec
from sqlalchemy import (
    CheckConstraint,
    Column,
    ColumnElement,
    Double,
    Index,
    Integer,
    String,
    Table,
    Text,
    case,
    delete,
    func,
    literal_column,
    or_,
    select,
    tuple_,
    update,
)
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.messages import Event, Production, Role, Transport
from dray.messages.fact import AwardAnswered, CarrierChanged, TaskClosed, TaskOpened, WatchLost
from dray.store.database.counting import total_of
from dray.store.database.dialect import insert_new
from dray.store.database.searching import Sought, searched
from dray.store.history.clocks import ToWall
from dray.store.tables import Id, events, goals, metadata, orders

TaskState = Literal["bidding", "contracted", "delivered", "withdrawn"]

tasks = Table(
    "tasks",
    metadata,
    Column("id", Id, primary_key=True),
    Column("kind", String(16), nullable=False),
    Column("coordinator", Id, nullable=False),
    Column("item", Id, nullable=False),
    Column("quantity", Integer, nullable=False),
    Column("source", Id, nullable=False),
    Column("destination", Id, nullable=False),
    Column("goal", Id, nullable=False),
    Column("order_id", Id, nullable=False),
    Column("state", String(16), nullable=False),
    Column("carrier", Id, nullable=False),
    Column("standby", Id, nullable=False),
    Column("epoch", Integer, nullable=False),
    Column("round", Integer, nullable=False),
    Column("opened_at_s", Double, nullable=False),
    Column("contracted_at_s", Double),
    Column("promised_at_s", Double),
    Column("deadline_at_s", Double, nullable=False),
    Column("closed_at_s", Double),
    Column("incarnation", Integer, nullable=False),
    Column("number", Integer, nullable=False),
    Column("search", Text, nullable=False),
    CheckConstraint("state IN ('bidding', 'contracted', 'delivered', 'withdrawn')", name="state"),
    Index(None, "opened_at_s", "id"),
    Index(None, "state", "opened_at_s", "id"),
    Index(None, "order_id"),
    comment="Tasks as their coordinators told of them. incarnation, number: the newest event that was told about it.",
)


class TaskRow(msgspec.Struct, kw_only=True, gc=False):
    """A task. Times are wall clock seconds."""

    id: str
    kind: Literal["transport", "production"]
    coordinator: str
    item: str
    """A material or product."""
    quantity: int
    source: str = ""
    """The source; possible ones are separated by "/" until one is chosen."""
    destination: str = ""
    goal: str = ""
    """The goal of its goods; for a goal its own name."""
    order_id: str = ""
    """The order for which it is made, if known."""
    state: TaskState = "bidding"
    carrier: str = ""
    """The present or last carrier or machine."""
    standby: str = ""
    """The carrier's secondary."""
    epoch: int = 1
    round: int = 1
    opened_at_s: float
    contracted_at_s: float | None = None
    promised_at_s: float | None = None
    """The last carrier's promised time; set at the end."""
    deadline_at_s: float
    closed_at_s: float | None = None
    incarnation: int = 0
    number: int = 0


_COLUMNS = [column for column in tasks.c if column.name != "search"]


class TaskFilter(msgspec.Struct, frozen=True, kw_only=True, gc=False):
    """A filter for tasks; empty fields match all. Times are wall clock seconds."""

    states: Sequence[TaskState] = ()
    kind: str = ""
    item: str = ""
    order: str = ""
    since_s: float | None = None
    """Opened then or later; the next field: opened before then."""
    before_s: float | None = None
    late_at_s: float | None = None
    """Late at this moment: promised earlier and not done, or done later than promised."""
    words: tuple[Sought, ...] = ()
    """Words that must all occur in its id, coordinator, carriers, places, item, or the order's texts."""

    def conditions(self) -> list[ColumnElement[bool]]:
        """The conditions for a row."""
        c = tasks.c
        exact = {c.kind: self.kind, c.item: self.item, c.order_id: self.order}
        wanted: list[ColumnElement[bool]] = [column == value for column, value in exact.items() if value]
        if self.states:
            wanted.append(c.state.in_(self.states))
        if self.since_s is not None:
            wanted.append(c.opened_at_s >= self.since_s)
        if self.before_s is not None:
            wanted.append(c.opened_at_s < self.before_s)
        if self.late_at_s is not None:
            wanted.append(c.state != "withdrawn")
            wanted.append(c.promised_at_s < func.coalesce(c.closed_at_s, self.late_at_s))
        return [*wanted, *(_holds(word) for word in self.words)]


SortedBy = Literal["opened", "work", "promised", "late"]
"""`work`: open ones first, then the newest first. `late`: by the delay against the promise."""

Place = tuple[float, str]

_NEVER_S = 1e15
_NEVER: ColumnElement[float] = literal_column(f"{_NEVER_S:.0f}.0")
_KEYS: Mapping[SortedBy, ColumnElement[Any]] = {
    "opened": tasks.c.opened_at_s,
    "work": tasks.c.opened_at_s + case((tasks.c.closed_at_s.is_(None), _NEVER), else_=literal_column("0.0")),
    "promised": func.coalesce(tasks.c.promised_at_s, _NEVER),
    "late": func.coalesce(tasks.c.closed_at_s - tasks.c.promised_at_s, literal_column(f"-{_NEVER_S:.0f}.0")),
}

for _by in ("work", "promised", "late"):
    # As for orders (`dray.store.orders.order_sorting`).
    Index(f"ix_tasks_by_{_by}", _KEYS[_by], tasks.c.id)


class Tasks:
    """The tasks, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def many(self, ids: Iterable[str]) -> dict[str, TaskRow]:
        """The tasks with these names, if they exist."""
        rows = await self._connection.execute(select(*_COLUMNS).where(tasks.c.id.in_(list(ids))))
        return {row.id: TaskRow(**row._mapping) for row in rows}  # noqa: SLF001 - SQLAlchemy's public name

    async def of_transport(self, transport: str, limit: int) -> list[TaskRow]:
        """The tasks of a plain transport: `T-…-2`, or `T-….3-2` by a third life of its destination.

        Args:
            transport: its id.
            limit: maximum number of tasks.
        """
        c = tasks.c
        # In every database's collation, "-" and "." come before "Z".
        query = select(*_COLUMNS).where(c.id > transport, c.id < f"{transport}Z").order_by(c.id).limit(limit)
        rows = [TaskRow(**row._mapping) for row in await self._connection.execute(query)]  # noqa: SLF001
        return [row for row in rows if row.id.startswith((f"{transport}-", f"{transport}."))]

    async def page(
        self,
        wanted: TaskFilter,
        after: Place | None,
        limit: int,
        by: SortedBy = "opened",
        *,
        descending: bool = True,
    ) -> list[tuple[TaskRow, Place]]:
        """A part of a list, each task with its place.

        Args:
            wanted: the filter.
            after: the place of the previous page's last task.
            limit: maximum number of tasks.
            by: the sort key; equal tasks are sorted by name.
            descending: the direction.
        """
        key, name = _KEYS[by], tasks.c.id
        query = select(*_COLUMNS, key.label("place")).where(*wanted.conditions()).limit(limit)
        query = query.order_by(key.desc(), name.desc()) if descending else query.order_by(key, name)
        if after is not None:
            here, there = tuple_(key, name), tuple_(*after)
            query = query.where(here < there if descending else here > there)
        found = []
        for row in await self._connection.execute(query):
            fields = dict(row._mapping)  # noqa: SLF001 - SQLAlchemy's public name
            place = fields.pop("place")
            found.append((TaskRow(**fields), (place, row.id)))
        return found

    async def total(self, wanted: TaskFilter) -> int | None:
        """The number of matching tasks; None for very many."""
        return await total_of(self._connection, select(tasks.c.id).where(*wanted.conditions()))

    async def follow(self, new: Iterable[Event], to_wall_s: ToWall) -> None:
        """Update the tasks by coordinators' events."""
        told = [event for event in new if isinstance(event.fact, _OfTask)]
        if not told:
            return
        known = await self.many({_task_of(event) for event in told})
        born = [
            event for event in told if isinstance(event.fact, TaskOpened) and event.fact.task not in known
        ]
        for event in sorted(born, key=_when, reverse=True):
            # Of several openings the earliest counts, because the other events follow it.
            known[_task_of(event)] = _born(event, to_wall_s)
        if born:
            told += await self._told_before({_task_of(event) for event in born})
        for event in sorted(told, key=_when):
            row = known.get(_task_of(event))
            if row is not None and row.coordinator == event.agent:
                note(row, event, to_wall_s)
        rows = list(known.values())
        await self._find_orders(rows)
        await self._put(rows)

    async def end_open(self, at_s: float) -> None:
        """End all open tasks: their coordinators know them no more.

        Args:
            at_s: now (wall clock).
        """
        c = tasks.c
        await self._connection.execute(
            update(tasks)
            .where(c.closed_at_s.is_(None))
            .values(state="withdrawn", closed_at_s=case((c.opened_at_s > at_s, c.opened_at_s), else_=at_s))
        )

    async def _told_before(self, born: Iterable[str]) -> list[Event]:
        """Stored events of tasks whose opening has only come now, as after a fetch."""
        kinds = [fact.__name__ for fact in get_args(_OfTask)]
        query = select(events).where(events.c.task.in_(list(born)), events.c.kind.in_(kinds))
        rows = (await self._connection.execute(query)).all()
        return [
            Event(row.agent, row.incarnation, row.number, row.plant_s, _READ.decode(row.fact)) for row in rows
        ]

    async def prune(self, before_s: float, at_most: int) -> int:
        """Delete some that ended before then; returns the number."""
        c = tasks.c
        old = select(c.id).where(c.opened_at_s < before_s, c.closed_at_s < before_s).limit(at_most)
        return (await self._connection.execute(delete(tasks).where(c.id.in_(old)))).rowcount

    async def _find_orders(self, rows: Iterable[TaskRow]) -> None:
        lacking = {row.goal for row in rows if row.goal and not row.order_id}
        if lacking:
            query = select(goals.c.id, goals.c.order_id).where(goals.c.id.in_(list(lacking)))
            of = {row.id: row.order_id for row in await self._connection.execute(query)}
            for row in rows:
                row.order_id = row.order_id or of.get(row.goal) or ""

    async def _put(self, rows: Sequence[TaskRow]) -> None:
        if not rows:
            return
        known = select(orders.c.id, orders.c.search).where(orders.c.id.in_({row.order_id for row in rows}))
        of_order = {row.id: row.search for row in await self._connection.execute(known)}
        values = [row_of_task(row, of_order.get(row.order_id, "")) for row in rows]
        await self._connection.execute(delete(tasks).where(tasks.c.id.in_([row.id for row in rows])))
        await self._connection.execute(insert_new(self._connection, tasks), values)


def row_of_task(row: TaskRow, of_order: str) -> dict[str, object]:
    """A task as a row of the table.

    Args:
        row: the task.
        of_order: the search text of its order; empty for none.
    """
    return msgspec.structs.asdict(row) | {"search": _search(row, of_order)}


_OfTask = TaskOpened | AwardAnswered | WatchLost | CarrierChanged | TaskClosed

_READ = msgspec.json.Decoder(_OfTask)


def _task_of(event: Event) -> str:
    fact = event.fact
    assert isinstance(fact, _OfTask)  # noqa: S101 - chosen before
    return fact.task


def _when(event: Event) -> tuple[int, int]:
    return event.incarnation, event.number


def _born(event: Event, to_wall_s: ToWall) -> TaskRow:
    fact = event.fact
    assert isinstance(fact, TaskOpened)  # noqa: S101 - chosen before
    row = TaskRow(
        id=fact.task,
        kind="transport" if isinstance(fact.work, Transport) else "production",
        coordinator=event.agent,
        item="",
        quantity=fact.work.quantity,
        opened_at_s=to_wall_s(event.at_s),
        deadline_at_s=to_wall_s(fact.deadline_s),
    )
    match fact.work:
        case Transport() as work:
            row.item, row.goal = work.item, work.goal
            row.source, row.destination = "/".join(work.sources)[:128], work.destination
        case Production() as work:
            row.item, row.goal, row.order_id = work.product, fact.task, work.order
    return row


def note(row: TaskRow, event: Event, to_wall_s: ToWall) -> None:
    """Update a task by an event of its coordinator; an outdated event only sets an end."""
    is_new = (event.incarnation, event.number) > (row.incarnation, row.number)
    if isinstance(event.fact, TaskClosed):
        fact = event.fact
        row.state = "delivered" if fact.outcome == "delivered" else "withdrawn"
        row.closed_at_s, row.carrier = to_wall_s(event.at_s), fact.carrier or row.carrier
        row.epoch = max(row.epoch, fact.epoch)
        row.promised_at_s = to_wall_s(fact.promised_s) if fact.promised_s > 0 else None
    elif is_new and row.closed_at_s is None:
        _go_on(row, event, to_wall_s)
    if is_new:
        row.incarnation, row.number = event.incarnation, event.number


def _go_on(row: TaskRow, event: Event, to_wall_s: ToWall) -> None:
    match event.fact:
        case TaskOpened(role=Role.PRIMARY) as fact:
            if fact.epoch > row.epoch:
                row.state, row.carrier, row.standby = "bidding", "", ""
            row.epoch, row.round = max(row.epoch, fact.epoch), fact.round
            row.deadline_at_s = to_wall_s(fact.deadline_s)
        case AwardAnswered(answer="accepted", role=Role.SECONDARY) as fact:
            row.standby = fact.bidder
        case AwardAnswered(answer="accepted") as fact:
            row.state, row.carrier, row.epoch = "contracted", fact.bidder, fact.epoch
            row.contracted_at_s = to_wall_s(event.at_s)
        case WatchLost():
            row.standby = ""
        case CarrierChanged() as fact:
            row.state = "contracted" if fact.carrier else "bidding"
            row.carrier, row.standby, row.epoch = fact.carrier, "", fact.epoch
        case _:
            pass


def _search(row: TaskRow, of_order: str) -> str:
    """The search text: its own texts, and those of its order."""
    own = (row.id, row.coordinator, row.carrier, row.standby, row.source, row.destination)
    return searched((*own, of_order), (row.item,))


def _holds(word: Sought) -> ColumnElement[bool]:
    texts = (word.text, *(f"|{item}|" for item in word.named))
    return or_(*(tasks.c.search.contains(text.casefold(), autoescape=True) for text in texts))

"""Orders and tasks are found by words, filters and times over all history, sorted, and in pages that miss nothing."""

from __future__ import annotations

from itertools import permutations
from typing import Any, get_args

import msgspec
import pytest
from history import Line, a_day, contracted, keep, order, same_clock, tell
from sqlalchemy import event, text

from dray.messages import Event, Role, Transport
from dray.messages.fact import AwardAnswered, CarrierChanged, TaskClosed, TaskOpened
from dray.messages.keys import Keys
from dray.messages.reason import Reason
from dray.store import Historian, Store
from dray.store.database.searching import Sought
from dray.store.orders.order_filter import EVERY_ORDER, OrderFilter
from dray.store.orders.order_sorting import Place, Sorting
from dray.store.orders.order_sorting import SortedBy as OrdersBy
from dray.store.orders.orders import Order, Orders
from dray.store.orders.progress import OrderStatus
from dray.store.orders.tasks import SortedBy as TasksBy
from dray.store.orders.tasks import TaskFilter, TaskRow, Tasks

pytestmark = pytest.mark.anyio


def named(number: int, reference: str | None, customer: str = "Muster", due_s: float | None = None) -> Order:
    return msgspec.structs.replace(order(number), reference=reference, customer=customer, due_at_s=due_s)


async def found(store: Store, **wanted: object) -> list[str]:
    async with store.read() as work:
        return [one.id for one in await work.orders.page(OrderFilter(**wanted), None, 100)]  # type: ignore[arg-type]


def words(*texts: str) -> dict[str, object]:
    return {"words": tuple(Sought(text) for text in texts)}


async def test_an_order_is_found_by_a_part_of_its_texts_in_any_case(store: Store) -> None:
    await keep(store, named(1, "PO-D5"), named(2, "PO-D6", "Müller & Söhne"), named(3, None))
    assert await found(store, **words("d5")) == ["O-1"]
    assert await found(store, **words("MÜLLER")) == ["O-2"]
    assert await found(store, **words("söhne", "po-")) == ["O-2"]
    assert await found(store, **words("o-3")) == ["O-3"]
    assert await found(store, **words("d5", "müller")) == []


async def test_signs_of_patterns_are_looked_for_as_they_are(store: Store) -> None:
    await keep(store, named(1, "100%"), named(2, "100 a_b"), named(3, "1000"))
    assert await found(store, **words("0%")) == ["O-1"]
    assert await found(store, **words("a_b")) == ["O-2"]
    assert await found(store, **words("axb")) == []


async def test_a_word_may_name_a_product_and_finds_no_other_that_begins_alike(store: Store) -> None:
    await keep(store, order(1, 4, 2), order(2))
    assert await found(store, words=(Sought("pump", ("P2",)),)) == ["O-1"]
    assert await found(store, words=(Sought("pump", ("P",)),)) == []


async def test_late_is_what_is_due_and_not_there_or_came_after_it(store: Store) -> None:
    late = msgspec.structs.replace(
        named(1, None, due_s=50.0), status=OrderStatus.DELIVERED, delivered_at_s=60.0
    )
    kept = msgspec.structs.replace(late, id="O-2", token="t2", delivered_at_s=50.0)
    cancelled = msgspec.structs.replace(late, id="O-3", token="t3", status=OrderStatus.CANCELLED)
    await keep(store, late, kept, cancelled, named(4, None, due_s=99.0), named(5, None))
    assert await found(store, late_at_s=98.0) == ["O-1"]
    assert await found(store, late_at_s=100.0) == ["O-4", "O-1"]


@pytest.mark.parametrize("descending", [False, True])
@pytest.mark.parametrize("by", ["created", "work", "due", "reference", "customer"])
async def test_pages_of_every_order_miss_nothing_and_tell_nothing_twice(
    store: Store, by: str, descending: bool
) -> None:
    made = [
        named(
            number, f"PO-{number % 3}" if number % 4 else None, f"C{number % 2}", 100.0 * (number % 3) or None
        )
        for number in range(1, 12)
    ]
    made[4] = msgspec.structs.replace(made[4], status=OrderStatus.DELIVERED, delivered_at_s=1_800_000_000.7)
    made[5] = msgspec.structs.replace(made[5], status=OrderStatus.CANCELLED, cancelled_at_s=1_800_000_000.2)
    await keep(store, *made)
    sorting = Sorting(by, descending)  # type: ignore[arg-type]
    seen: list[str] = []
    after: Place | None = None
    async with store.read() as work:
        whole = [one.id for one in await work.orders.page(EVERY_ORDER, None, None, sorting)]
        while page := await work.orders.page(EVERY_ORDER, after, 2, sorting):
            seen += [one.id for one in page]
            after = sorting.place(page[-1])
    assert seen == whole
    assert sorted(seen) == sorted(one.id for one in made)


async def test_work_is_open_orders_by_due_time_and_then_the_last_that_ended(store: Store) -> None:
    ended = msgspec.structs.replace(named(1, None), status=OrderStatus.DELIVERED, delivered_at_s=10.0)
    later = msgspec.structs.replace(ended, id="O-2", token="t2", delivered_at_s=20.0)
    await keep(store, ended, later, named(3, None), named(4, None, due_s=9.0), named(5, None, due_s=5.0))
    async with store.read() as work:
        page = await work.orders.page(EVERY_ORDER, None, None, Sorting("work"))
    assert [one.id for one in page] == ["O-5", "O-4", "O-3", "O-2", "O-1"]


# --- tasks ---------------------------------------------------------------------------------------

WORK = Transport(item="P1", quantity=2, sources=("S1", "S2"), destination="M1", ability="tote", goal="G1")


def opened(epoch: int = 1, round_: int = 1) -> TaskOpened:
    role = Role.PRIMARY
    return TaskOpened("M1-1", epoch, role, round_, WORK, radius_m=9.0, deadline_s=900.0, bids_until_s=105.0)


STORY = (
    opened(),
    AwardAnswered("M1-1", 1, Role.PRIMARY, "ATV1", "accepted"),
    AwardAnswered("M1-1", 1, Role.SECONDARY, "ATV2", "accepted"),
    CarrierChanged("M1-1", 2, "ATV1", "ATV2", Reason.SILENT, 4.0),
    TaskClosed("M1-1", 2, "delivered", "ATV2", promised_s=150.0),
)


async def told(store: Store, *batches: list[Event]) -> TaskRow:
    for batch in batches:
        line = Line()
        historian = Historian(store=store, bus=line, keys=Keys("plant"), to_wall_s=same_clock, linger_s=0)
        async with historian.running():
            line.say(batch)
            await historian.written()
    async with store.read() as work:
        return (await work.tasks.many(["M1-1"]))["M1-1"]


async def test_a_task_is_kept_with_what_came_of_it_and_its_order(store: Store) -> None:
    await keep(store, order())
    await told(store, tell("strategist", contracted("G1", 0, 4)), tell("M1", *STORY))
    task = await told(store)
    assert (task.state, task.carrier, task.standby, task.epoch) == ("delivered", "ATV2", "", 2)
    assert (task.opened_at_s, task.contracted_at_s, task.promised_at_s, task.closed_at_s) == (
        101.0,
        102.0,
        150.0,
        105.0,
    )
    assert (task.source, task.destination, task.goal, task.order_id) == ("S1/S2", "M1", "G1", "O-1")


async def test_a_task_is_the_same_in_whatever_order_it_is_told(store: Store) -> None:
    events = tell("M1", *STORY)
    ends = set()
    for batches in list(permutations(events))[::7]:
        async with store.database.write() as connection:
            await connection.exec_driver_sql("DELETE FROM tasks")
            await connection.exec_driver_sql("DELETE FROM events")
        task = await told(store, *([event] for event in batches))
        ends.add((task.state, task.carrier, task.closed_at_s, task.promised_at_s, task.epoch))
    assert ends == {("delivered", "ATV2", 105.0, 150.0, 2)}


async def test_tasks_are_found_by_words_states_and_broken_promises(store: Store) -> None:
    await keep(store, named(1, "PO-D5"))
    await told(store, [*a_day(), *tell("M9", *STORY[:2], first=50)])
    async with store.read() as work:

        async def names(**wanted: object) -> list[str]:
            page = await work.tasks.page(TaskFilter(**wanted), None, 9)  # type: ignore[arg-type]
            return sorted(task.id for task, _ in page)

        assert await names() == ["G1", "M1-1"]
        assert await names(states=("delivered",)) == ["M1-1"]
        assert await names(words=(Sought("atv-1"),)) == ["M1-1"]
        assert await names(words=(Sought("d5"),)) == ["G1", "M1-1"]
        assert await names(words=(Sought("gear", ("P1",)), Sought("m1"))) == ["M1-1"]
        assert await names(kind="production") == ["G1"]
        assert await names(late_at_s=1e9) == []


async def test_pages_of_tasks_miss_nothing(store: Store) -> None:
    many = [
        event
        for number in range(7)
        for event in tell(
            f"M{number}",
            msgspec.structs.replace(opened(), task=f"M{number}-1"),
            *([TaskClosed(f"M{number}-1", 1, "delivered", "ATV1", 50.0 + number % 3)] if number % 2 else []),
        )
    ]
    await told(store, [*many, *tell("M1", opened(), first=9)])
    async with store.read() as work:
        for by in ("opened", "work", "promised", "late"):
            for descending in (True, False):
                seen, after = [], None
                while page := await work.tasks.page(TaskFilter(), after, 2, by, descending=descending):  # type: ignore[arg-type]
                    seen += [task.id for task, _ in page]
                    after = page[-1][1]
                assert sorted(seen) == sorted(f"M{number}-1" for number in range(7)), by


PLAN = {"sqlite": "EXPLAIN QUERY PLAN ", "postgresql": "EXPLAIN "}


@pytest.mark.parametrize("descending", [False, True])
@pytest.mark.parametrize(
    "of", [("orders", by) for by in get_args(OrdersBy)] + [("tasks", by) for by in get_args(TasksBy)]
)
async def test_every_way_of_sorting_is_read_from_an_index(
    store: Store, of: tuple[str, str], descending: bool
) -> None:
    """So that a page costs the same of ten orders and of a hundred thousand."""
    asked: list[tuple[str, Any]] = []
    kind, by = of

    def note(_connection: Any, _cursor: Any, statement: str, values: Any, *_rest: Any) -> None:
        if statement.startswith("SELECT"):
            asked.append((statement, values))

    async with store.database.read() as connection:
        event.listen(connection.sync_connection, "before_cursor_execute", note)
        place: Any = ("a" if by in {"reference", "customer"} else 1.0, "x")
        if kind == "orders":
            await Orders(connection).page(EVERY_ORDER, place, 51, Sorting(by, descending))  # type: ignore[arg-type]
        else:
            await Tasks(connection).page(TaskFilter(), place, 51, by, descending=descending)  # type: ignore[arg-type]
        database = connection.dialect.name
        if database == "postgresql":
            # Of a table without rows it would rather read and sort all of them.
            await connection.execute(text("SET LOCAL enable_sort = off"))
            await connection.execute(text("SET LOCAL enable_seqscan = off"))
            await connection.execute(text("SET LOCAL enable_bitmapscan = off"))
        statement, values = asked[0]
        plan = str((await connection.exec_driver_sql(PLAN[database] + statement, values)).all())
    assert "USING INDEX" in plan.upper() or "Index Scan" in plan
    assert "TEMP B-TREE" not in plan
    assert "Sort" not in plan

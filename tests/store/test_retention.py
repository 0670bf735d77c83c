"""What is forgotten, when, and what of it stays with the orders."""

from __future__ import annotations

import asyncio
import logging
import random
from dataclasses import dataclass
from typing import Any

import msgspec
import pytest
from alembic.script import ScriptDirectory
from history import Line, a_day, contracted, heartbeat, keep, made, order, same_clock, tell

from dray.errors import UnavailableError
from dray.messages import Event, Phase, Reason, TransportState
from dray.messages.fact import CarrierChanged, PhaseEntered, PieceMade
from dray.messages.keys import Keys
from dray.store import Historian, Store, downgrade, retention, upgrade
from dray.store.access.audit import AuditFilter, AuditRow
from dray.store.database.migrate import configuration
from dray.store.factory.alert_history import AlertFilter, NewAlert
from dray.store.history.events import EventFilter, EventRow
from dray.store.orders.order_histories import KINDS, OrderHistory, together
from dray.store.orders.progress import Goal, note
from dray.store.orders.tasks import TaskFilter
from dray.store.orders.transports import TransportRow
from dray.store.retention import Forgotten, KeptFor, Retention
from dray.store.work import Work

pytestmark = pytest.mark.anyio

NOW_S = 100_000.0

PATIENCE_S = 60.0
"""Longer only where it hangs."""

ALL = KeptFor(
    events_s=NOW_S,
    samples_s=NOW_S,
    figures_s=NOW_S,
    tasks_s=NOW_S,
    transports_s=NOW_S,
    alerts_s=NOW_S,
    audit_s=NOW_S,
    events_most=1_000_000,
)
"""Nothing is too old."""


@dataclass
class Wall:
    now_s: float = NOW_S

    def __call__(self) -> float:
        return self.now_s


def forgetting(store: Store, **kept: float) -> Retention:
    return Retention(store, msgspec.structs.replace(ALL, **kept), Wall())


@pytest.fixture(autouse=True)
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(retention, "PAUSE_S", 0.0)
    monkeypatch.setattr(retention, "REST", 0.0)


async def told(store: Store, *new: Event) -> None:
    """As the historian writes it."""
    async with store.write() as work:
        await work.events.add(new, same_clock)
        named = {goal for event in new if (goal := getattr(event.fact, "goal", ""))}
        goals = await work.goals.many(named)
        for event in new:
            if goal := getattr(event.fact, "goal", ""):
                note(goals.setdefault(goal, Goal(goal)), event, same_clock)
        await work.goals.put(goals.values())
        await work.tasks.follow(new, same_clock)


async def a_day_of_two_orders(store: Store) -> None:
    await keep(store, order(1, 4, 2), order(2, 1))
    carried = tell(
        "ATV-1",
        PhaseEntered(task="M1-1", epoch=1, phase=Phase.APPROACHING),
        PhaseEntered(task="M1-1", epoch=1, phase=Phase.CARRYING),
        PhaseEntered(task="M7-1", epoch=1, phase=Phase.CARRYING),
        at_s=210.0,
    )
    other = tell("strategist", contracted("G9", 0, 1, order="O-2"), made("G9", 1), first=9, at_s=400.0)
    await told(store, *a_day(), *carried, *other)


async def page(work: Work, order_id: str) -> list[EventRow]:
    logged = await work.events.page(EventFilter(kinds=KINDS, order=order_id), None, 1000, newest_first=False)
    return together(await work.order_histories.of_order(order_id), logged)


def numbers(rows: list[EventRow]) -> set[tuple[str, int]]:
    return {(row.agent, row.number) for row in rows}


async def test_what_an_orders_pages_need_outlives_the_log(store: Store) -> None:
    await a_day_of_two_orders(store)
    async with store.read() as work:
        before = {name: numbers(await page(work, name)) for name in ("O-1", "O-2")}
        times = await work.milestones.of_order("O-1")
    await forgetting(store, events_s=0.0).forget()
    async with store.read() as work:
        assert await work.events.page(EventFilter(), None, 10, newest_first=True) == []
        after = {name: numbers(await page(work, name)) for name in ("O-1", "O-2")}
        assert await work.milestones.of_order("O-1") == times
    # Of four pieces of G1 the first and the last one are enough; the carrier is in it, another order's is not.
    assert after["O-1"] == before["O-1"] - {("M1", 2), ("M1", 4)}
    assert {("ATV-1", 1), ("ATV-1", 2)} <= after["O-1"]
    assert ("ATV-1", 3) not in after["O-1"]
    assert after["O-2"] == before["O-2"]
    assert times.planned_at_s is not None
    assert times.left_at_s is not None


@pytest.mark.parametrize("at_once", [1, 2, 7, 500])
async def test_an_order_is_kept_whole_in_whatever_pieces_the_log_is_forgotten(
    store: Store, at_once: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(retention, "AT_ONCE", at_once)
    await a_day_of_two_orders(store)
    async with store.read() as work:
        before = numbers(await page(work, "O-1")) - {("M1", 2), ("M1", 4)}
    moments = [103.0, 205.0, 211.0, 301.0, NOW_S]
    for moment_s in moments:
        await forgetting(store, events_s=NOW_S - moment_s).forget()
        async with store.read() as work:
            assert before <= numbers(await page(work, "O-1"))
    async with store.read() as work:
        assert numbers(await page(work, "O-1")) == before


async def test_what_comes_after_an_order_was_kept_is_put_to_it(store: Store) -> None:
    await a_day_of_two_orders(store)
    await forgetting(store, events_s=0.0).forget()
    late = [
        *tell("M1", PieceMade(goal="G1", product="P1", made=5), first=20, at_s=500.0),
        *tell("ATV-1", PhaseEntered(task="M1-1", epoch=1, phase=Phase.HANDING_OVER), first=20),
    ]
    random.Random(3).shuffle(late)
    await told(store, *late)
    for _ in range(2):
        async with store.read() as work:
            assert {("M1", 20), ("ATV-1", 20), ("M1", 1)} <= numbers(await page(work, "O-1"))
        await forgetting(store, events_s=0.0).forget()
    async with store.read() as work:
        # It is the last piece now, and the one before it is not needed any more.
        assert ("M1", 7) not in numbers(await page(work, "O-1"))


async def test_an_order_is_put_together_once_and_not_with_each_batch(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(retention, "AT_ONCE", 1)
    await a_day_of_two_orders(store)
    kept: list[str] = []
    real = Work.__init__

    def counting(self: Work, connection: object) -> None:
        real(self, connection)  # type: ignore[arg-type]
        gather_one = self.order_histories._gathered

        async def noted(order_id: str) -> OrderHistory:
            kept.append(order_id)
            return await gather_one(order_id)

        self.order_histories._gathered = noted  # type: ignore[method-assign]

    monkeypatch.setattr(Work, "__init__", counting)
    await forgetting(store, events_s=0.0).forget()
    assert sorted(kept) == ["O-1", "O-2"]


async def test_the_log_is_forgotten_by_age_and_not_by_rows(store: Store) -> None:
    await told(store, *tell("M1", *[made("G1", 1)] * 20, at_s=NOW_S - 10.0))
    wanted = forgetting(store, events_s=5.0)
    await wanted.forget()
    async with store.read() as work:
        rows = await work.events.page(EventFilter(), None, 100, newest_first=False)
    assert [row.at_s for row in rows] == [NOW_S - 10.0 + number for number in range(5, 21)]
    assert wanted.too_many == 0


async def test_more_rows_than_there_is_room_for_are_forgotten_and_that_is_told(
    store: Store, caplog: pytest.LogCaptureFixture
) -> None:
    await told(store, *tell("M1", *[made("G1", 1)] * 20, at_s=NOW_S - 10.0))
    wanted = forgetting(store, events_s=NOW_S, events_most=4)
    with caplog.at_level(logging.WARNING):
        await wanted.forget()
        await wanted.forget()
    async with store.read() as work:
        rows = await work.events.page(EventFilter(), None, 100, newest_first=False)
    assert [row.number for row in rows] == [17, 18, 19, 20]
    assert wanted.too_many == 16
    (line,) = caplog.messages
    assert "16 events" in line
    assert "DRAY_EVENTS_MOST=4" in line


async def test_each_kind_has_an_age_of_its_own(store: Store) -> None:
    await a_day_of_two_orders(store)
    alert = NewAlert(
        alert="a-1", kind="machine_error", level="alarm", order="", since_at_s=10.0, told="{}", texts=("M1",)
    )
    async with store.write() as work:
        await work.samples.add([heartbeat(1, 10.0), heartbeat(2, NOW_S - 1)], same_clock)
        await work.audit.add(AuditRow(at_s=10.0, who="a", who_kind="admin", action="x", result="done"))
        await work.audit.add(AuditRow(at_s=NOW_S - 1, who="a", who_kind="admin", action="y", result="done"))
        await work.alerts.begin([alert])

    async def left() -> tuple[int, int, int, int]:
        async with store.read() as work:
            return (
                await work.samples.count(),
                len(await work.tasks.page(TaskFilter(), None, 100)),
                len(await work.alerts.page(AlertFilter(), None, 100)),
                len(await work.audit.page(AuditFilter(), None, 100)),
            )

    before = await left()
    await forgetting(store).forget()
    assert await left() == before == (2, 2, 1, 2)
    await forgetting(store, samples_s=5.0).forget()
    assert await left() == (1, 2, 1, 2)
    await forgetting(store, audit_s=5.0).forget()
    assert await left() == (1, 2, 1, 1)
    # One that lasts is not old, however long; nor is a task that has not ended.
    await forgetting(store, alerts_s=5.0, tasks_s=5.0).forget()
    assert await left() == (1, 1, 1, 1)
    async with store.write() as work:
        await work.alerts.end("a-1", 11.0, 20.0, "")
    await forgetting(store, alerts_s=5.0).forget()
    assert await left() == (1, 1, 0, 1)


async def test_a_plain_transport_that_has_ended_goes_by_its_age(store: Store) -> None:
    usual: dict[str, Any] = {
        "source": "S1",
        "destination": "M1",
        "item": "steel",
        "quantity": 1,
        "priority": "normal",
        "called_by": "x",
        "caller": "key x",
        "due_at_s": 1.0,
        "created_at_s": 1.0,
        "updated_at_s": 1.0,
    }
    ends = {"T-old": NOW_S - 20.0, "T-new": NOW_S - 2.0, "T-open": None}
    async with store.write() as work:
        for name, ended_at_s in ends.items():
            state = TransportState.WAITING if ended_at_s is None else TransportState.DELIVERED
            await work.transports.add(TransportRow(id=name, status=state, ended_at_s=ended_at_s, **usual))

    async def left() -> set[str]:
        async with store.read() as work:
            return {row.id for row in await work.transports.many(ends)}

    await forgetting(store).forget()
    assert await left() == set(ends)
    await forgetting(store, transports_s=10.0).forget()
    assert await left() == {"T-new", "T-open"}


async def test_a_takeover_is_kept_once_and_as_long_as_figures(store: Store) -> None:
    changed = CarrierChanged("M1-1", 2, "ATV-3", "ATV-1", Reason.SILENT, 4.0)
    nobody = CarrierChanged("M1-2", 2, "ATV-3", "", Reason.SILENT, 4.0)
    new = tell("M1", changed, nobody, at_s=10.0)
    async with store.write() as work:
        for _ in range(2):
            await work.events.add(new, same_clock)
            await work.takeovers.add(new, same_clock)

    async def known() -> tuple[int, list[CarrierChanged]]:
        async with store.read() as work:
            count, last = await work.takeovers.between(0.0, NOW_S, 10)
            assert await work.takeovers.since_s() == (11.0 if count else None)
        return count, [each.fact for each in last]

    assert await known() == (1, [changed])
    await forgetting(store, events_s=0.0).forget()
    assert await known() == (1, [changed])
    await forgetting(store, figures_s=0.0).forget()
    assert await known() == (0, [])


async def test_takeovers_of_before_are_read_from_the_log(store: Store) -> None:
    changed = CarrierChanged("M1-1", 2, "ATV-3", "ATV-1", Reason.SILENT, 4.0)
    nobody = CarrierChanged("M1-2", 2, "ATV-3", "", Reason.SILENT, 4.0)
    async with store.write() as work:
        await work.events.add(tell("M1", changed, nobody, made("G1", 1)), same_clock)
    before = next(
        each.down_revision
        for each in ScriptDirectory.from_config(configuration()).walk_revisions()
        if each.path.endswith("_takeovers.py")
    )
    assert isinstance(before, str)
    await downgrade(store.database, before)
    await upgrade(store.database)
    async with store.read() as work:
        count, last = await work.takeovers.between(0.0, NOW_S, 10)
    assert (count, [each.fact for each in last]) == (1, [changed])


async def test_all_else_has_its_turn_while_the_log_grows_as_fast_as_it_is_forgotten(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Growing(Retention):
        async def _events(self, before_s: float, now_s: float) -> Forgotten:
            return Forgotten(retention.AT_ONCE)

    monkeypatch.setattr(retention, "PAUSE_S", 0.0)
    async with store.write() as work:
        await work.audit.add(AuditRow(at_s=10.0, who="a", who_kind="admin", action="x", result="done"))
    growing = Growing(store, msgspec.structs.replace(ALL, audit_s=0.0), Wall())
    forgetting_on = asyncio.create_task(growing.forget())
    try:
        async with asyncio.timeout(PATIENCE_S):
            kept = 1
            while kept:
                async with store.read() as work:
                    kept = len(await work.audit.page(AuditFilter(), None, 100))
        assert not forgetting_on.done()
    finally:
        forgetting_on.cancel()
        await asyncio.gather(forgetting_on, return_exceptions=True)


async def test_a_database_that_is_away_is_tried_again(
    store: Store, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    looks = asyncio.Semaphore(0)

    class Failing(Retention):
        async def forget(self) -> None:
            looks.release()
            raise UnavailableError("database", "disk I/O error", "wait")

    monkeypatch.setattr(retention, "LOOK_EVERY_S", 0.0)
    historian = Historian(
        store=store,
        bus=Line(),
        keys=Keys("plant"),
        to_wall_s=same_clock,
        retention=Failing(store, ALL, Wall()),
    )
    with caplog.at_level(logging.WARNING):
        async with historian.running():
            for _ in range(3):
                await looks.acquire()
    assert "not forgotten yet" in caplog.text

"""What the historian keeps, and that nothing confuses it."""

from __future__ import annotations

import asyncio
import logging
import tempfile
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from random import Random
from typing import Any

import anyio
import pytest
from examples import examples
from history import (
    Line,
    a_day,
    accepted,
    contracted,
    delivered,
    heartbeat,
    keep,
    made,
    order,
    same_clock,
    tell,
)
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from postgres_databases import Postgres
from sqlalchemy import select
from sqlalchemy.exc import DataError

from dray.errors import UnavailableError
from dray.messages import Event, EventsAsked, EventsKept, Message, OrderTaken
from dray.messages.keys import Keys
from dray.store import Historian, Store, open_store
from dray.store import historian as historian_module
from dray.store.history import gaps as gaps_module
from dray.store.history.events import EventFilter, Events
from dray.store.orders.progress import OrderStatus
from dray.store.tables import events, goals, order_items, orders
from dray.store.work import Work

pytestmark = pytest.mark.anyio


@asynccontextmanager
async def writing(store: Store, **options: Any) -> AsyncIterator[tuple[Historian, Line]]:
    line = Line()
    historian = Historian(
        store=store, bus=line, keys=Keys("plant"), to_wall_s=same_clock, linger_s=0, **options
    )
    async with historian.running():
        yield historian, line


async def rows(store: Store) -> dict[str, list[dict[str, Any]]]:
    """Everything that the historian writes, except in what order and when it came."""
    found = {}
    async with store.database.read() as connection:
        for table in (orders, order_items, goals, events):
            kept = [dict(row._mapping) for row in await connection.execute(select(table))]
            for row in kept:
                row.pop("position", None)
                row.pop("updated_at_s", None)
            found[table.name] = sorted(kept, key=str)
    return found


async def test_a_day_is_kept_and_its_order_delivered(store: Store) -> None:
    await keep(store, order(1, 4, 2))
    async with writing(store) as (historian, line):
        assert line.keys == ["plant/event/*", "plant/hb/**"]
        line.say(a_day())
        await historian.written()
        async with store.read() as work:
            found = await work.orders.get("O-1")
            kept = await work.events.page(EventFilter(), None, 100, newest_first=False)
    assert found is not None
    assert found.status is OrderStatus.DELIVERED
    assert [item.delivered for item in found.items] == [4, 2]
    assert found.delivered_at_s == 303.0
    assert len(kept) == len(a_day())
    assert (historian.missing, historian.lost) == (0, 0)


@settings(
    max_examples=examples(15), deadline=None, suppress_health_check=[HealthCheck.too_slow], derandomize=True
)
@given(seed=st.integers(0, 2**32), doubled=st.lists(st.sampled_from(a_day()), max_size=20))
def test_shuffled_and_doubled_events_leave_the_same_rows(seed: int, doubled: list[Event]) -> None:
    shuffled = a_day() + doubled
    Random(seed).shuffle(shuffled)

    async def kept(told: Sequence[Sequence[Event]]) -> dict[str, list[dict[str, Any]]]:
        with tempfile.TemporaryDirectory() as folder:
            store = await open_store(f"sqlite+aiosqlite:///{Path(folder) / 'dray.db'}")
            await keep(store, order(1, 4, 2))
            async with writing(store) as (historian, line):
                for batch in told:
                    line.say(batch)
                    await historian.written()
            found = await rows(store)
            await store.close()
            return found

    cut = seed % len(shuffled)
    assert anyio.run(kept, [shuffled[:cut], shuffled[cut:]]) == anyio.run(kept, [a_day()])


async def test_what_was_missed_is_kept_though_whoever_listens_beside_fails_on_it(store: Store) -> None:
    def fail(_event: Event) -> None:
        raise KeyError("of a bug in the projection")

    told, line = a_day()[:4], Line()
    historian = Historian(store=store, bus=line, keys=Keys("plant"), to_wall_s=same_clock, linger_s=0)
    async with historian.running(fail):
        by_agent = sorted(told, key=lambda event: (event.agent, event.number), reverse=True)
        failed = 0
        for event in by_agent:
            try:
                line.say([event])
            except KeyError:
                failed += 1
        await historian.written()
    assert failed
    assert len((await rows(store))["events"]) == len(told)


async def test_what_was_heard_is_written_before_it_ends(store: Store) -> None:
    await keep(store, order(1, 4, 2))
    async with writing(store) as (_, line):
        line.say(a_day())
    assert len((await rows(store))["events"]) == len(a_day())


async def test_a_cancelled_order_stays_cancelled(store: Store) -> None:
    await keep(store, order(1, 4, 2, status=OrderStatus.CANCELLED))
    async with writing(store) as (_, line):
        line.say(a_day())
    async with store.read() as work:
        found = await work.orders.get("O-1")
    assert found is not None
    assert found.status is OrderStatus.CANCELLED


async def test_after_a_restart_only_what_was_delivered_still_counts(store: Store) -> None:
    await keep(store, order(1, 4))
    first_life = [
        *tell("strategist", accepted("G1"), contracted("G1", 0, 4)),
        *tell("M1", made("G1", 1), made("G1", 2), made("G1", 3), delivered("G1", 0, 2)),
    ]
    async with writing(store) as (_, line):
        line.say(first_life)
    async with writing(store) as (historian, line):
        line.say(tell("strategist", accepted("Gr2"), life=2))
        await historian.written()
        async with store.read() as work:
            found = await work.orders.get("O-1")
    assert found is not None
    assert (found.items[0].made, found.items[0].delivered) == (2, 2)
    assert found.outstanding == (2,)


async def test_events_about_orders_of_somebody_else_are_kept_all_the_same(store: Store) -> None:
    async with writing(store) as (_, line):
        line.say(a_day())
    assert len((await rows(store))["events"]) == len(a_day())


# --- what it has not heard -------------------------------------------------------------------------


class Told:
    """Agents that keep what they have told: the newest `keep` events of a life."""

    def __init__(self, events: Sequence[Event], keep: int = 1_000) -> None:
        self._kept: dict[tuple[str, int], list[Event]] = {}
        for event in events:
            self._kept.setdefault((event.agent, event.incarnation), []).append(event)
        self._kept = {life: told[-keep:] for life, told in self._kept.items()}

    def __call__(self, agent: str, asked: EventsAsked) -> list[Message]:
        life = max(life for name, life in self._kept if name == agent)
        told = self._kept.get((agent, asked.incarnation), [])
        first, last = (told[0].number, told[-1].number) if told else (1, 0)
        kept = EventsKept(incarnation=asked.incarnation, first=first, last=last, life=life)
        return [*(event for event in told if asked.first <= event.number <= asked.last), kept]


@pytest.fixture
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    """No waiting before an agent is asked, or asked again."""
    monkeypatch.setattr(historian_module, "ASK_EVERY_S", 0.0)
    monkeypatch.setattr(gaps_module, "SETTLE_S", 0.0)
    monkeypatch.setattr(gaps_module, "AGAIN_S", (0.0, 0.0))


async def until(done: Callable[[], bool]) -> None:
    """Give the others their turn until it is so."""
    for _ in range(100_000):
        if done():
            return
        await asyncio.sleep(0)
    pytest.fail("it never came to that")


def without(*missed: tuple[str, int]) -> list[Event]:
    return [event for event in a_day() if (event.agent, event.number) not in missed]


@pytest.mark.usefixtures("soon")
async def test_what_was_not_heard_is_asked_for_and_the_day_is_whole(store: Store) -> None:
    await keep(store, order(1, 4, 2))
    async with writing(store) as (historian, line):
        line.answer = Told(a_day())
        # The last one of M2 among them: nothing that was heard tells that it was missed.
        line.say(without(("M1", 3), ("M1", 6), ("M2", 3)))
        assert historian.missing == 2
        await until(lambda: historian.missing == 0 and len(line.asked) >= 3)
        await historian.written()
    kept = (await rows(store))["events"]
    assert len(kept) == len(a_day())
    assert historian.gone == 0


@pytest.mark.usefixtures("soon")
async def test_what_happened_while_the_historian_was_away_is_asked_for(store: Store) -> None:
    async with writing(store) as (_, line):
        line.say(without(("M1", 2))[:9])
    afterwards = tell("M1", made("G1", 5), life=2)
    async with writing(store) as (historian, line):
        assert historian.missing == 1
        line.answer = Told([*a_day(), *afterwards])
        await until(lambda: historian.missing == 0 and len(line.asked) >= 4)
        await historian.written()
    numbers = [(row["agent"], row["incarnation"], row["number"]) for row in (await rows(store))["events"]]
    assert sorted(numbers) == sorted(
        (event.agent, event.incarnation, event.number)
        for event in [*a_day(), *afterwards]
        # Nobody has ever heard of M2, and it says nothing now either.
        if event.agent != "M2"
    )


@pytest.mark.usefixtures("soon")
async def test_what_agents_have_forgotten_is_a_hole_that_is_counted_and_logged(
    store: Store, caplog: pytest.LogCaptureFixture
) -> None:
    async with writing(store) as (historian, line):
        line.answer = Told(a_day(), keep=4)
        with caplog.at_level(logging.WARNING):
            line.say(event for event in a_day() if (event.agent, event.number) in {("M1", 1), ("M1", 8)})
            await until(lambda: historian.missing == 0)
        await historian.written()
    assert historian.gone == 3
    assert "M1 no longer has 3 events, of its life 1" in caplog.text
    assert [row["number"] for row in (await rows(store))["events"]] == [1, 5, 6, 7, 8]


@pytest.mark.usefixtures("soon")
async def test_what_a_full_queue_has_dropped_is_asked_for_again(store: Store) -> None:
    async with writing(store, queue_events=5) as (historian, line):
        line.answer = Told(a_day())
        line.say(a_day())
        assert historian.lost == len(a_day()) - 5
        await historian.written()
        await until(lambda: historian.missing == 0 and len(line.asked) >= 6)
        await historian.written()
    assert len((await rows(store))["events"]) == len(a_day())


@pytest.mark.usefixtures("soon")
async def test_nobody_is_asked_while_the_database_cannot_be_written(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    @asynccontextmanager
    async def away(_: Store) -> AsyncIterator[Work]:
        raise UnavailableError("database", "disk I/O error", "wait")
        yield

    async with writing(store) as (historian, line):
        monkeypatch.setattr(Store, "write", away)
        historian.failing = True
        line.say(without(("M1", 3)))
        for _ in range(100):
            await asyncio.sleep(0)
        assert line.asked == []


async def test_pruned_events_are_no_holes(store: Store) -> None:
    async with writing(store) as (_, line):
        line.say(a_day())
    async with store.write() as work:
        await work.events.forget(1, len(a_day()) - 5)
    async with writing(store) as (historian, _):
        assert historian.missing == 0


async def test_a_full_queue_drops_the_newest_and_counts_them(store: Store) -> None:
    async with writing(store, queue_events=5) as (historian, line):
        line.say(a_day())
    assert historian.lost == len(a_day()) - 5
    assert [row["number"] for row in (await rows(store))["events"]] == [1, 2, 3, 4, 5]


async def test_heartbeats_are_sampled(store: Store) -> None:
    async with writing(store) as (historian, line):
        line.say(heartbeat(seq, float(seq)) for seq in range(100))
        line.say([heartbeat(1, 1.0, "ATV-2")])
        await historian.written()
        async with store.read() as work:
            assert await work.samples.count() == 5
        line.say([heartbeat(200, 5.0)])
    # The clock went back: a new life of the plant, whose heartbeats count at once.
    async with store.read() as work:
        assert await work.samples.count() == 6


async def test_a_database_that_fails_for_a_while_loses_nothing(
    store: Store, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    await keep(store, order(1, 4, 2))
    real, failures = Store.write, [2]

    @asynccontextmanager
    async def failing(self: Store) -> AsyncIterator[Work]:
        if failures[0]:
            failures[0] -= 1
            raise UnavailableError("database", "disk I/O error", "wait")
        async with real(self) as work:
            yield work

    async with writing(store, retry_s=(0.0, 0.0)) as (historian, line):
        monkeypatch.setattr(Store, "write", failing)
        with caplog.at_level(logging.WARNING):
            line.say(a_day())
            await historian.written()
        assert not historian.failing
    assert "disk I/O error" in caplog.text
    assert len((await rows(store))["events"]) == len(a_day())
    assert historian.lost == 0


async def test_one_event_that_can_never_be_written_does_not_take_others_with_it(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = Events.add

    async def picky(self: Events, new: Sequence[Event], to_wall_s: Any) -> None:
        if any((event.agent, event.number) == ("M1", 2) for event in new):
            raise DataError("INSERT", {}, Exception("value too long"))
        await real(self, new, to_wall_s)

    monkeypatch.setattr(Events, "add", picky)
    async with writing(store) as (historian, line):
        line.say(a_day())
    assert historian.lost == 1
    assert len((await rows(store))["events"]) == len(a_day()) - 1


async def test_a_server_that_is_started_anew_loses_nothing(postgres: Postgres, postgresql_url: str) -> None:
    store = await open_store(postgresql_url)
    await keep(store, order(1, 4, 2))
    day = a_day()
    async with writing(store, retry_s=(0.0, 0.0)) as (historian, line):
        line.say(day[:5])
        await historian.written()
        postgres.stop()
        try:
            line.say(day[5:])
            while not historian.failing:  # noqa: ASYNC110 - it tells nobody that it fails
                await asyncio.sleep(0)
        finally:
            postgres.start()
        await historian.written()
    assert len((await rows(store))["events"]) == len(day)
    assert historian.lost == 0
    await store.close()


async def test_an_event_whose_numbers_are_too_large_for_the_database_is_given_up(postgresql_url: str) -> None:
    store = await open_store(postgresql_url)
    async with writing(store) as (historian, line):
        line.say([*tell("M1", made("G1", 1)), *tell("M2", made("G2", 1), life=2**40)])
    assert [row["agent"] for row in (await rows(store))["events"]] == ["M1"]
    assert historian.lost == 1
    await store.close()


async def test_other_messages_are_nothing_to_it(store: Store) -> None:
    async with writing(store) as (historian, line):
        line.say([OrderTaken(order="O-1")])
        await historian.written()
    assert (await rows(store))["events"] == []

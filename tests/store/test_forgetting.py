"""What goes on while the log is forgotten: others that forget it too, readers half way through it, clocks that are set, and a database that dies."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from typing import Any

import pytest
from history import a_day, heartbeat, keep, made, order, same_clock, tell

from dray.adapters.system_clock import SystemClock
from dray.errors import UnavailableError
from dray.messages import Phase
from dray.messages.fact import PhaseEntered
from dray.store import Store, open_store, retention
from dray.store.history.events import EventFilter
from dray.store.orders.order_histories import KINDS, OrderHistories, OrderHistory, together
from dray.store.orders.progress import Goal, note
from dray.store.retention import DAY_S, KeptFor, Retention
from dray.store.work import Work
from dray_sim.bench.postgres import PostgresServer

pytestmark = pytest.mark.anyio

NOW_S = 100_000.0

Numbers = set[tuple[str, int]]


@pytest.fixture(autouse=True)
def in_small_pieces(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(retention, "PAUSE_S", 0.0)
    # Work that this test does meanwhile would count as that of forgetting, and be rested from in real time.
    monkeypatch.setattr(retention, "REST", 0.0)
    monkeypatch.setattr(retention, "AT_ONCE", 3)
    return


KEPT: dict[str, Any] = dict.fromkeys(KeptFor.__struct_fields__, 1e9) | {"events_most": 1_000_000}
"""All but the log is kept for ever."""


def forgetting(store: Store, events_s: float = 0.0, wall_s: float = NOW_S) -> Retention:
    return Retention(store, KeptFor(**KEPT | {"events_s": events_s}), lambda: wall_s)


async def lived_through(store: Store) -> Numbers:
    """A day of order O-1 is kept; returns what its page needs."""
    await keep(store, order(1, 4, 2))
    async with store.write() as work:
        await work.events.add(a_day(), same_clock)
        goals = {name: Goal(name) for name in ("G1", "G2")}
        for event in a_day():
            if (goal := getattr(event.fact, "goal", "")) in goals:
                note(goals[goal], event, same_clock)
        await work.goals.put(goals.values())
        await work.tasks.follow(a_day(), same_clock)
    # Of four pieces of G1 the first and the last one are enough.
    return await on_page(store) - {("M1", 2), ("M1", 4)}


async def on_page(store: Store) -> Numbers:
    async with store.read() as work:
        logged = await work.events.page(EventFilter(kinds=KINDS, order="O-1"), None, 1000, newest_first=False)
        kept = await work.order_histories.of_order("O-1")
    return {(row.agent, row.number) for row in together(kept, logged)}


async def logged(store: Store) -> list[int]:
    async with store.read() as work:
        return [row.number for row in await work.events.page(EventFilter(), None, 1000, newest_first=False)]


async def test_two_that_forget_at_once_lose_nothing_of_an_order(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    needed = await lived_through(store)
    gathered = OrderHistories.gathered
    late = iter(range(20, 23))

    async def and_then_somebody_else(self: OrderHistories, first: int, last: int) -> list[OrderHistory]:
        """Before what was read is written, more is told of the order, and another has forgotten that too: what was read is old."""
        found = await gathered(self, first, last)
        number = next(late, None)
        if number is not None:
            more = tell("ATV-1", PhaseEntered("M1-1", 1, Phase.CARRYING, "M1"), first=number, at_s=220.0)
            async with store.write() as work:
                await work.events.add(more, same_clock)
            await forgetting(store).forget()
        return found

    monkeypatch.setattr(OrderHistories, "gathered", and_then_somebody_else)
    await forgetting(store).forget()
    assert await logged(store) == []
    assert await on_page(store) == needed | {("ATV-1", 20), ("ATV-1", 21), ("ATV-1", 22)}


async def test_whoever_turns_the_pages_of_the_log_while_it_is_forgotten_misses_only_what_is_gone(
    store: Store,
) -> None:
    async with store.write() as work:
        await work.events.add(tell("M1", *[made("G1", 1)] * 30, at_s=NOW_S - 100.0), same_clock)
    seen: list[int] = []
    after: int | None = None
    kept_s = iter([95.0, 85.0, 80.0, 75.0])
    while True:
        async with store.read() as work:
            page = await work.events.page(EventFilter(), after, 5, newest_first=False)
        if not page:
            break
        seen += [row.number for row in page]
        after = page[-1].position
        await forgetting(store, events_s=next(kept_s, 75.0)).forget()
    assert seen == sorted(set(seen))
    assert set(seen) >= set(await logged(store)) == set(range(25, 31))


async def test_one_reading_of_an_order_sees_all_of_it_though_the_log_is_forgotten_meanwhile(
    store: Store,
) -> None:
    needed = await lived_through(store)
    async with store.read() as work:
        kept = await work.order_histories.of_order("O-1")
        await forgetting(store).forget()
        wanted = EventFilter(kinds=KINDS, order="O-1")
        log = await work.events.page(wanted, None, 1000, newest_first=False)
        times = await work.milestones.of_order("O-1")
    assert {(row.agent, row.number) for row in together(kept, log)} >= needed
    assert times.first_piece_at_s == 201.0
    assert await on_page(store) == needed


async def test_a_clock_that_was_set_back_lets_nothing_be_forgotten_that_is_young(store: Store) -> None:
    async with store.write() as work:
        await work.events.add(tell("M1", *[made("G1", 1)] * 4, at_s=NOW_S + 3600.0), same_clock)
        await work.events.add(tell("M1", *[made("G1", 1)] * 4, first=5, at_s=NOW_S), same_clock)
    await forgetting(store, events_s=DAY_S).forget()
    assert len(await logged(store)) == 8
    # It waits for as long as the clock was wrong, and not for ever.
    await forgetting(store, events_s=DAY_S, wall_s=NOW_S + DAY_S + 4000.0).forget()
    assert await logged(store) == []


@pytest.mark.parametrize("ahead", [1, 7], ids=["some", "more than go at once"])
async def test_what_was_kept_by_a_clock_a_year_ahead_is_forgotten_with_what_came_after_it(
    store: Store, ahead: int
) -> None:
    old_s, young_s = NOW_S - 2 * DAY_S, NOW_S - 10.0
    async with store.write() as work:
        await work.events.add(tell("M1", *[made("G1", 1)] * ahead, at_s=NOW_S + 365 * DAY_S), same_clock)
        await work.events.add(tell("M1", *[made("G1", 1)] * 4, first=ahead + 1, at_s=old_s), same_clock)
        ends = tell("M1", *[made("G1", 1)] * 2, first=ahead + 5, at_s=NOW_S + 365 * DAY_S)
        await work.events.add(ends, same_clock)
        await work.events.add(tell("M1", *[made("G1", 1)] * 3, first=ahead + 7, at_s=young_s), same_clock)
        await work.samples.add([heartbeat(1, NOW_S + 365 * DAY_S)] * ahead, same_clock)
        await work.samples.add([heartbeat(1, old_s)] * 4, same_clock)
        await work.samples.add([heartbeat(1, young_s)] * 2, same_clock)
    wanted = Retention(store, KeptFor(**KEPT | {"events_s": DAY_S, "samples_s": DAY_S}), lambda: NOW_S)
    await wanted.forget()
    # Who came before those that are young is not young for the time that it told, and who came just before them may be.
    assert await logged(store) == [ahead + 5, ahead + 6, ahead + 7, ahead + 8, ahead + 9]
    assert wanted.too_many == 0
    async with store.read() as work:
        assert await work.samples.count() == 2


async def test_where_nothing_came_after_it_what_a_clock_ahead_kept_is_not_forgotten_by_its_age(
    store: Store,
) -> None:
    async with store.write() as work:
        await work.events.add(tell("M1", *[made("G1", 1)] * 7, at_s=NOW_S + 365 * DAY_S), same_clock)
    await forgetting(store, events_s=DAY_S).forget()
    assert len(await logged(store)) == 7


async def test_a_computers_clock_that_is_set_ahead_makes_nothing_old(store: Store) -> None:
    unix_s = [NOW_S]
    wall = SystemClock(asyncio.get_running_loop(), unix_s=lambda: unix_s[0])
    async with store.write() as work:
        await work.events.add(tell("M1", *[made("G1", 1)] * 4, at_s=NOW_S - 100.0), same_clock)
    wanted = forgetting(store, events_s=14 * DAY_S)
    wanted._wall_s = wall.now_s
    unix_s[0] += 400 * DAY_S
    await wanted.forget()
    assert len(await logged(store)) == 4
    assert wall.steps == 1


class Mortal(Store):
    """A store whose server dies once, when so many transactions have been written and one is under way."""

    def __init__(self, store: Store, server: PostgresServer, after: int) -> None:
        super().__init__(store.database)
        self._server, self._left = server, after

    @asynccontextmanager
    async def write(self) -> AsyncIterator[Work]:
        async with super().write() as work:
            yield work
            self._left -= 1
            if self._left == 0:
                await self._server.kill()


@pytest.mark.parametrize("after", [1, 2, 4])
async def test_a_database_that_dies_while_it_forgets_has_lost_nothing_of_an_order(
    mortal_postgres: PostgresServer, after: int
) -> None:
    store = await open_store(mortal_postgres.url())
    try:
        needed = await lived_through(store)
        before = len(await logged(store))
        wanted = forgetting(Mortal(store, mortal_postgres, after))
        with pytest.raises(UnavailableError):
            await wanted.forget()
        with pytest.raises(UnavailableError):
            await wanted.forget()
        mortal_postgres.start()
        assert len(await logged(store)) == before - 3 * (after - 1)
        assert await on_page(store) >= needed
        await wanted.forget()
        assert await logged(store) == []
        assert await on_page(store) == needed
    finally:
        await store.close()

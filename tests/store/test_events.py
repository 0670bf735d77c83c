"""Finding events."""

from __future__ import annotations

import msgspec
import pytest
from history import a_day, accepted, delivered, keep, made, order, same_clock, tell

from dray.messages.history import HISTORY_KEPT
from dray.store import Store
from dray.store.history.events import EventFilter, EventRow
from dray.store.history.gaps import LIVES, Known
from dray.store.orders.progress import Goal

pytestmark = pytest.mark.anyio


@pytest.fixture
async def kept(store: Store) -> Store:
    await keep(store, order(1, 4, 2))
    other = tell("M9", delivered("G9", 0, 1, order="O-9"))
    async with store.write() as work:
        await work.events.add(a_day() + other, same_clock)
        await work.goals.put([Goal("G1", order_id="O-1"), Goal("G2", order_id="O-1"), Goal("G9", "O-9")])
    return store


async def found(store: Store, **wanted: object) -> list[EventRow]:
    async with store.read() as work:
        return await work.events.page(
            EventFilter(**wanted),  # type: ignore[arg-type]
            None,
            100,
            newest_first=False,
        )


async def test_events_are_found_by_kind_agent_and_task(kept: Store) -> None:
    assert {row.kind for row in await found(kept, kinds=("PieceMade",))} == {"PieceMade"}
    assert {row.agent for row in await found(kept, agents=("M1", "M2"))} == {"M1", "M2"}
    assert [row.kind for row in await found(kept, task="M1-1")] == ["TaskOpened", "TaskClosed"]
    assert await found(kept, kinds=("PieceMade",), agents=("strategist",)) == []


async def test_all_that_happened_for_an_order_is_found(kept: Store) -> None:
    rows = await found(kept, order="O-1")
    assert len(rows) == len(a_day())
    assert "M1-1" in {row.task for row in rows}
    assert [row.agent for row in await found(kept, order="O-9")] == ["M9"]


async def test_what_has_happened_since_comes_in_the_order_of_the_plants_clock(store: Store) -> None:
    late = tell("M1", made("G1", 2), first=2, at_s=300.0)
    early = tell("M2", made("G2", 1), accepted("G2"), at_s=200.0)
    first = tell("M1", made("G1", 1), at_s=100.0)
    async with store.write() as work:
        await work.events.add([*late, *early, *first], lambda plant_s: -plant_s)
    async with store.read() as work:
        since = await work.events.since(("PieceMade",), 100.0, 10)
        newest = await work.events.since(("PieceMade", "OrderAccepted"), 150.0, 2)
    assert [row.plant_s for row in since] == [101.0, 201.0, 302.0]
    assert [(row.plant_s, row.kind) for row in newest] == [(202.0, "OrderAccepted"), (302.0, "PieceMade")]


async def test_pages_in_both_directions_miss_nothing(kept: Store) -> None:
    async with kept.read() as work:
        for newest_first in (False, True):
            seen: list[int] = []
            after = None
            while page := await work.events.page(EventFilter(), after, 4, newest_first=newest_first):
                seen += [row.position for row in page]
                after = seen[-1]
            assert seen == sorted(seen, reverse=newest_first)
            assert len(seen) == len(a_day()) + 1


async def test_a_fact_is_kept_as_it_was_told(kept: Store) -> None:
    (row,) = await found(kept, kinds=("OrderAccepted",))
    told = {"kind": "OrderAccepted", "order": "O-1", "goals": ["G1", "G2"], "held": 0}
    assert msgspec.json.decode(row.fact) == told
    assert (row.agent, row.incarnation, row.number, row.order_id) == ("strategist", 1, 1, "O-1")


async def test_positions_of_pruned_events_are_never_given_again(kept: Store) -> None:
    last = (await found(kept))[-1].position
    async with kept.write() as work:
        await work.events.forget(1, last)
        await work.events.add(tell("M1", delivered("G1", 0, 4), life=2), same_clock)
    (row,) = await found(kept)
    assert row.position > last


async def test_the_newest_lives_are_known_with_their_holes(store: Store) -> None:
    lives = range(1, LIVES + 2)
    async with store.write() as work:
        for life in lives:
            told = tell("M1", *[made("G1", 1)] * 9, life=life)
            await work.events.add(
                [event for event in told if event.number not in {2, 3 + life % 6}], same_clock
            )
        await work.events.add(tell("M2", made("G2", 1), first=3), same_clock)
        assert await work.events.known() == [
            *(Known("M1", life, 9, (2, 3 + life % 6), is_first_asked=life == lives[1]) for life in lives[1:]),
            Known("M2", 1, 3, (1, 2)),
        ]


async def test_of_a_long_history_only_what_an_agent_may_still_have_is_looked_through(store: Store) -> None:
    told = tell("M1", *[made("G1", 1)] * (HISTORY_KEPT + 10))
    async with store.write() as work:
        await work.events.add([event for event in told if event.number not in {3, HISTORY_KEPT}], same_clock)
        assert await work.events.known() == [Known("M1", 1, HISTORY_KEPT + 10, (HISTORY_KEPT,))]


async def test_pruned_events_are_not_missing(store: Store) -> None:
    async with store.write() as work:
        await work.events.add(tell("M1", *[made("G1", 1)] * 9), same_clock)
        await work.events.forget(1, 5)
        assert await work.events.known() == [Known("M1", 1, 9, is_first_asked=True)]

"""The data of the benchmark `history` is what a factory could have left."""

from __future__ import annotations

import msgspec
import pytest

from dray.gateway.orders.timeline import timeline
from dray.messages.fact import AnyFact
from dray.store.history.events import EventFilter
from dray.store.orders.order_histories import KINDS
from dray_sim.bench import history
from dray_sim.bench.history import measured, use
from dray_sim.bench.history.data import EVENTS_EACH, filled

pytestmark = pytest.mark.anyio

ORDERS = 100


@pytest.fixture
def anyio_backend() -> str:
    return "asyncio"


async def test_it_has_no_holes_and_tells_every_order_whole(url: str) -> None:
    async with filled(url, ORDERS) as store, store.read() as work:
        told = await work.events.page(EventFilter(), None, 2 * ORDERS * EVENTS_EACH, newest_first=False)
        known = await work.events.known()
        rows = await work.events.page(EventFilter(kinds=KINDS, order="O-99"), None, 100, newest_first=False)
        goals = (await work.goals.of_orders(["O-99"]))["O-99"]
        of_order = await work.milestones.of_order("O-99")
    assert len(told) == ORDERS * EVENTS_EACH
    assert not any(each.missing for each in known)
    for row in told:
        msgspec.json.decode(row.fact, type=AnyFact)
    assert [row.at_s for row in told] == sorted(row.at_s for row in told)
    view = timeline(rows, goals)
    kinds = [each.kind for each in view.moments]
    assert kinds == ["planned", "began", "fetched", "handed_over", "arrived", "delivered", "took_over"]
    assert None not in (of_order.planned_at_s, of_order.first_piece_at_s, of_order.left_at_s)


async def test_all_that_it_asks_for_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    # How often it asks is for the benchmark's figures.
    for often in ("SEARCHES", "PAGES"):
        monkeypatch.setattr(use, often, 3)
    monkeypatch.setattr(history, "BARE_ROUNDS", 3)
    monkeypatch.setattr(history, "ROUNDS", 1)
    for row in await measured(ORDERS, before=1):
        # One order in ten thousand has D5 in its name.
        if " rows;" in row.note and "D5" not in row.name and "a vehicle" not in row.name:
            assert int(row.note.split()[0]) > 0, row.name

"""A `dray up` by a clock that stands: time passes only when a test says so, for factory and gateway alike."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest

SPEED = 20.0


@pytest.fixture(scope="module")
def dray(start_dray: Callable[..., Any]) -> Iterator[Any]:
    dray = start_dray("--speed", f"{SPEED:g}", "--no-demand", stepped=True)
    dray.advance(5.0)
    yield dray
    assert dray.stop() == 0, dray.output()


def seen_at_s(dray: Any) -> list[float]:
    return [atv["seen_at_s"] for atv in dray.ask("/api/atvs")["items"]]


def test_it_stands_however_often_it_is_asked(dray: Any) -> None:
    before = dray.wall_s, seen_at_s(dray)
    assert all((dray.wall_s, seen_at_s(dray)) == before for _ in range(20))


def test_it_moves_by_what_it_is_told_and_vehicles_are_heard_until_then(dray: Any) -> None:
    before_s = dray.wall_s
    now_s = dray.advance(200.0)
    assert now_s - before_s == pytest.approx(200.0 / SPEED, abs=1e-3)
    # An idle vehicle beats every ten seconds at least.
    assert all(now_s - 10.0 / SPEED <= seen_s <= now_s for seen_s in seen_at_s(dray))


def test_it_stops_as_soon_as_it_is_so(dray: Any) -> None:
    order = {"customer": "Hall 3", "items": [{"product": "gear-unit-g1", "quantity": 2}]}
    path = f"/api/orders/{dray.ask('/api/orders', order)['id']}"
    assert dray.ask(path)["status"] == "released"
    dray.advance_until(lambda: dray.ask(path)["status"] == "in_production", 60.0)
    with pytest.raises(AssertionError, match="not so after 4 s"):
        dray.advance_until(lambda: dray.ask(path)["status"] == "cancelled", 4.0)


def test_it_goes_while_it_is_let_and_no_longer(dray: Any) -> None:
    before_s = dray.wall_s
    with dray.going():
        while dray.wall_s < before_s + 0.2:
            """Real time passes while it answers."""
    now_s = dray.wall_s
    assert now_s >= before_s + 0.2
    assert dray.wall_s == now_s

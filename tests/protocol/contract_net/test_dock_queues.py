"""Who is expected at a dock, and how long the next one will stand behind them."""

from __future__ import annotations

import pytest

from dray.messages import DockExpected
from dray.protocol.contract_net.dock_queues import (
    AHEAD_MAX_S,
    GONE_AFTER_S,
    SOON_S,
    STAY_MAX_S,
    TURN_GAIN,
    TURN_S,
    DockQueues,
    wait_s,
)

PLACE = "DELIVERY"


def expected(comes_s: float, stays_s: float = 15.0, *, docked: bool = False) -> DockExpected:
    return DockExpected(place=PLACE, comes_s=comes_s, stays_s=stays_s, docked=docked)


def heard(**times: DockExpected) -> DockQueues:
    docks = DockQueues()
    for atv, said in times.items():
        docks.on_expected(atv, said, 0.0)
    return docks


def leaves(docks: DockQueues, now_s: float = 0.0) -> dict[str, float]:
    return {time.atv: time.leaves_s for time in docks.told(PLACE, now_s)}


def test_vehicles_follow_one_another_as_they_come_each_after_a_turn() -> None:
    docks = heard(B=expected(110.0), A=expected(100.0), C=expected(200.0))
    assert leaves(docks) == {"A": 115.0 + TURN_S, "B": 130.0 + 2.0 * TURN_S, "C": 215.0 + TURN_S}


def test_a_vehicle_stands_behind_all_that_come_before_it_and_behind_nobody_else() -> None:
    times = heard(A=expected(100.0), B=expected(110.0)).told(PLACE, 0.0)
    assert wait_s(times, 100.0 - SOON_S - 1.0, "D") == 0.0
    assert wait_s(times, 100.0 - SOON_S, "D") == SOON_S + 15.0 + TURN_S, "either may be the first"
    assert wait_s(times, 104.0, "D") == 11.0 + TURN_S
    assert wait_s(times, 120.0, "D") == 10.0 + 2.0 * TURN_S
    assert wait_s(times, 120.0, "B") == TURN_S - 5.0, "its own word does not count"
    assert wait_s(times, 300.0, "D") == 0.0
    assert wait_s((), 120.0, "D") == 0.0


def test_its_newest_word_counts_and_who_is_done_is_there_no_more() -> None:
    docks = heard(A=expected(100.0))
    docks.on_expected("A", expected(140.0), 50.0)
    assert leaves(docks, 50.0) == {"A": 155.0 + TURN_S}
    docks.on_expected("A", expected(150.0, docked=True), 150.0)
    assert leaves(docks, 170.0) == {"A": 170.0 + TURN_S}, "it takes longer than it said, and is not done"
    docks.on_expected("A", expected(170.0, 0.0), 170.0)
    assert leaves(docks, 170.0) == {}


def test_how_long_a_turn_takes_is_learned_from_one_that_was_waiting() -> None:
    docks = heard(A=expected(100.0, docked=True), B=expected(105.0), C=expected(125.0))
    docks.on_expected("A", expected(115.0, 0.0), 115.0)
    docks.on_expected("B", expected(135.0, docked=True), 135.0)
    turn_s = TURN_S + TURN_GAIN * (20.0 - TURN_S)
    assert leaves(docks, 135.0)["B"] == 150.0 + turn_s
    docks.on_expected("B", expected(120.0, 0.0), 150.0)
    docks.on_expected("D", expected(185.0, docked=True), 185.0)
    assert leaves(docks, 185.0)["D"] == pytest.approx(200.0 + turn_s), "nobody has waited"


@pytest.mark.parametrize(
    "said",
    [
        expected(10.0, STAY_MAX_S + 1.0),
        expected(10.0, -1.0),
        expected(AHEAD_MAX_S + 1.0),
        expected(10.0, float("nan")),
        expected(float("inf")),
    ],
)
def test_what_cannot_be_counts_for_nothing(said: DockExpected) -> None:
    assert leaves(heard(A=said)) == {}


def test_one_that_should_have_left_long_ago_is_forgotten() -> None:
    docks = heard(A=expected(100.0))
    assert list(leaves(docks, 115.0 + GONE_AFTER_S)) == ["A"]
    assert leaves(docks, 116.0 + GONE_AFTER_S) == {}


def test_who_comes_stands_behind_all_others_and_not_behind_itself() -> None:
    docks = heard(A=expected(100.0), B=expected(100.0 + SOON_S))
    assert docks.wait_s(PLACE, 100.0, "A", 0.0) == SOON_S + 15.0 + TURN_S
    assert docks.wait_s(PLACE, 100.0 + SOON_S, "B", 0.0) == 15.0 + TURN_S - SOON_S
    assert docks.wait_s("M8", 100.0, "A", 0.0) == 0.0, "nobody has told of it"

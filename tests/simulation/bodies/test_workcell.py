"""A machine's body: cycles, the dock, breakdowns and what it counts."""

from __future__ import annotations

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from yard import PLANT, Yard

from dray.body import (
    Book,
    Broken,
    CloseDock,
    CycleDone,
    CycleFailed,
    Hold,
    OpenDock,
    Repaired,
    StartCycle,
    StockChanged,
    WorkcellState,
)
from dray_sim.bodies.docks import SHUT
from dray_sim.bodies.stores import NO_ROOM, NOT_KEPT, TOO_LITTLE
from dray_sim.bodies.workcell import NO_POWER, SimWorkcell, WorkcellTimes

FULL = {"shaft": 50, "seal": 40}
GEAR = StartCycle(product="gear")


def cell(yard: Yard, **stock: int) -> SimWorkcell:
    workcell = SimWorkcell(PLANT.machines["M1"], PLANT, yard.clock, stock)
    yard.listen("M1", workcell)
    return workcell


def test_a_new_workcell_senses_every_material_and_product(yard: Yard) -> None:
    assert yard.workcell.sense() == WorkcellState(
        stock={"shaft": 0, "seal": 0, "gear": 0, "pump": 0}, seq=0, cycling="", broken="", paces=True
    )


def test_a_cycle_takes_the_bill_when_it_starts_and_gives_a_piece_when_it_ends(yard: Yard) -> None:
    workcell = cell(yard, shaft=5, seal=1)
    assert yard.do(workcell, GEAR, for_s=29.9) == []
    assert workcell.sense() == WorkcellState(
        stock={"shaft": 3, "seal": 0, "gear": 0, "pump": 0}, seq=0, cycling="gear", broken="", paces=True
    )
    assert yard.do(workcell, for_s=0.2) == [CycleDone(product="gear", seq=1)]
    assert yard.said[-1][0] == 30.0
    assert workcell.sense() == WorkcellState(
        stock={"shaft": 3, "seal": 0, "gear": 1, "pump": 0}, seq=1, cycling="", broken="", paces=True
    )
    assert workcell.consumed == {"shaft": 2, "seal": 1}
    assert workcell.made == {"gear": 1}


@pytest.mark.parametrize(
    ("stock", "product", "reason"),
    [
        ({"shaft": 1}, "gear", "missing shaft, seal"),
        (FULL, "valve", "not made here"),
        ({**FULL, "gear": 7, "pump": 5}, "gear", "no room for the piece"),
    ],
)
def test_a_cycle_that_cannot_start_consumes_nothing(
    yard: Yard, stock: dict[str, int], product: str, reason: str
) -> None:
    workcell = cell(yard, **stock)
    before = workcell.sense()
    assert yard.do(workcell, StartCycle(product=product), for_s=100.0) == [
        CycleFailed(product=product, reason=reason)
    ]
    assert workcell.sense() == before


def test_a_second_cycle_does_not_start_while_one_runs(yard: Yard) -> None:
    workcell = cell(yard, **FULL)
    assert yard.do(workcell, GEAR, GEAR) == [CycleFailed(product="gear", reason="busy with gear")]
    assert workcell.consumed == {"shaft": 2, "seal": 1}


def test_a_breakdown_pauses_the_cycle_and_a_repair_goes_on_with_it(yard: Yard) -> None:
    workcell = cell(yard, **FULL)
    yard.do(workcell, GEAR, for_s=10.0)
    workcell.break_down("tool")
    workcell.break_down("another one")
    assert yard.do(workcell, GEAR, for_s=100.0) == [
        Broken(reason="tool"),
        CycleFailed(product="gear", reason="tool"),
    ]
    assert workcell.sense().broken == workcell.broken == "tool"
    assert workcell.sense().cycling == "gear"
    workcell.repair()
    workcell.repair()
    assert yard.do(workcell, for_s=20.0) == [Repaired(), CycleDone(product="gear", seq=1)]
    assert yard.said[-1][0] == 130.0
    assert workcell.times() == WorkcellTimes(cycling_s=30.0, broken_s=100.0, still_s=0.0)


def test_times_are_right_in_the_middle_of_things(yard: Yard) -> None:
    workcell = cell(yard, **FULL)
    yard.run(5.0)
    yard.do(workcell, GEAR, for_s=10.0)
    assert workcell.times() == WorkcellTimes(cycling_s=10.0, broken_s=0.0, still_s=5.0)


def test_the_dock_is_shut_for_everybody_it_was_not_opened_for(yard: Yard) -> None:
    workcell = cell(yard)
    yard.do(workcell, OpenDock(vehicle="ATV1", item="shaft", quantity=20))
    assert workcell.put("ATV2", "shaft", 20) == SHUT
    assert workcell.put("ATV1", "seal", 20) == SHUT
    assert workcell.put("ATV1", "shaft", 21) == SHUT
    assert workcell.sense().stock["shaft"] == 0


def test_the_dock_lets_one_transfer_through_and_shuts(yard: Yard) -> None:
    workcell = cell(yard)
    yard.do(workcell, OpenDock(vehicle="ATV1", item="shaft", quantity=20))
    assert workcell.put("ATV1", "shaft", 20) == ""
    assert workcell.put("ATV1", "shaft", 20) == SHUT
    assert yard.do(workcell) == [StockChanged(item="shaft", change=20, seq=1, vehicle="ATV1")]
    assert workcell.sense().stock["shaft"] == 20


def test_a_closed_dock_is_shut_and_closing_it_twice_is_harmless(yard: Yard) -> None:
    workcell = cell(yard)
    shut = CloseDock(vehicle="ATV1")
    yard.do(workcell, OpenDock(vehicle="ATV1", item="shaft", quantity=20), shut, shut)
    assert workcell.put("ATV1", "shaft", 20) == SHUT


def test_a_dock_that_was_opened_for_a_wrong_item_lets_nothing_through(yard: Yard) -> None:
    workcell = cell(yard)
    yard.do(workcell, OpenDock(vehicle="ATV1", item="valve", quantity=1))
    assert workcell.put("ATV1", "valve", 1) == NOT_KEPT
    assert workcell.take("ATV1", "valve", 1) == NOT_KEPT
    assert workcell.room("valve") == 0


def test_an_overflow_is_refused_and_the_dock_stays_open(yard: Yard) -> None:
    workcell = cell(yard, shaft=31, seal=40)
    yard.do(workcell, OpenDock(vehicle="ATV1", item="shaft", quantity=20))
    assert workcell.put("ATV1", "shaft", 20) == NO_ROOM
    yard.do(workcell, GEAR)
    assert workcell.put("ATV1", "shaft", 20) == ""


def test_goods_are_fetched_through_the_dock_and_never_more_than_there_are(yard: Yard) -> None:
    workcell = cell(yard, gear=4)
    yard.do(workcell, OpenDock(vehicle="ATV1", item="gear", quantity=5))
    assert workcell.take("ATV1", "gear", 5) == TOO_LITTLE
    yard.do(workcell, OpenDock(vehicle="ATV1", item="gear", quantity=4))
    assert workcell.take("ATV1", "gear", 4) == ""
    assert yard.do(workcell) == [StockChanged(item="gear", change=-4, seq=1, vehicle="ATV1")]


def test_goods_may_come_back_but_never_take_the_place_of_a_piece_in_the_making(yard: Yard) -> None:
    workcell = cell(yard, **FULL, gear=6)
    yard.do(workcell, StartCycle(product="pump"), OpenDock(vehicle="ATV1", item="gear", quantity=6))
    assert workcell.put("ATV1", "gear", 6) == NO_ROOM
    yard.do(workcell, OpenDock(vehicle="ATV1", item="gear", quantity=5))
    assert workcell.put("ATV1", "gear", 5) == ""
    assert yard.do(workcell, for_s=60.0)[-1] == CycleDone(product="pump", seq=2)


def test_what_only_a_vehicle_can_do_is_ignored(yard: Yard) -> None:
    assert yard.do(yard.workcell, Hold()) == []


DEEDS = st.one_of(
    st.tuples(st.just("start"), st.sampled_from(["gear", "pump"])),
    st.tuples(st.just("bring"), st.sampled_from(["shaft", "seal"])),
    st.tuples(st.just("fetch"), st.sampled_from(["gear", "pump"])),
    st.tuples(st.sampled_from(["break", "repair"]), st.just("")),
)


@settings(deadline=None)
@given(st.lists(st.tuples(DEEDS, st.floats(0.0, 50.0)), max_size=60))
def test_whatever_happens_material_is_conserved(deeds: list[tuple[tuple[str, str], float]]) -> None:
    yard = Yard()
    workcell = cell(yard)
    brought = dict.fromkeys(("shaft", "seal"), 0)
    fetched = dict.fromkeys(("gear", "pump"), 0)
    for (deed, item), seconds in deeds:
        if deed == "start":
            workcell.instruct(StartCycle(product=item))
        elif deed == "bring":
            workcell.instruct(OpenDock(vehicle="ATV1", item=item, quantity=10))
            brought[item] += 0 if workcell.put("ATV1", item, 10) else 10
        elif deed == "fetch":
            workcell.instruct(OpenDock(vehicle="ATV1", item=item, quantity=1))
            fetched[item] += 0 if workcell.take("ATV1", item, 1) else 1
        elif deed == "break":
            workcell.break_down("tool")
        else:
            workcell.repair()
        yard.run(yard.clock.now_s() + seconds)
        stock = workcell.sense().stock
        assert all(brought[each] == stock[each] + workcell.consumed[each] for each in brought)
        assert all(workcell.made[each] == stock[each] + fetched[each] for each in fetched)
        assert 0 <= stock["shaft"] <= 50
        assert 0 <= stock["seal"] <= 40
        assert 0 <= stock["gear"] + stock["pump"] <= 12
    times = workcell.times()
    assert times.cycling_s + times.broken_s + times.still_s == pytest.approx(yard.clock.now_s())


# --- power ---


def test_a_cycle_pauses_without_power_and_nothing_is_said(yard: Yard) -> None:
    workcell = cell(yard, **FULL)
    yard.do(workcell, GEAR, for_s=10.0)
    workcell.power_off()
    assert yard.do(workcell, for_s=100.0) == []
    assert (workcell.sense().cycling, workcell.off) == ("gear", True)
    workcell.power_on()
    assert yard.do(workcell, for_s=19.9) == []
    assert yard.do(workcell, for_s=0.2) == [CycleDone(product="gear", seq=1)]
    assert workcell.times() == WorkcellTimes(
        cycling_s=pytest.approx(30.0), broken_s=pytest.approx(100.0), still_s=pytest.approx(0.1)
    )


def test_a_workcell_without_power_hears_nothing(yard: Yard) -> None:
    workcell = cell(yard, **FULL)
    workcell.power_off()
    dock = OpenDock(vehicle="ATV1", item="gear", quantity=5)
    assert yard.do(workcell, GEAR, dock, for_s=100.0) == []
    workcell.power_on()
    assert workcell.sense().cycling == ""
    assert workcell.take("ATV1", "gear", 5) == SHUT


def test_the_dock_is_shut_without_power_and_after(yard: Yard) -> None:
    workcell = cell(yard)
    yard.do(workcell, OpenDock(vehicle="ATV1", item="shaft", quantity=20))
    workcell.power_off()
    assert workcell.put("ATV1", "shaft", 20) == NO_POWER
    workcell.power_on()
    assert workcell.put("ATV1", "shaft", 20) == SHUT


def test_a_machine_that_breaks_without_power_stays_broken_with_it(yard: Yard) -> None:
    workcell = cell(yard, **FULL)
    yard.do(workcell, GEAR, for_s=10.0)
    workcell.power_off()
    workcell.break_down("spindle")
    workcell.power_on()
    assert yard.do(workcell, for_s=100.0) == []
    assert workcell.sense().broken == "spindle"
    workcell.repair()
    assert yard.do(workcell, for_s=20.0) == [Repaired(), CycleDone(product="gear", seq=1)]


def test_a_machine_that_is_repaired_without_power_does_not_work(yard: Yard) -> None:
    workcell = cell(yard, **FULL)
    yard.do(workcell, GEAR, for_s=10.0)
    workcell.break_down("spindle")
    workcell.power_off()
    workcell.repair()
    yard.run(1000.0)
    assert workcell.made == {}


def test_power_that_is_switched_twice_is_switched_once(yard: Yard) -> None:
    workcell = cell(yard, **FULL)
    yard.do(workcell, GEAR, for_s=10.0)
    workcell.power_on()
    workcell.power_off()
    yard.run(20.0)
    workcell.power_off()
    workcell.power_on()
    assert yard.do(workcell, for_s=20.0) == [CycleDone(product="gear", seq=1)]


# --- by hand ---


def test_what_a_person_puts_in_is_told(yard: Yard) -> None:
    workcell = cell(yard)
    assert workcell.put_by_hand("gear", 5) == ""
    assert yard.do(workcell) == [StockChanged(item="gear", change=5, seq=1)]
    assert workcell.sense().stock["gear"] == 5


def test_a_person_puts_nothing_in_that_does_not_fit_or_belong(yard: Yard) -> None:
    workcell = cell(yard, gear=10)
    assert workcell.put_by_hand("gear", 3) == NO_ROOM
    assert workcell.put_by_hand("shaft", 51) == NO_ROOM
    assert workcell.put_by_hand("block", 1) == NOT_KEPT
    assert yard.do(workcell) == []


def test_what_is_put_in_without_power_is_sensed_later(yard: Yard) -> None:
    workcell = cell(yard)
    workcell.power_off()
    assert workcell.put_by_hand("shaft", 5) == ""
    workcell.power_on()
    assert yard.do(workcell) == []
    assert workcell.sense().stock["shaft"] == 5


# --- counting ------------------------------------------------------------------------------------


def blind(yard: Yard, **stock: int) -> SimWorkcell:
    """One that does not count what vehicles bring and take."""
    spec = msgspec.structs.replace(PLANT.machines["M1"], counts=False)
    workcell = SimWorkcell(spec, PLANT, yard.clock, stock)
    yard.listen("M1", workcell)
    return workcell


def test_the_dock_counts_what_comes_and_not_what_it_was_opened_for(yard: Yard) -> None:
    workcell = cell(yard)
    yard.do(workcell, OpenDock(vehicle="ATV1", item="shaft", quantity=20))
    assert workcell.put("ATV1", "shaft", 17) == ""
    assert yard.do(workcell) == [StockChanged(item="shaft", change=17, seq=1, vehicle="ATV1")]


def test_a_dock_that_does_not_count_tells_what_it_is_told(yard: Yard) -> None:
    workcell = blind(yard)
    yard.do(workcell, OpenDock(vehicle="ATV1", item="shaft", quantity=20))
    assert workcell.put("ATV1", "shaft", 20) == ""
    assert yard.do(workcell) == []
    assert not workcell.sense().counts
    assert workcell.sense().stock["shaft"] == 0
    said = yard.do(workcell, Book("ATV1", "shaft", 20, task="M1-1", epoch=1))
    assert said == [StockChanged(item="shaft", change=20, seq=1, vehicle="ATV1")]
    assert workcell.sense().stock["shaft"] == 20


def test_whoever_reaches_for_a_piece_that_was_only_booked_sees_that_it_is_not_there(yard: Yard) -> None:
    workcell = blind(yard, seal=40)
    yard.do(workcell, Book("ATV1", "shaft", 20, task="M1-1", epoch=1))
    assert workcell.sense().stock["shaft"] == 20
    assert [type(each) for each in yard.do(workcell, GEAR)] == [CycleFailed]
    assert workcell.sense().stock["shaft"] == 0

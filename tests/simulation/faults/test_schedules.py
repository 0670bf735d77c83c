"""Schedules of faults, played."""

from __future__ import annotations

import pytest
from fault_world import FakeWorld

from dray_sim.faults import Crashed, FaultError, Faults, LoadShifted, PoweredOff, Timed, WlanCut, play


def test_a_schedule_happens_at_its_times(world: FakeWorld, faults: Faults) -> None:
    play(
        [Timed(20.0, PoweredOff("M1"), 30.0), Timed(10.0, WlanCut("ATV1")), Timed(20.0, Crashed("M2"), 25.0)],
        faults,
    )
    seen = []
    for until_s in (9.0, 10.0, 20.0, 24.9, 25.0, 30.0, 1000.0):
        world.pass_time(until_s)
        seen.append(list(faults.active.values()))
    cut, off, crash = WlanCut("ATV1"), PoweredOff("M1"), Crashed("M2")
    assert seen == [[], [cut], [cut, off, crash], [cut, off, crash], [cut, off], [cut], [cut]]


def test_what_has_no_load_to_shift_is_skipped_and_the_rest_happens(world: FakeWorld, faults: Faults) -> None:
    world.vehicles["ATV1"].loaded = False
    play([Timed(1.0, LoadShifted("ATV1"), 5.0), Timed(1.0, WlanCut("ATV1"), 5.0)], faults)
    world.pass_time(10.0)
    assert faults.skipped == 1
    assert world.done == ["begin wlan_cut", "end wlan_cut"]


def test_what_was_ended_by_hand_is_not_ended_again(world: FakeWorld, faults: Faults) -> None:
    play([Timed(1.0, WlanCut("ATV1"), 5.0)], faults)
    world.pass_time(2.0)
    faults.end_all()
    world.pass_time(10.0)
    assert world.done == ["begin wlan_cut", "end wlan_cut"]


def test_nothing_of_a_schedule_with_a_mistake_happens(world: FakeWorld, faults: Faults) -> None:
    with pytest.raises(FaultError, match=r"schedule\[1\]\.fault\.agent: there is no agent 'X'"):
        play([Timed(1.0, WlanCut("ATV1")), Timed(2.0, WlanCut("X"))], faults)
    world.pass_time(10.0)
    assert not world.done

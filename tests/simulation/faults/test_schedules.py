"""Schedules of faults: played, in JSON, and drawn from a seed."""

from __future__ import annotations

import os
import subprocess
import sys
from collections import Counter
from random import Random

import pytest
from fault_world import ONE_OF_EACH, PLANT, FakeWorld

from dray_sim.faults import (
    CLOCKS,
    DOORS,
    DROPPED,
    LEAVING,
    OBSTACLES,
    WEIGHTS,
    Cast,
    Crashed,
    FaultError,
    Faults,
    JournalLost,
    LinkTrouble,
    LoadShifted,
    PoweredOff,
    SentAway,
    Timed,
    WlanCut,
    describe,
    kind_of,
    play,
    random_schedule,
    random_waves,
    read_fault,
    read_schedule,
    write_schedule,
)
from dray_sim.faults.chance import COORDINATOR_BACK_S, VEHICLE_BACK_S
from dray_sim.faults.kinds import KIND_NAMES, KINDS
from dray_sim.plants.generator import generate_plant

CAST = Cast.of_plant(PLANT)


# --- schedules --------------------------------------------------------------------------------------


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


# --- as JSON ----------------------------------------------------------------------------------------


def test_there_is_an_example_of_each_kind() -> None:
    assert tuple(type(fault) for fault in ONE_OF_EACH) == KINDS
    assert tuple(kind_of(fault) for fault in ONE_OF_EACH) == KIND_NAMES


def test_a_schedule_comes_back_from_json_as_it_was() -> None:
    schedule = tuple(
        Timed(float(number), fault, number + 1.5 if number % 2 else None)
        for number, fault in enumerate(ONE_OF_EACH)
    )
    assert read_schedule(write_schedule(schedule), CAST) == schedule
    assert read_schedule(write_schedule(()), CAST) == ()


def test_a_single_fault_is_read_by_its_kind_and_defaults_may_be_left_out() -> None:
    assert read_fault('{"kind": "wlan_cut", "agent": "ATV3"}', CAST) == WlanCut("ATV3")
    assert read_fault(b'{"kind": "link_trouble", "loss_frac": 0.2}', CAST) == LinkTrouble(loss_frac=0.2)


TIMED = '[{"at_s": 1, "fault": {"kind": "wlan_cut", "agent": "ATV1"}}, {"at_s": 2, "fault": %s}]'


@pytest.mark.parametrize(
    ("data", "field", "said"),
    [
        ('[{"at_s": 1', "schedule", "truncated"),
        ("{}", "schedule", "Expected `array`"),
        (b"\xff\xff", "schedule", ""),
        ("[" * 100_000, "schedule[0]", "got `array`"),
        ("[]" + " " * 2_000_000, "schedule", "split it"),
        (
            '[{"fault": {"kind": "wlan_cut", "agent": "ATV1"}}]',
            "schedule[0]",
            "missing required field `at_s`",
        ),
        (TIMED % '{"agent": "ATV1"}', "schedule[1].fault", "missing required field `kind`"),
        (TIMED % '{"kind": "flood"}', "schedule[1].fault.kind", "the kinds are wlan_cut, radio_cut"),
        (TIMED % '{"kind": "wlan_cut"}', "schedule[1].fault", "missing required field `agent`"),
        (
            TIMED % '{"kind": "wlan_cut", "agent": "ATV99"}',
            "schedule[1].fault.agent",
            "there is no agent 'ATV99'",
        ),
        (TIMED % '{"kind": "wlan_cut", "agent": "*"}', "schedule[1].fault.agent", "regex"),
        (TIMED % '{"kind": "wlan_cut", "agent": "ATV1", "to": 1}', "schedule[1].fault", "unknown field `to`"),
        (TIMED % '{"kind": "link_trouble", "loss_frac": 1.1}', "schedule[1].fault.loss_frac", "<= 1.0"),
        (TIMED % '{"kind": "link_trouble", "latency_s": -1}', "schedule[1].fault.latency_s", ">= 0.0"),
        (TIMED % '{"kind": "link_trouble", "jitter_s": "1"}', "schedule[1].fault.jitter_s", "got `str`"),
        (TIMED % '{"kind": "link_trouble", "sender": ""}', "schedule[1].fault.sender", "length >= 1"),
        (TIMED % '{"kind": "partition", "groups": []}', "schedule[1].fault.groups", "length >= 1"),
        (TIMED % '{"kind": "partition", "groups": [[]]}', "schedule[1].fault.groups[0]", "length >= 1"),
        (
            TIMED % '{"kind": "coverage_hole", "x_m": 1, "y_m": 1, "radius_m": 0}',
            "schedule[1].fault.radius_m",
            "> 0.0",
        ),
        (
            '[{"at_s": 5, "until_s": 5, "fault": {"kind": "wlan_cut", "agent": "ATV1"}}]',
            "schedule[0].until_s",
            "let it end later",
        ),
        ('[{"at_s": -1, "fault": {"kind": "wlan_cut", "agent": "ATV1"}}]', "schedule[0].at_s", ">= 0.0"),
        ('[{"at_s": 1e300, "fault": {"kind": "wlan_cut", "agent": "ATV1"}}]', "schedule[0].at_s", "<="),
    ],
)
def test_what_is_no_schedule_is_told_with_its_place(data: str | bytes, field: str, said: str) -> None:
    with pytest.raises(FaultError) as caught:
        read_schedule(data, CAST)
    assert caught.value.field == field
    assert said in caught.value.reason


def test_a_fault_is_told_in_one_line_without_its_defaults() -> None:
    assert describe(LinkTrouble(sender="M1", loss_frac=0.2)) == "link trouble (sender='M1', loss_frac=0.2)"
    assert describe(PoweredOff("ATV3")) == "powered off (agent='ATV3')"
    assert describe(LinkTrouble()) == "link trouble ()"
    assert str(Timed(1.0, WlanCut("ATV1"), 2.5)) == "     1.0 s  wlan cut (agent='ATV1') until 2.5 s"


# --- drawn from a seed ------------------------------------------------------------------------------


def test_a_random_schedule_is_in_order_about_the_plant_and_over_in_time() -> None:
    for seed in range(50):
        plant = generate_plant(seed, 1 + seed % 5, 1 + seed % 7)
        schedule = random_schedule(plant, Random(seed), 600.0, 3.0, from_s=60.0)
        assert read_schedule(write_schedule(schedule), Cast.of_plant(plant)) == schedule
        assert [timed.at_s for timed in schedule] == sorted(timed.at_s for timed in schedule)
        for timed in schedule:
            assert timed.until_s is not None
            assert 60.0 <= timed.at_s < timed.until_s <= 600.0


def test_waves_are_crashes_of_sets_in_any_order_that_end_before_anybody_is_missed() -> None:
    firsts: set[str] = set()
    at_once: set[str] = set()
    for seed in range(50):
        waves = random_waves(PLANT, Random(seed), 600.0, 1.0)
        assert read_schedule(write_schedule(waves), CAST) == waves
        assert [timed.at_s for timed in waves] == sorted(timed.at_s for timed in waves)
        for timed in waves:
            assert isinstance(timed.fault, Crashed)
            back_s = VEHICLE_BACK_S if timed.fault.agent in PLANT.fleet else COORDINATOR_BACK_S
            assert 0.0 < (timed.until_s or 0.0) - timed.at_s <= back_s + 0.01
            assert (timed.until_s or 0.0) <= 600.0
            if timed.at_s == waves[0].at_s:
                at_once.add(timed.fault.agent)
        firsts |= {timed.fault.agent for timed in waves[:1] if isinstance(timed.fault, Crashed)}
    assert len(firsts) > 10
    assert at_once >= firsts
    assert random_waves(PLANT, Random(3), 600.0, 1.0) == random_waves(PLANT, Random(3), 600.0, 1.0)


def test_random_schedules_have_all_kinds_as_often_as_they_weigh_and_overlap() -> None:
    schedule = [timed for seed in range(40) for timed in random_schedule(PLANT, Random(seed), 3600.0, 2.0)]
    counts = Counter(type(timed.fault) for timed in schedule)
    assert (
        set(counts)
        == {*KINDS} - {*LEAVING, *CLOCKS, *OBSTACLES, *DROPPED, *DOORS, JournalLost}
        == set(WEIGHTS)
    )
    total = sum(WEIGHTS.values())
    for kind, weight in WEIGHTS.items():
        assert counts[kind] / len(schedule) == pytest.approx(weight / total, abs=0.015)
    assert len(schedule) / 40 == pytest.approx(2.0 * 60.0, rel=0.05)
    ends = [(timed.until_s or 0.0) - timed.at_s for timed in schedule]
    assert sum(ends) / len(ends) > 30.0


def test_agents_that_leave_are_drawn_apart_some_for_probation() -> None:
    schedule = random_schedule(PLANT, Random(1), 3600.0, 2.0, weights=LEAVING)
    leaving = [timed.fault for timed in schedule]
    assert {type(fault) for fault in leaving} == {SentAway}
    assert len({fault.agent for fault in leaving if isinstance(fault, SentAway)}) > 10
    assert {fault.probation for fault in leaving if isinstance(fault, SentAway)} == {0, 1, 2, 3}


def test_intensity_and_weights_are_obeyed() -> None:
    assert random_schedule(PLANT, Random(1), 3600.0, 0.0) == ()
    assert random_schedule(PLANT, Random(1), 3600.0, weights={}) == ()
    only = random_schedule(PLANT, Random(1), 3600.0, weights={WlanCut: 1.0})
    assert {type(timed.fault) for timed in only} == {WlanCut}
    assert random_schedule(PLANT, Random(1), 1.0, 100.0) == ()
    assert len(random_schedule(PLANT, Random(1), 1e6, 1000.0)) == 500


def test_a_random_schedule_depends_on_its_seed_alone() -> None:
    script = (
        "from random import Random; from dray.plant import default_plant;"
        "from dray_sim.faults import random_schedule, write_schedule;"
        "print(write_schedule(random_schedule(default_plant(), Random(5), 1200.0, 3.0)).decode(), end='')"
    )
    told = {
        subprocess.run(
            [sys.executable, "-c", script],
            env={**os.environ, "PYTHONHASHSEED": hash_seed, "PYTHONPATH": os.pathsep.join(sys.path)},
            check=True,
            capture_output=True,
            text=True,
        ).stdout
        for hash_seed in ("1", "2")
    }
    here = random_schedule(PLANT, Random(5), 1200.0, 3.0)
    assert told == {write_schedule(here).decode()}
    assert here != random_schedule(PLANT, Random(6), 1200.0, 3.0)

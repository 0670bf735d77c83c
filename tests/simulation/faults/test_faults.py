"""Faults as data: what each kind does to a world, schedules in JSON, and schedules drawn from a seed."""

from __future__ import annotations

import asyncio
import os
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from itertools import filterfalse
from random import Random

import pytest

from dray.plant import default_plant
from dray_sim.clock.loop import VirtualClock, clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.faults import (
    CLOCKS,
    LEAVING,
    WEIGHTS,
    AccessPointDown,
    Cast,
    ClockSet,
    CoverageHole,
    Crashed,
    Fault,
    FaultError,
    Faults,
    JournalLost,
    LinkTrouble,
    LoadShifted,
    MachineBroken,
    NetworkFault,
    Partition,
    PoweredOff,
    RadioCut,
    SentAway,
    Timed,
    VehicleBroken,
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
from dray_sim.faults import active as active_module
from dray_sim.faults.chance import COORDINATOR_BACK_S, VEHICLE_BACK_S
from dray_sim.faults.kinds import KIND_NAMES, KINDS
from dray_sim.plants.generator import generate_plant

PLANT = default_plant()
CAST = Cast.of_plant(PLANT)

ONE_OF_EACH: tuple[Fault, ...] = (
    WlanCut("ATV1"),
    RadioCut("ATV2"),
    LinkTrouble(sender="ATV*", receiver="M1", latency_s=0.5, jitter_s=0.1, loss_frac=0.2),
    Partition((("M1", "ATV*"), ("M2",))),
    CoverageHole(x_m=1.5, y_m=2.0, radius_m=3.0),
    AccessPointDown("AP1"),
    PoweredOff("ATV3"),
    Crashed("strategist"),
    JournalLost("M6"),
    ClockSet("ATV6", by_s=-5.0),
    SentAway("M5", probation=2),
    MachineBroken("M4", "no oil"),
    VehicleBroken("ATV4"),
    LoadShifted("ATV5"),
)


class Body:
    def __init__(self, world: FakeWorld, name: str) -> None:
        self._world, self._name = world, name
        self.loaded = True

    def break_down(self, reason: str) -> None:
        self._world.done.append(f"break {self._name}: {reason}")

    def repair(self) -> None:
        self._world.done.append(f"repair {self._name}")

    def shift_load(self) -> bool:
        if self.loaded:
            self._world.done.append(f"shift {self._name}")
        return self.loaded


class FakeWorld:
    """Notes what is done to it."""

    access_points = ("AP1",)

    def __init__(self) -> None:
        self.done: list[str] = []
        self.clock = VirtualClock()
        self.bus = self
        self.vehicles = {name: Body(self, name) for name in ("ATV1", "ATV2")}
        self.workcells = {name: Body(self, name) for name in ("M1", "M2")}
        self.workers = dict.fromkeys((*self.workcells, *self.vehicles, "strategist"))
        self.dead: set[str] = set()
        self.off: set[str] = set()

    def begin(self, fault: NetworkFault) -> None:
        self.done.append(f"begin {kind_of(fault)}")

    def end(self, fault: NetworkFault) -> None:
        self.done.append(f"end {kind_of(fault)}")

    def running(self, agent: str) -> bool:
        return agent not in self.dead

    def power_off(self, agent: str) -> None:
        self.dead.add(agent)
        self.off.add(agent)
        self.done.append(f"off {agent}")

    def power_on(self, agent: str) -> None:
        if agent in self.off:
            self.off.discard(agent)
            self.dead.discard(agent)
            self.done.append(f"on {agent}")

    def crash(self, agent: str) -> None:
        self.dead.add(agent)
        self.done.append(f"crash {agent}")

    def lose_journal(self, agent: str) -> None:
        self.dead.add(agent)
        self.done.append(f"lose {agent}'s journal")

    def set_clock(self, agent: str, by_s: float) -> None:
        self.done.append(f"set {agent}'s clock by {by_s:g} s")

    def ask_to_leave(self, agent: str) -> None:
        self.dead.add(agent)
        self.done.append(f"send {agent} away")

    def restart(self, agent: str, *, probation: int = 0) -> None:
        if agent not in self.off:
            self.dead.discard(agent)
            self.done.append(f"restart {agent}" + (f" on probation for {probation}" if probation else ""))

    def pass_time(self, until_s: float) -> None:
        while self.clock.heap and self.clock.heap[0][0] <= until_s:
            when_s, _, call, args = self.clock.heap.pop(0)
            self.clock.heap.sort(key=lambda entry: entry[:2])
            self.clock.time_s = when_s
            call(*args)
        self.clock.time_s = until_s


@pytest.fixture
def world() -> FakeWorld:
    return FakeWorld()


@pytest.fixture
def faults(world: FakeWorld) -> Faults:
    return Faults(world)


# --- begun and ended -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("fault", "begun", "ended"),
    [
        (WlanCut("ATV1"), "begin wlan_cut", "end wlan_cut"),
        (RadioCut("ATV1"), "begin radio_cut", "end radio_cut"),
        (LinkTrouble(loss_frac=0.1), "begin link_trouble", "end link_trouble"),
        (Partition((("M1",),)), "begin partition", "end partition"),
        (CoverageHole(1.0, 1.0, 1.0), "begin coverage_hole", "end coverage_hole"),
        (AccessPointDown("AP1"), "begin access_point_down", "end access_point_down"),
        (PoweredOff("M1"), "off M1", "on M1"),
        (Crashed("strategist"), "crash strategist", "restart strategist"),
        (JournalLost("M1"), "lose M1's journal", "restart M1"),
        (ClockSet("ATV1", 30.0), "set ATV1's clock by 30 s", "set ATV1's clock by -30 s"),
        (SentAway("ATV1"), "send ATV1 away", "restart ATV1"),
        (SentAway("M1", probation=3), "send M1 away", "restart M1 on probation for 3"),
        (MachineBroken("M2", "no oil"), "break M2: no oil", "repair M2"),
        (VehicleBroken("ATV2", "blocked"), "break ATV2: blocked", "repair ATV2"),
        (LoadShifted("ATV1"), "shift ATV1", "repair ATV1"),
    ],
    ids=lambda value: kind_of(value) if isinstance(value, KINDS) else None,
)
def test_each_kind_does_what_it_says_and_puts_it_right(
    world: FakeWorld, faults: Faults, fault: Fault, begun: str, ended: str
) -> None:
    name = faults.begin(fault)
    assert dict(faults.active) == {name: fault}
    assert world.done == [begun]
    faults.end(name)
    assert not faults.active
    assert world.done == [begun, ended]


def test_every_fault_has_an_id_of_its_own(faults: Faults) -> None:
    names = [faults.begin(WlanCut("ATV1")) for _ in range(3)]
    faults.end(names[1])
    assert len({*names, faults.begin(WlanCut("ATV1"))}) == 4


def test_what_several_faults_have_taken_comes_back_with_the_last(world: FakeWorld, faults: Faults) -> None:
    off, crashed, off_again = (
        faults.begin(fault) for fault in (PoweredOff("ATV1"), Crashed("ATV1"), PoweredOff("ATV1"))
    )
    world.done.clear()
    faults.end(off)
    assert world.done == []
    faults.end(crashed)
    assert world.done == []
    faults.end(off_again)
    assert world.done == ["on ATV1"]


def test_power_that_is_back_does_not_mend_a_crash(world: FakeWorld, faults: Faults) -> None:
    crashed, off = faults.begin(Crashed("M1")), faults.begin(PoweredOff("M1"))
    faults.end(off)
    assert not world.running("M1")
    faults.end(crashed)
    assert world.running("M1")


def test_who_was_switched_on_by_hand_and_crashes_is_started_again(world: FakeWorld, faults: Faults) -> None:
    faults.begin(PoweredOff("ATV1"))
    world.power_on("ATV1")
    crashed = faults.begin(Crashed("ATV1"))
    faults.end(crashed)
    assert world.running("ATV1")


def test_who_was_sent_away_stays_away_whatever_else_ends(world: FakeWorld, faults: Faults) -> None:
    away, crashed, off = (
        faults.begin(fault) for fault in (SentAway("ATV1"), Crashed("ATV1"), PoweredOff("ATV1"))
    )
    faults.end(crashed)
    faults.end(off)
    assert not world.running("ATV1")
    faults.end(away)
    assert world.running("ATV1")


def test_who_has_not_left_in_time_is_started_anew(world: FakeWorld, faults: Faults) -> None:
    away = faults.begin(SentAway("ATV1"))
    world.dead.discard("ATV1")
    faults.end(away)
    assert world.done[-1] == "restart ATV1"


def test_a_vehicle_is_repaired_when_its_last_problem_ends(world: FakeWorld, faults: Faults) -> None:
    broken, shifted = faults.begin(VehicleBroken("ATV1")), faults.begin(LoadShifted("ATV1"))
    other = faults.begin(VehicleBroken("ATV2"))
    world.done.clear()
    faults.end(broken)
    assert world.done == []
    faults.end(other)
    faults.end(shifted)
    assert world.done == ["repair ATV2", "repair ATV1"]


def test_an_agent_that_somebody_has_started_again_is_left_alone(world: FakeWorld, faults: Faults) -> None:
    name = faults.begin(Crashed("strategist"))
    world.restart("strategist")
    world.done.clear()
    faults.end(name)
    assert world.done == []


def test_all_can_be_ended_at_once(world: FakeWorld, faults: Faults) -> None:
    for fault in (PoweredOff("M1"), Crashed("M1"), WlanCut("ATV1"), VehicleBroken("ATV2")):
        faults.begin(fault)
    faults.end_all()
    assert not faults.active
    assert not world.dead


def test_a_load_that_is_not_there_cannot_shift(world: FakeWorld, faults: Faults) -> None:
    world.vehicles["ATV1"].loaded = False
    with pytest.raises(FaultError, match="ATV1 has no load that could shift"):
        faults.begin(LoadShifted("ATV1"))
    assert not faults.active


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        (
            WlanCut("ATV9"),
            "fault.agent: there is no agent 'ATV9'; give one of M1, M2, ATV1, ATV2, strategist",
        ),
        (RadioCut("M1"), "fault.agent: there is no vehicle 'M1'; give one of ATV1, ATV2"),
        (PoweredOff("strategist"), "fault.agent: there is no machine or vehicle 'strategist'"),
        (Crashed("gateway"), "fault.agent: there is no agent of the factory 'gateway'"),
        (MachineBroken("ATV1"), "fault.machine: there is no machine 'ATV1'; give one of M1, M2"),
        (VehicleBroken("M1"), "fault.atv: there is no vehicle 'M1'"),
        (LoadShifted("ATV3"), "fault.atv: there is no vehicle 'ATV3'"),
        (AccessPointDown("AP2"), "fault.access_point: there is no access point 'AP2'; give one of AP1"),
    ],
)
def test_a_fault_in_somebody_who_is_not_there_is_told(
    world: FakeWorld, faults: Faults, fault: Fault, said: str
) -> None:
    with pytest.raises(FaultError) as caught:
        faults.begin(fault)
    assert str(caught.value).startswith(said)
    assert not faults.active
    assert not world.done


def test_a_listeners_cable_can_be_pulled(faults: Faults) -> None:
    assert faults.begin(WlanCut("historian"))
    assert faults.begin(WlanCut("gateway"))


def test_ending_what_is_not_active_is_told(faults: Faults) -> None:
    with pytest.raises(FaultError, match="no fault 'F7' is active; active are none"):
        faults.end("F7")
    name = faults.begin(WlanCut("ATV1"))
    with pytest.raises(FaultError, match=f"active are {name}"):
        faults.end("F7")


def test_no_more_faults_are_active_than_the_bound(faults: Faults, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(active_module, "MAX_ACTIVE", 2)
    for _ in range(2):
        faults.begin(WlanCut("ATV1"))
    with pytest.raises(FaultError, match="end some first"):
        faults.begin(WlanCut("ATV1"))


# --- schedules -------------------------------------------------------------------------------------


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


# --- as JSON ---------------------------------------------------------------------------------------


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


# --- drawn from a seed -----------------------------------------------------------------------------


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
    assert set(counts) == {*KINDS} - {*LEAVING, *CLOCKS, JournalLost} == set(WEIGHTS)
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


# --- in a factory ----------------------------------------------------------------------------------


def in_factory(story: Callable[[SimFactory, Faults], object], minutes: float) -> SimFactory:
    """Run an idle factory for a while; `story` is told at its beginning."""

    async def main() -> SimFactory:
        factory = SimFactory(PLANT, clock(), seed=1)
        running = asyncio.create_task(factory.run())
        await asyncio.sleep(1.0)
        story(factory, Faults(factory))
        await asyncio.sleep(60.0 * minutes)
        running.cancel()
        await asyncio.wait([running])
        assert running.cancelled()
        return factory

    return run(main())


def test_each_kind_can_begin_and_end_in_a_real_factory() -> None:
    def story(factory: SimFactory, faults: Faults) -> None:
        schedule = [
            Timed(10.0 * number, fault, 10.0 * number + 30.0) for number, fault in enumerate(ONE_OF_EACH, 1)
        ]
        play(schedule, faults)
        for number in range(1, len(schedule) + 1):
            factory.clock.call_at(10.0 * number + 5.0, lambda: seen.update(map(type, faults.active.values())))
        factory.clock.call_at(175.0, lambda: left.update(faults.active))
        factory.clock.call_at(175.0, lambda: away.update(filterfalse(factory.running, factory.workers)))

    seen: set[type[Fault]] = set()
    left: dict[str, Fault] = {}
    away: set[str] = set()
    factory = in_factory(story, 3.0)
    # Nothing is carried in an idle factory, so no load can shift.
    assert seen == {*KINDS} - {LoadShifted}
    assert not left
    assert not away
    assert factory.bus.relayed > 0

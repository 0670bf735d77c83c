"""Faults as data: what each kind does to a world, and how it ends."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from itertools import filterfalse

import pytest
from fault_world import LANE, ONE_OF_EACH, PLANT, FakeWorld

from dray_sim.clock.loop import clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.faults import (
    AccessPointDown,
    Cast,
    ClockSet,
    CoverageHole,
    Crashed,
    DoorFailed,
    Fault,
    FaultError,
    Faults,
    JournalLost,
    LaneBlocked,
    LinkTrouble,
    LoadDropped,
    LoadShifted,
    MachineBroken,
    Partition,
    PoweredOff,
    RadioCut,
    SentAway,
    Thing,
    Timed,
    VehicleBroken,
    WlanCut,
    kind_of,
    play,
)
from dray_sim.faults import active as active_module
from dray_sim.faults.active import PERSON_STAYS_S
from dray_sim.faults.kinds import KINDS

# --- begun and ended --------------------------------------------------------------------------------


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
        (LaneBlocked(*LANE), f"pallet from {LANE[0]} to {LANE[1]}", f"clear from {LANE[0]} to {LANE[1]}"),
        (DoorFailed("GATE"), "fail GATE", "repair GATE"),
        (LoadDropped("ATV1"), "drop the load of ATV1", "repair ATV1"),
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


def test_a_person_on_a_lane_goes_on_and_a_pallet_stays(world: FakeWorld, faults: Faults) -> None:
    faults.begin(LaneBlocked(*LANE, Thing.PERSON))
    world.pass_time(PERSON_STAYS_S - 1.0)
    assert faults.active
    world.pass_time(PERSON_STAYS_S)
    assert not faults.active
    assert world.done[-1] == f"clear from {LANE[0]} to {LANE[1]}"
    faults.begin(LaneBlocked(*LANE, Thing.PALLET))
    world.pass_time(PERSON_STAYS_S * 10.0)
    assert faults.active


def test_a_person_who_was_sent_away_ends_no_fault_that_came_later(world: FakeWorld, faults: Faults) -> None:
    faults.end(faults.begin(LaneBlocked(*LANE, Thing.PERSON)))
    later = faults.begin(LaneBlocked(*LANE, Thing.DOOR))
    world.pass_time(PERSON_STAYS_S * 2.0)
    assert later in faults.active


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


# --- in a factory -----------------------------------------------------------------------------------


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
        factory.clock.call_at(185.0, lambda: left.update(faults.active))
        factory.clock.call_at(185.0, lambda: away.update(filterfalse(factory.running, factory.workers)))

    seen: set[type[Fault]] = set()
    left: dict[str, Fault] = {}
    away: set[str] = set()
    factory = in_factory(story, 3.2)
    # Nothing is carried in an idle factory, so no load can shift.
    assert seen == {*KINDS} - {LoadShifted, LoadDropped}
    assert not left
    assert not away
    assert factory.bus.relayed > 0


# --- lanes by the names of the plant file -----------------------------------------------------------


def test_a_lane_of_the_plant_file_is_blocked_where_vehicles_drive_it() -> None:
    world = FakeWorld()
    world.lanes = frozenset({("a1.to-b1", "b1.from-a1")})
    Faults(world).begin(LaneBlocked("a1", "b1"))
    assert world.done == ["pallet from a1.to-b1 to b1.from-a1"]


def test_a_road_with_one_stop_point_is_refused_with_the_lanes_that_meet_there() -> None:
    cast = Cast.of_plant(PLANT)
    with pytest.raises(
        FaultError, match=r"stop once on it, at ch2-lane.to-e1, .*ch2-lane.to-e1 to e1.to-m12"
    ):
        cast.check(LaneBlocked("ch2-lane", "e1"))
    cast.check(LaneBlocked("ch2-lane.to-e1", "e1.to-m12-lane"))
    with pytest.raises(FaultError, match="a lane of the plant file"):
        cast.check(LaneBlocked("a1", "f5"))

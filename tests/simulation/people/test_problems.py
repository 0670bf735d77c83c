"""Operators mend what a vehicle has: what they notice, and in which order they act."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from random import Random

import pytest
from people_floor import AUTHORITY, PLANT, QUICK, SOUTH, Floor, Story, play, trouble, until

from dray.messages import AtvStatus, Brief, CommandKind, Link, Pose, Role
from dray_sim.bodies.vehicle.condition import LOAD_SHIFTED
from dray_sim.clock.loop import clock
from dray_sim.people.areas import area_at
from dray_sim.people.duty import Duty
from dray_sim.people.operators import LOOK_S, Operator
from dray_sim.people.tablet import ANSWER_S, TRIES

BEYOND = Pose(x_m=30.0, y_m=25.5, heading_rad=0.0)
"""Just outside of AREA1, in AREA2."""


def test_a_problem_is_mended_on_the_spot_without_a_stop() -> None:
    floor = play(trouble("blocked way"))
    assert floor.deeds == ["mend"]
    assert floor.hands.deeds[0][1] == pytest.approx(LOOK_S + 1.0 + 10.0 + 20.0)
    assert floor.puppet.heard == []
    assert floor.operator.done[Duty.HELP] == 1


def test_help_that_is_asked_for_is_promised_for_as_long_as_it_takes() -> None:
    floor = play(trouble("blocked way", waits_s=100.0))
    ((at_s, promise),) = floor.puppet.heard
    assert (promise.kind, promise.issued_by) == (CommandKind.PROMISE, "operator-AREA1")
    mended_s = floor.hands.deeds[0][1]
    assert promise.wait_s == 30.0
    assert at_s + promise.wait_s == pytest.approx(mended_s, abs=0.5)


def test_who_promises_nothing_comes_all_the_same() -> None:
    floor = play(trouble("blocked way", waits_s=100.0), replace(QUICK, promises_frac=0.0))
    assert floor.puppet.heard == []
    assert floor.deeds == ["mend"]


def test_a_shifted_load_is_secured_by_stop_acknowledge_and_resume_in_this_order() -> None:
    floor = play(trouble(LOAD_SHIFTED))
    assert floor.puppet.kinds == [CommandKind.STOP, CommandKind.ACKNOWLEDGE, CommandKind.RESUME]
    (stop_s, _), (acknowledge_s, _), _ = floor.puppet.heard
    assert floor.deeds == ["mend"]
    assert stop_s + 20.0 <= floor.hands.deeds[0][1] <= acknowledge_s
    assert floor.puppet.status is AtvStatus.WORKING


def test_a_shifted_load_is_driven_on_slowly_and_later_as_before() -> None:
    floor = play(trouble(LOAD_SHIFTED), replace(QUICK, slow_frac=0.4, slow_s=60.0))
    assert floor.puppet.kinds == [
        CommandKind.STOP,
        CommandKind.SET_SPEED,
        CommandKind.ACKNOWLEDGE,
        CommandKind.RESUME,
        CommandKind.SET_SPEED,
    ]
    slow, fast = ((at_s, each) for at_s, each in floor.puppet.heard if each.kind is CommandKind.SET_SPEED)
    assert (slow[1].speed_frac, fast[1].speed_frac) == (0.4, 1.0)
    assert 60.0 <= fast[0] - slow[0] <= 60.0 + 2 * LOOK_S


def test_every_command_is_said_again_until_it_is_answered_and_before_the_next() -> None:
    async def story(floor: Floor) -> None:
        floor.puppet.deaf = 3
        await trouble(LOAD_SHIFTED)(floor)

    floor = play(story)
    stops = [(at_s, each) for at_s, each in floor.puppet.heard if each.kind is CommandKind.STOP]
    assert len(stops) == 4
    assert len({each.command for _, each in stops}) == 1
    assert stops[1][0] - stops[0][0] == pytest.approx(ANSWER_S, abs=0.3)
    assert floor.puppet.kinds == [CommandKind.STOP, CommandKind.ACKNOWLEDGE, CommandKind.RESUME]


def test_a_stop_that_was_not_released_is_released_when_the_vehicle_hears_again() -> None:
    async def story(floor: Floor) -> None:
        floor.puppet.status, floor.puppet.problem = AtvStatus.ERROR, LOAD_SHIFTED
        await until(lambda: floor.puppet.status is AtvStatus.STOPPED)
        # Longer than anybody goes on saying it, and the heartbeats are heard all the time.
        floor.puppet.deaf = TRIES
        await asyncio.sleep(20.0 + TRIES * ANSWER_S + 5.0)
        assert floor.puppet.status is AtvStatus.STOPPED
        await asyncio.sleep(60.0)

    floor = play(story)
    assert floor.puppet.status is AtvStatus.WORKING
    assert floor.operator.done[Duty.RELEASE] == 1


def test_a_refused_acknowledge_is_not_followed_by_a_resume() -> None:
    async def story(floor: Floor) -> None:
        floor.puppet.refuses = {CommandKind.ACKNOWLEDGE}
        await trouble(LOAD_SHIFTED)(floor)

    assert CommandKind.RESUME not in play(story).puppet.kinds


def test_somebody_elses_stop_is_left_to_them() -> None:
    async def story(floor: Floor) -> None:
        floor.puppet.status, floor.puppet.problem = AtvStatus.STOPPED, LOAD_SHIFTED
        await asyncio.sleep(300.0)

    floor = play(story)
    assert floor.deeds == ["mend"]
    assert floor.puppet.heard == []
    assert floor.puppet.status is AtvStatus.STOPPED


def crew(floor: Floor) -> tuple[Operator, Operator]:
    """The operator of AREA1, and a colleague in AREA2."""
    colleague = Operator(
        "AREA2",
        plant=PLANT,
        bus=floor.bus,
        clock=clock(),
        authority=AUTHORITY,
        hands=floor.hands,
        random=Random(2),
        habits=QUICK,
    )
    both = {"AREA1": floor.operator, "AREA2": colleague}
    floor.operator.colleagues = colleague.colleagues = both
    return floor.operator, colleague


def test_a_stop_beyond_the_border_is_ended_by_the_colleague_there() -> None:
    ended: list[int] = []

    async def story(floor: Floor) -> None:
        here, there = crew(floor)
        life = asyncio.create_task(there.run())
        floor.puppet.status, floor.puppet.problem = AtvStatus.ERROR, LOAD_SHIFTED
        await until(lambda: floor.puppet.status is AtvStatus.STOPPED)
        # It rolls a little further, out of the area.
        floor.puppet.pose = BEYOND
        await until(lambda: floor.puppet.status is AtvStatus.WORKING)
        ended.extend(each.done[Duty.RELEASE] for each in (here, there))
        await asyncio.sleep(10.0)
        life.cancel()

    floor = play(story)
    assert [sender for sender, command in floor.puppet.obeyed if command is CommandKind.RESUME] == [
        "operator-AREA2"
    ]
    assert ended[0] == 0


def test_a_stop_that_is_refused_is_forgotten_and_nobody_reaches_in() -> None:
    async def story(floor: Floor) -> None:
        floor.puppet.status, floor.puppet.problem = AtvStatus.ERROR, LOAD_SHIFTED
        # On its way to the vehicle, which has meanwhile slipped once more in another area.
        await asyncio.sleep(LOOK_S + 5.0)
        floor.puppet.pose = SOUTH
        await asyncio.sleep(300.0)

    floor = play(story)
    assert (floor.deeds, floor.puppet.obeyed) == ([], [])


def test_a_problem_that_is_gone_on_arrival_is_left_alone() -> None:
    async def story(floor: Floor) -> None:
        await trouble("blocked way", for_s=10.0)(floor)
        floor.puppet.status, floor.puppet.problem = AtvStatus.WORKING, ""
        await asyncio.sleep(100.0)

    assert play(story).deeds == []


def test_a_healthy_vehicle_is_left_alone() -> None:
    async def story(_floor: Floor) -> None:
        await asyncio.sleep(1000.0)

    floor = play(story)
    assert (floor.deeds, floor.puppet.heard) == ([], [])


def test_a_vehicle_in_another_area_is_somebody_elses() -> None:
    async def story(floor: Floor) -> None:
        floor.puppet.pose = SOUTH
        await trouble("blocked way")(floor)

    assert play(story).deeds == []
    assert play(story, area=area_at(PLANT, SOUTH.x_m, SOUTH.y_m)).deeds == ["mend"]


def test_nobody_comes_while_nobody_is_there() -> None:
    away = replace(QUICK, present_frac=0.0, away_s=(50.0, 50.0))
    assert play(trouble("blocked way"), away).deeds == []


# --- a lost WLAN ---------------------------------------------------------------------------------------


def left_with_its_radio(*, mended: bool, until_delivered_s: float = 200.0) -> Story:
    """A vehicle that carries something loses its WLAN, delivers, and waits."""

    async def story(floor: Floor) -> None:
        floor.hands.can_plug_in = mended
        floor.puppet.link = Link.MESH
        floor.puppet.task = Brief(task="T1", epoch=1, role=Role.PRIMARY, coordinator="M1")
        await asyncio.sleep(until_delivered_s)
        assert floor.deeds == [], "it is let deliver"
        floor.puppet.task = None
        await asyncio.sleep(600.0)

    return story


def test_a_lost_wlan_is_put_right_after_the_delivery() -> None:
    floor = play(left_with_its_radio(mended=True))
    assert floor.deeds == ["plug in"]
    assert floor.operator.done[Duty.RECONNECT] == 1


def test_where_an_access_point_is_down_nobody_walks_there_again_and_again() -> None:
    assert play(left_with_its_radio(mended=False)).deeds == ["plug in"]

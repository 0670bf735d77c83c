"""A scenario that is played live: its steps and its end come to the gateway from the factory's thread."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial
from threading import Event
from typing import cast

import pytest

from dray.adapters.crossing import Crossing
from dray.cli.simulation.rehearsal import Expected, Rehearsed, rehearse, rehearsing
from dray.cli.simulation.scenario_player import SimScenarioPlayer, view_of
from dray.gateway.live.timescale import TimeScale
from dray.gateway.live.views import ScenarioView, StepView
from dray.scenario_steps import ScenarioStep
from dray_sim.clock.loop import VirtualLoop, paced, run
from dray_sim.clock.wall import GIVE_WAY_S, UNHEARD, HurryingClock
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.bridge import SimThread
from dray_sim.run.evidence import Check
from dray_sim.run.live import LivePlay
from dray_sim.run.part import Part
from dray_sim.run.stage import Shift, Stage, with_right_of_way
from dray_sim.scenarios import LIVE
from dray_sim.scenarios.paper.laboratory import laboratory

STEPS = (ScenarioStep.ORDERED, ScenarioStep.SWITCHED_OFF, ScenarioStep.DELIVERED)

SPEED = 1000.0

SLOW = 5.0
"""Factory seconds per real second at which nobody waits for a script of some hundreds."""

BEGAN_S = 1_900_000_000.0

TIME = TimeScale(0.0, BEGAN_S, SPEED)


async def switch_off(stage: Stage) -> str:
    stage.steps.tell(ScenarioStep.ORDERED)
    await stage.until_s(20.0)
    stage.factory.power_off("ATV3")
    stage.steps.tell(ScenarioStep.SWITCHED_OFF, "ATV3")
    return "as it should"


async def steal(stage: Stage) -> str:
    stage.factory.storages["S3"].stock["shaft"] -= 1
    await asyncio.Event().wait()
    return "never"


def judge(told: str) -> tuple[Check, ...]:
    return (Check("It is switched off", told == "as it should", told),)


def follow(script: Callable[[Stage], object]) -> tuple[list[ScenarioView], LivePlay, bool]:
    """Play a script in a thread of its own until it has ended.

    Returns:
        All that the gateway was told, the play, and whether its factory went on.
    """
    part = Part("case-0", Shift("case-0", 0.0), laboratory, script, STEPS, judge)  # type: ignore[arg-type]

    async def live(ready: Callable[[LivePlay], None]) -> None:
        play = LivePlay(part, laboratory(), 1, SimFactory)
        ready(play)
        await play.run()

    thread: SimThread[LivePlay] = SimThread(live, paced(SPEED))
    play = thread.start(60.0)
    told: list[ScenarioView] = []

    async def listen() -> None:
        ended = asyncio.Event()

        def tell(view: ScenarioView) -> None:
            told.append(view)
            if view.state != "playing":
                ended.set()

        SimScenarioPlayer(play, thread.loop, "what it shows", TIME, lambda _hurries: None).follow(tell)
        await ended.wait()

    try:
        asyncio.run(listen())
        goes_on = play.stage.factory.running("ATV1")
    finally:
        thread.stop()
    return told, play, goes_on


def test_each_step_is_told_with_the_plants_time_and_then_the_end() -> None:
    told, play, _ = follow(switch_off)
    last = told[-1]
    assert (last.id, last.shows, last.state) == ("case-0", "what it shows", "held")
    assert last.began_at_s == BEGAN_S
    off_s = play.stage.steps.happened[ScenarioStep.SWITCHED_OFF].at_s - play.began_s
    assert off_s == pytest.approx(20.0, abs=1.0)
    assert last.steps == (
        StepView(step=ScenarioStep.ORDERED, after_s=0.0),
        StepView(step=ScenarioStep.SWITCHED_OFF, after_s=off_s, agents=("ATV3",)),
        StepView(step=ScenarioStep.DELIVERED),
    )
    assert [check.name for check in last.checks] == [
        "It is switched off",
        "Every invariant held all the time",
    ]
    happened = [sum(step.after_s is not None for step in view.steps) for view in told]
    assert happened == sorted(happened)


def test_a_broken_invariant_ends_the_play_and_not_the_factory() -> None:
    told, _, goes_on = follow(steal)
    assert told[-1].state == "failed"
    assert [check.held for check in told[-1].checks] == [False]
    assert "invariant 2" in told[-1].checks[0].figure
    assert goes_on


# --- skipping ---------------------------------------------------------------------------------------


async def long_night(stage: Stage) -> str:
    stage.steps.tell(ScenarioStep.ORDERED)
    await stage.until_s(600.0)
    stage.steps.tell(ScenarioStep.SWITCHED_OFF, "ATV3")
    await stage.until_s(1800.0)
    stage.steps.tell(ScenarioStep.DELIVERED)
    return "as it should"


def night() -> LivePlay:
    part = Part("case-0", Shift("case-0", 0.0), laboratory, long_night, STEPS, judge)
    return LivePlay(part, laboratory(), 1, SimFactory)


def test_a_skip_ends_with_the_next_step_and_both_clocks_have_gone_ahead_together() -> None:
    clock, told = HurryingClock(), list[ScenarioView]()

    async def live(ready: Callable[[LivePlay], None]) -> None:
        play = night()
        ready(play)
        await play.run()

    thread: SimThread[LivePlay] = SimThread(live, paced(SLOW), wall=clock.wall)
    play = thread.start(60.0)
    began_s = clock.wall.now_s()

    async def skip_twice() -> None:
        news = asyncio.Event()

        def tell(view: ScenarioView) -> None:
            told.append(view)
            news.set()

        async def come(state: Callable[[ScenarioView], bool]) -> ScenarioView:
            while not told or not state(told[-1]):
                news.clear()
                await news.wait()
            return told[-1]

        time = TimeScale(play.began_s, began_s, SLOW)
        player = SimScenarioPlayer(play, thread.loop, "", time, clock.wall.hurry)
        player.follow(tell)
        assert (await player.skip(skips=True)).skipping
        first = await come(lambda view: view.steps[1].after_s is not None)
        assert first.steps[1].after_s == pytest.approx(600.0)
        assert not first.skipping
        # 600 s at 5x are two minutes on the wall, which nobody has waited for.
        assert clock.wall.now_s() - began_s == pytest.approx(120.0, abs=60.0)
        assert (await player.skip(skips=True)).skipping
        assert not (await player.skip(skips=False)).skipping
        assert (await player.skip(skips=True)).skipping
        last = await come(lambda view: view.state != "playing")
        assert last.steps[2].after_s == pytest.approx(1800.0)
        assert not (await player.skip(skips=True)).skipping

    try:
        asyncio.run(asyncio.wait_for(skip_twice(), 120.0))
    finally:
        thread.stop()


def test_a_clock_that_hurries_gives_way_to_a_gateway_with_much_to_hear() -> None:
    clock = HurryingClock()
    assert clock.pass_over(3.0) == 3.0
    clock.wall.hurry(True)
    before_s = clock.wall.now_s()
    assert clock.pass_over(3600.0) == 0.0
    assert clock.wall.now_s() - before_s >= 3600.0
    # Nothing is due: there is nothing to pass over.
    assert clock.pass_over(None) is None

    async def fall_behind() -> None:
        outbound = Crossing(asyncio.get_running_loop())
        clock.wall.met(cast(VirtualLoop, None), outbound)
        for _ in range(UNHEARD + 1):
            outbound.order(list)
        full_s = clock.wall.now_s()
        assert clock.pass_over(3600.0) == GIVE_WAY_S
        assert clock.wall.now_s() - full_s < 3600.0
        heard = asyncio.Event()
        outbound.order(heard.set)
        await heard.wait()
        assert clock.pass_over(3600.0) == 0.0

    asyncio.run(fall_behind())


# --- the rehearsal ----------------------------------------------------------------------------------

WAYLAID = Rehearsed("case-4", seed=1, traffic=True)


def test_a_play_goes_as_its_rehearsal_has_told() -> None:
    told: list[Expected] = []
    rehearse(WAYLAID, told.append)
    part = LIVE[WAYLAID.name].part
    assert [each.step for each in told] == list(part.steps)

    async def live(ready: Callable[[LivePlay], None]) -> None:
        with with_right_of_way(WAYLAID.traffic):
            play = LivePlay(part, part.plant(), WAYLAID.seed, partial(SimFactory))
        ended = Event()
        play.on_change = lambda: ended.set() if play.ending is not None else None
        play_and_end.append((play, ended))
        ready(play)
        await play.run()

    play_and_end: list[tuple[LivePlay, Event]] = []
    thread: SimThread[LivePlay] = SimThread(live, paced(SPEED))
    try:
        thread.start(60.0)
        ((play, ended),) = play_and_end
        assert ended.wait(120.0)
    finally:
        thread.stop()
    happened = play.stage.steps.happened
    assert told == [Expected(step, happened[step].at_s - play.began_s) for step in part.steps]


def test_a_rehearsal_is_heard_from_a_process_beside() -> None:
    told: list[Expected] = []

    async def listen() -> None:
        done = asyncio.Event()

        def tell(each: Expected) -> None:
            told.append(each)
            if each.step is ScenarioStep.DELIVERED:
                done.set()

        async with rehearsing(WAYLAID, tell):
            await done.wait()

    asyncio.run(asyncio.wait_for(listen(), 120.0))
    here: list[Expected] = []
    rehearse(WAYLAID, here.append)
    assert told == here


def test_a_step_is_expected_as_much_later_as_the_last_one_was() -> None:
    expected = {ScenarioStep.SWITCHED_OFF: 590.0, ScenarioStep.DELIVERED: 1700.0}

    async def look() -> tuple[ScenarioView, ScenarioView]:
        play = night()
        before = view_of(play, "", expected)
        playing = asyncio.create_task(play.run())
        await play.stage.until_s(601.0)
        after = view_of(play, "", expected)
        playing.cancel()
        return before, after

    before, after = run(look())
    assert [step.expected_s for step in before.steps] == [None, 590.0, 1700.0]
    assert [step.after_s for step in after.steps] == [0.0, 600.0, None]
    assert [step.expected_s for step in after.steps] == [None, 590.0, 1710.0]

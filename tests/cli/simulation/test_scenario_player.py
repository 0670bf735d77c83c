"""A scenario that is played live: its steps and its end come to the gateway from the factory's thread."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

import pytest

from dray.cli.simulation.scenario_player import SimScenarioPlayer
from dray.gateway.live.views import ScenarioView, StepView
from dray.scenario_steps import ScenarioStep
from dray_sim.clock.loop import paced
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.bridge import SimThread
from dray_sim.run.evidence import Check
from dray_sim.run.live import LivePlay
from dray_sim.run.part import Part
from dray_sim.run.stage import Shift, Stage
from dray_sim.scenarios.paper.laboratory import laboratory

STEPS = (ScenarioStep.ORDERED, ScenarioStep.SWITCHED_OFF, ScenarioStep.DELIVERED)

SPEED = 1000.0


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

        SimScenarioPlayer(play, thread.loop, "what it shows").follow(tell)
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

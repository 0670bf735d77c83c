"""A factory whose agents end and begin again: what of them is left, and what is not."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from typing import Any

import pytest

from dray.messages import Heartbeat, Message, StationHeartbeat
from dray.messages.keys import GATE, STRATEGIST
from dray.plant import default_plant
from dray.plant.model import VehicleSpec
from dray_sim.clock.loop import clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.run.trace import Trace

AGENTS = ("ATV3", "M8", STRATEGIST)
"""One of every kind."""

BEATS_S = 10.0
"""By then everything that lives and has a heartbeat has been heard."""


class Heard:
    """The heartbeats of a factory, as anybody hears them."""

    def __init__(self) -> None:
        self.beats: list[tuple[float, str, Heartbeat | StationHeartbeat]] = []

    def on_message(self, at_s: float, sender: str, address: str, message: Message) -> None:
        if isinstance(message, Heartbeat | StationHeartbeat):
            self.beats.append((at_s, sender, message))

    def of(self, agent: str, since_s: float = 0.0) -> list[Heartbeat | StationHeartbeat]:
        return [beat for at_s, sender, beat in self.beats if at_s >= since_s and agent == sender]


def in_a_factory(story: Callable[[SimFactory, Heard], Coroutine[Any, Any, None]], **options: Any) -> None:
    """Tell a story in a running factory, ten seconds after its beginning."""

    async def main() -> None:
        heard = Heard()
        factory = SimFactory(default_plant(), clock(), seed=1, listener=heard, **options)
        async with asyncio.TaskGroup() as group:
            life = group.create_task(factory.run())
            await asyncio.sleep(BEATS_S)
            await story(factory, heard)
            life.cancel()

    run(main())


@pytest.mark.parametrize("agent", AGENTS)
def test_a_crashed_agent_is_gone_and_all_others_go_on(agent: str) -> None:
    async def story(factory: SimFactory, heard: Heard) -> None:
        factory.crash(agent)
        factory.crash(agent)
        at_s = clock().now_s()
        assert not factory.running(agent)
        await asyncio.sleep(BEATS_S)
        assert heard.of(agent, at_s) == []
        others = [name for name in factory.workers if name not in {agent, STRATEGIST}]
        assert all(factory.running(name) and heard.of(name, at_s) for name in others)

    in_a_factory(story)


@pytest.mark.parametrize("agent", AGENTS)
def test_a_restarted_agent_begins_its_next_life(agent: str) -> None:
    async def story(factory: SimFactory, heard: Heard) -> None:
        factory.crash(agent)
        await asyncio.sleep(BEATS_S)
        at_s = clock().now_s()
        factory.restart(agent)
        await asyncio.sleep(BEATS_S)
        assert factory.running(agent)
        assert factory.journals[agent].incarnation == factory.workers[agent].agent.incarnation == 6
        assert factory.workers[agent].handled > 0
        if agent != STRATEGIST:
            assert {beat.incarnation for beat in heard.of(agent)} == {5, 6}
            assert next(beat.seq for beat in heard.of(agent, at_s)) == 1

    in_a_factory(story, incarnation=5)


def test_a_restart_ends_the_life_before_it_in_the_same_instant() -> None:
    async def story(factory: SimFactory, heard: Heard) -> None:
        for _ in range(3):
            factory.restart("M8")
        at_s = clock().now_s()
        await asyncio.sleep(BEATS_S)
        assert {beat.incarnation for beat in heard.of("M8", at_s)} == {4}
        assert factory.running("M8")

    in_a_factory(story)


def test_another_software_is_shown_from_the_restart_on_and_kept_over_the_next() -> None:
    async def story(factory: SimFactory, heard: Heard) -> None:
        at_s = clock().now_s()
        factory.restart("ATV3", software="9.9.9")
        factory.restart("M8", software="9.9.9")
        await asyncio.sleep(BEATS_S)
        factory.restart("ATV3")
        await asyncio.sleep(BEATS_S)
        for agent in ("ATV3", "M8"):
            assert {beat.software for beat in heard.of(agent, at_s)} == {"9.9.9"}
        assert "9.9.9" not in {beat.software for beat in heard.of("ATV1")}

    in_a_factory(story)


@pytest.mark.parametrize("agent", ["ATV3", "M8"])
def test_without_power_body_and_agent_are_off_and_both_come_back(agent: str) -> None:
    async def story(factory: SimFactory, heard: Heard) -> None:
        body = factory.vehicles.get(agent) or factory.workcells[agent]
        factory.power_off(agent)
        factory.power_off(agent)
        at_s = clock().now_s()
        await asyncio.sleep(BEATS_S)
        assert body.off
        assert not factory.running(agent)
        assert heard.of(agent, at_s) == []
        factory.power_on(agent)
        factory.power_on(agent)
        await asyncio.sleep(BEATS_S)
        assert not body.off
        assert factory.running(agent)
        assert {beat.incarnation for beat in heard.of(agent, at_s)} == {2}

    in_a_factory(story)


def test_an_agent_without_power_is_not_restarted_until_it_has_some() -> None:
    async def story(factory: SimFactory, heard: Heard) -> None:
        factory.power_off("ATV3")
        factory.restart("ATV3", software="2.0")
        assert not factory.running("ATV3")
        factory.power_on("ATV3")
        at_s = clock().now_s()
        await asyncio.sleep(BEATS_S)
        beats = heard.of("ATV3", at_s)
        assert {(beat.incarnation, beat.software) for beat in beats} == {(2, "2.0")}

    in_a_factory(story)


def test_the_strategist_has_no_power_switch_and_nobody_unknown_has_a_life() -> None:
    async def story(factory: SimFactory, heard: Heard) -> None:
        for act in (factory.power_off, factory.power_on):
            with pytest.raises(KeyError):
                act(STRATEGIST)
        for act in (factory.crash, factory.restart, factory.running):
            with pytest.raises(KeyError):
                act("nobody")

    in_a_factory(story)


def test_a_vehicle_joins_a_running_factory() -> None:
    async def story(factory: SimFactory, heard: Heard) -> None:
        node, kind = factory.plant.fleet["ATV1"].node, factory.plant.fleet["ATV1"].type
        spec = VehicleSpec(id="ATV99", type=kind, node=node)
        with pytest.raises(ValueError, match="M8 is there already"):
            factory.add_vehicle(VehicleSpec(id="M8", type=kind, node=node))
        vehicle = factory.add_vehicle(spec)
        await asyncio.sleep(BEATS_S)
        assert factory.vehicles["ATV99"] is vehicle
        assert factory.running("ATV99")
        assert heard.of("ATV99")
        factory.restart("ATV99")
        await asyncio.sleep(BEATS_S)
        assert {beat.incarnation for beat in heard.of("ATV99")} == {1, 2}

    in_a_factory(story)


def test_a_factory_of_which_all_agents_have_crashed_can_be_restarted() -> None:
    async def story(factory: SimFactory, heard: Heard) -> None:
        for agent in factory.workers:
            factory.crash(agent)
        await asyncio.sleep(60.0)
        at_s = clock().now_s()
        for agent in factory.workers:
            factory.restart(agent)
        await asyncio.sleep(BEATS_S)
        beating = {name for name in factory.workers if heard.of(name, at_s)}
        assert beating == {*factory.vehicles, *factory.workcells, *factory.storages, GATE}

    in_a_factory(story)


def test_an_agent_that_ends_by_an_exception_ends_the_factory() -> None:
    async def story(factory: SimFactory, heard: Heard) -> None:
        factory.restart("M8")

        def fail(*_: object) -> None:
            raise ZeroDivisionError

        factory.workers["M8"].agent.handle = fail  # type: ignore[method-assign, assignment]
        await asyncio.sleep(BEATS_S)

    with pytest.raises(ExceptionGroup) as caught:
        in_a_factory(story)
    assert caught.group_contains(ZeroDivisionError)


def test_the_same_lives_give_the_same_run() -> None:
    def digest() -> str:
        async def main() -> str:
            trace = Trace()
            factory = SimFactory(default_plant(), clock(), seed=3, listener=trace)
            life = asyncio.create_task(factory.run())
            for agent in (*factory.workers, *factory.workers):
                await asyncio.sleep(3.7)
                factory.restart(agent)
            life.cancel()
            await asyncio.gather(life, return_exceptions=True)
            return trace.hexdigest()

        return run(main())

    assert digest() == digest()

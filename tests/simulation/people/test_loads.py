"""What becomes of goods on board of a dead vehicle in a running factory: handed over, written off, or waited for."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, replace
from random import Random

import msgspec
import pytest
from people_floor import PLANT, QUICK, until

from dray.adapters.vda5050.profile import Profile, load_profile
from dray.adapters.vda5050.wire.dialects import Version
from dray.messages import CallState, Event, HelpCall, MachineCommandKind, Message, Transport
from dray.messages.fact import CommandObeyed, TaskClosed, TaskOpened
from dray.protocol.takeover.left_aboard import WRITTEN_OFF_AFTER_S
from dray_sim.checks.invariants import Invariants
from dray_sim.clock.loop import clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.listeners import Listeners
from dray_sim.people import demand
from dray_sim.people.crew import hire
from dray_sim.people.habits import Habits
from dray_sim.people.order_client import OrderClient
from dray_sim.vda5050.fleet import MemoryFleet


class Ear:
    """Remembers goods that are carried, how that ended, and what people have said."""

    def __init__(self) -> None:
        self.goods: dict[str, str] = {}
        """By task, the goal."""
        self.ended: dict[str, tuple[str, float]] = {}
        self.obeyed: list[str] = []
        self.calls: list[HelpCall] = []
        """For goods."""

    def on_message(self, at_s: float, _sender: str, _address: str, message: Message) -> None:
        if isinstance(message, HelpCall) and message.goods:
            self.calls.append(message)
        if not isinstance(message, Event):
            return
        fact = message.fact
        if isinstance(fact, TaskOpened) and isinstance(fact.work, Transport) and fact.work.goal:
            self.goods[fact.task] = fact.work.goal
        elif isinstance(fact, TaskClosed) and fact.task in self.goods:
            self.ended[fact.task] = fact.outcome, at_s
        elif isinstance(fact, CommandObeyed) and fact.done:
            self.obeyed.append(fact.what)


@dataclass
class Story:
    """What has happened to the first goods whose carrier died."""

    ear: Ear
    checks: Invariants
    factory: SimFactory
    task: str
    died_s: float
    handed_over: int


def play(habits: Habits | None, *, for_s: float = 600.0, profile: Profile | None = None) -> Story:
    """The first vehicle that carries goods dies with them; these people are there, or nobody.

    Args:
        habits: of the people; None for nobody.
        for_s: how long it goes on.
        profile: of vehicles that are behind VDA 5050; None for those that are not.
    """

    async def main() -> Story:
        listeners, ear = Listeners(), Ear()
        fleet = MemoryFleet(PLANT, clock(), lambda _atv: profile)
        factory = SimFactory(PLANT, clock(), seed=3, listener=listeners, embody=fleet.embody)
        checks = Invariants(factory)
        listeners.add(checks)
        listeners.add(ear)
        crew = () if habits is None else hire(factory, seed=3, habits=habits)
        orders = demand.orders(PLANT, Random(3), load=0.5, until_s=600.0)
        async with asyncio.TaskGroup() as group:
            lives = [group.create_task(factory.run())]
            lives += [group.create_task(OrderClient(factory.bus, factory.clock).place(orders))]
            lives += [group.create_task(operator.run()) for operator in crew]
            await until(lambda: bool(loaded(factory)))
            atv = loaded(factory)[0]
            heard: list[str] = []
            listeners.add(_Carries(atv, heard.append))
            await until(lambda: bool(heard))
            factory.power_off(atv)
            died_s = factory.clock.now_s()
            await asyncio.sleep(for_s)
            for life in lives:
                life.cancel()
        checks.check_end(factory.clock.now_s())
        return Story(ear, checks, factory, heard[0], died_s, sum(each.loads.handed_over for each in crew))

    return run(main())


class _Carries:
    """Tells which task a vehicle names as the one that it carries."""

    def __init__(self, atv: str, tell: Callable[[str], None]) -> None:
        self._atv, self._tell = atv, tell

    def on_message(self, _at_s: float, sender: str, _address: str, message: Message) -> None:
        brief = getattr(message, "task", None)
        if sender == self._atv and getattr(brief, "phase", None) == "carrying":
            self._tell(brief.task)  # type: ignore[union-attr]


def loaded(factory: SimFactory) -> list[str]:
    """Vehicles with products on board."""
    return [atv for atv, body in factory.vehicles.items() if body.sense().load in PLANT.products]


def test_goods_are_handed_to_another_vehicle_which_delivers_them() -> None:
    story = play(replace(QUICK, hands_over_frac=1.0, hold_s=(500.0, 500.0)))
    assert story.checks.broken is None
    assert story.handed_over == 1
    assert story.ear.obeyed.count(MachineCommandKind.FETCH_GOODS.value) == 1
    assert story.ear.ended[story.task][0] == "delivered"
    assert sum(story.factory.in_hands.values()) == 0


@pytest.mark.parametrize("version", ["2.1", "3.0"])
def test_vehicles_behind_vda_5050_take_them_from_the_persons_hands_too(version: Version) -> None:
    profile = msgspec.structs.replace(load_profile("dray-sim"), version=version)
    story = play(replace(QUICK, hands_over_frac=1.0, hold_s=(500.0, 500.0)), profile=profile)
    assert story.checks.broken is None
    assert story.handed_over == 1
    assert story.ear.ended[story.task][0] == "delivered"
    assert sum(story.factory.in_hands.values()) == 0


def test_without_anybody_they_are_given_up_after_the_stated_time() -> None:
    story = play(None, for_s=WRITTEN_OFF_AFTER_S + 60.0)
    assert story.checks.broken is None
    outcome, at_s = story.ear.ended[story.task]
    assert outcome == "withdrawn"
    assert WRITTEN_OFF_AFTER_S <= at_s - story.died_s < WRITTEN_OFF_AFTER_S + 30.0


def test_who_carries_them_back_by_hand_has_them_sent_from_their_machine() -> None:
    story = play(QUICK)
    assert story.checks.broken is None
    assert story.handed_over == 0
    assert story.ear.ended[story.task][0] == "delivered"


def test_who_says_that_they_can_be_fetched_and_waits_for_nobody_brings_them_back() -> None:
    story = play(replace(QUICK, hands_over_frac=1.0, hold_s=(1.0, 1.0)))
    assert story.checks.broken is None
    assert story.ear.obeyed.count(MachineCommandKind.FETCH_GOODS.value) == 1
    assert story.handed_over == 0
    assert sum(story.factory.in_hands.values()) == 0


def test_an_operator_is_asked_to_come_for_them_takes_the_call_and_ends_it() -> None:
    story = play(replace(QUICK, hands_over_frac=1.0, hold_s=(500.0, 500.0)))
    calls = [call for call in story.ear.calls if call.goods == story.task]
    states = list(dict.fromkeys(call.state for call in calls if call.state is not CallState.RESTING))
    assert states == [CallState.ASKING, CallState.TAKEN, CallState.ENDED]
    assert calls[0].since_s - story.died_s < 15.0
    assert story.handed_over == 1


def test_where_nobody_is_they_are_called_for_as_long_as_they_are_kept() -> None:
    story = play(None, for_s=WRITTEN_OFF_AFTER_S + 60.0)
    calls = [call for call in story.ear.calls if call.goods == story.task]
    assert {call.state for call in calls} == {CallState.RESTING, CallState.ENDED}
    assert all(call.on_duty == 0 for call in calls)
    open_s = [call.at_s for call in calls if call.state is CallState.RESTING]
    assert max(open_s) - min(open_s) > WRITTEN_OFF_AFTER_S - 60.0

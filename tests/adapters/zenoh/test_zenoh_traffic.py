"""Right of way and closures on Zenoh: no place is held twice and nobody drives into what is closed, whoever is killed."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable
from itertools import count

import pytest
from zenoh_stage import LATEST_S, PLANT, Overheard, Stage, on_zenoh

from dray.messages import Closure, ClosureKind, Message, OrderItem, Phase, PlaceGranted, PlaceRequested
from dray.messages.fact import (
    AnyFact,
    AtvStatusChanged,
    ClosuresKnown,
    NameMisused,
    OrderFulfilled,
    PhaseEntered,
)
from dray.messages.floor.traffic import FIRST_S, HOLDS_MAX
from dray.ports import Receive, Session
from dray.protocol.vehicle.atv import Atv
from dray_sim.checks.floor.closed_lanes import ClosedLanes
from dray_sim.checks.floor.held_places import HeldPlaces
from dray_sim.checks.floor.overlaps import Overlaps
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.insiders import BEHAVIOURS
from dray_sim.insiders.joining import bring_in
from dray_sim.network.listeners import Listener
from dray_sim.people.demand import Order
from dray_sim.people.floor_manager import NAME, Closing, FloorManager

ORDER = Order("O-1", 0.0, LATEST_S, (OrderItem("gear-unit-g1", 2),))

CLOSED = "b4"
"""A node in the middle of the plant; others lead round it."""


def watched(factory: SimFactory) -> Iterable[Listener]:
    return HeldPlaces(factory), Overlaps(factory.vehicles), ClosedLanes(factory)


def sets_off(_agent: str, fact: AnyFact) -> bool:
    return isinstance(fact, PhaseEntered) and fact.phase is Phase.APPROACHING


async def replicas_and_the_vehicle_are_killed_on_the_way(stage: Stage) -> int:
    """How many replicas of reservation tables, after an order was delivered."""
    factory = stage.factory
    assert factory.traffic is not None
    await stage.customers.order(ORDER)
    atv, _ = await stage.until(sets_off)
    agent = factory.workers[atv].agent
    assert isinstance(agent, Atv)
    assert agent.right_of_way is not None
    places = factory.traffic.places
    districts = {places.district_of[place] for place in agent.right_of_way.way.held}
    first = {places.replicas_of[district][0] for district in districts}
    factory.restart(atv)
    for replica in first:
        factory.crash(replica)
    await stage.until(lambda _, fact: isinstance(fact, PhaseEntered) and fact.phase is Phase.CARRYING)
    for replica in first:
        factory.restart(replica)
    await stage.until(lambda _, fact: isinstance(fact, OrderFulfilled))
    assert agent is not factory.workers[atv].agent
    return len(first)


@pytest.mark.slow
def test_no_place_is_held_twice_when_a_vehicle_and_the_replicas_of_its_places_are_killed_on_zenoh() -> None:
    assert on_zenoh(replicas_and_the_vehicle_are_killed_on_the_way, traffic=True, checks=watched) in (1, 2)


STRANGER = "ATV9"
"""It has a place on the bus, no body, and no heartbeat."""


async def a_stranger_claims_every_place(stage: Stage) -> int:
    """How many places it was granted while an order was delivered, though it says to all replicas that it holds and wants all."""
    traffic = stage.factory.traffic
    assert traffic is not None
    granted: set[str] = set()

    def receive(_sender: str, message: Message) -> None:
        if isinstance(message, PlaceGranted):
            granted.update(line.place for line in message.grants)

    session = stage.bus.join(STRANGER, receive, 1)

    async def claim() -> None:
        for seq in count(1):
            for district, replicas in traffic.places.replicas_of.items():
                all_places = sorted(traffic.places.places_in(district))[:HOLDS_MAX]
                request = PlaceRequested(
                    district=district,
                    life=1,
                    seq=seq,
                    epoch=0,
                    rank=(0, FIRST_S, STRANGER),
                    holds=tuple(all_places),
                    groups=tuple((place,) for place in all_places),
                    seen=0,
                    stands=True,
                    docked=True,
                )
                for replica in replicas:
                    session.send(replica, request)
            await asyncio.sleep(5.0)

    claims = asyncio.create_task(claim())
    try:
        await stage.until(lambda _, fact: isinstance(fact, AtvStatusChanged))
        await stage.customers.order(ORDER)
        await stage.until(lambda _, fact: isinstance(fact, OrderFulfilled))
    finally:
        claims.cancel()
        session.leave()
    return len(granted)


@pytest.mark.slow
def test_who_claims_every_place_is_granted_none_and_an_order_is_delivered_on_zenoh() -> None:
    assert on_zenoh(a_stranger_claims_every_place, traffic=True, checks=watched) == 0


OWNER = next(iter(PLANT.fleet))

TOLD_WITHIN_S = 600.0
"""Of the plant's clock; the impostor speaks every second."""


class StolenCertificate:
    """A place on the bus under the name of a vehicle that is there and stays: it hears all letters to it and to the replicas of reservation tables."""

    def __init__(self, stage: Stage) -> None:
        self._stage = stage

    def join(self, agent: str, receive: Receive, life: int = 0) -> Session:
        session = self._stage.bus.join(STRANGER, receive, 0)
        assert isinstance(session, Overheard)
        assert self._stage.factory.traffic is not None
        session.take_name(agent)
        replicas = self._stage.factory.traffic.places.replicas_of.values()
        for reader in {agent, *(replica for each in replicas for replica in each)}:
            session.subscribe(self._stage.factory.keys.addressed(reader))
        return session


async def somebody_gives_back_what_another_one_holds(stage: Stage) -> set[str]:
    """Who was told to speak under another's name, after an order was delivered."""
    await stage.until(lambda _, fact: isinstance(fact, AtvStatusChanged))
    impostor = bring_in(stage.factory, BEHAVIOURS["speaks-in-anothers-name"], StolenCertificate(stage))
    lies = asyncio.create_task(impostor.run())
    try:
        await stage.customers.order(ORDER)
        await stage.until(lambda _, fact: isinstance(fact, OrderFulfilled))
        async with asyncio.timeout(TOLD_WITHIN_S):
            await stage.until(lambda _, fact: isinstance(fact, NameMisused))
    finally:
        lies.cancel()
        await asyncio.gather(lies, return_exceptions=True)
    return {fact.atv for _, fact in stage.facts if isinstance(fact, NameMisused)}


@pytest.mark.slow
def test_who_has_a_stolen_certificate_gives_back_nothing_of_its_owner_and_an_order_is_delivered_on_zenoh() -> (
    None
):
    assert on_zenoh(somebody_gives_back_what_another_one_holds, traffic=True, checks=watched) == {OWNER}


async def a_node_is_closed_while_an_order_is_on_its_way(stage: Stage) -> set[str]:
    """Who has gone by the list, after an order was delivered."""
    factory = stage.factory
    manager = FloorManager(stage.bus, factory.clock, factory.keys, factory.authority)
    closure = Closure(closure="C1", kind=ClosureKind.CLOSED, by=NAME, node=CLOSED)
    closing = Closing(closure, factory.clock.now_s(), LATEST_S, tells_end=False)
    at_work = asyncio.create_task(manager.close([closing]))
    try:
        await stage.customers.order(ORDER)
        await stage.until(lambda _, fact: isinstance(fact, OrderFulfilled))
    finally:
        at_work.cancel()
    return {agent for agent, fact in stage.facts if isinstance(fact, ClosuresKnown)}


@pytest.mark.parametrize("traffic", [False, True])
@pytest.mark.slow
def test_what_was_closed_is_known_to_all_and_entered_by_nobody_on_zenoh(traffic: bool) -> None:
    story = a_node_is_closed_while_an_order_is_on_its_way

    def closed(factory: SimFactory) -> Iterable[Listener]:
        return (ClosedLanes(factory),)

    checks = watched if traffic else closed
    assert on_zenoh(story, traffic=traffic, checks=checks) == set(PLANT.fleet)

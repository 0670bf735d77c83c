"""People who call transports: plain ones, some of them called off again, at any moment of their lives."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable
from dataclasses import dataclass, replace
from math import inf
from random import Random

import msgspec

from dray.messages import (
    THING,
    TRANSPORT_ENDED,
    Message,
    TransportAnswered,
    TransportCancelled,
    TransportOrdered,
    TransportState,
)
from dray.plant import Plant
from dray.ports import Bus, Clock

NAME = "caller"
"""Its name on the bus. Random generators are seeded with it."""

AGAIN_S = 5.0
"""Interval between two repetitions of an unanswered message."""

ASKED_EVERY_S = 40.0
"""Interval between two questions about a taken transport, as a gateway asks about open ones."""

CALLS = (1, 12)
"""Lowest and highest number of calls in a run."""

CALLED_OFF_FRAC = 0.3

FOR_ONE_VEHICLE_FRAC = 0.2

WISHED_FRAC = 0.5
"""Fraction of the calls for one vehicle in which that is a wish, which ends."""


ABLE_FRAC = 0.5
"""Fraction of the calls that want an ability of the vehicle beyond that of the load."""


@dataclass(frozen=True, slots=True)
class Call:
    """A transport that a person asks for.

    Attributes:
        at_s: when (plant clock).
        to: its destination.
        order: the message.
        off_s: when it is called off, if it has not ended by then (plant clock).
    """

    at_s: float
    to: str
    order: TransportOrdered
    off_s: float


def draw_calls(
    plant: Plant, random: Random, wishes: Random, abilities: Random, until_s: float
) -> tuple[Call, ...]:
    """The transports of one run, between any two places that keep a material; none is waited for after `until_s`.

    `wishes` decides which vehicles are only wished for, and `abilities` the wanted abilities, so that older seeds
    give the same calls.
    """
    calls = []
    for number in range(random.randint(*CALLS)):
        item = random.choice(sorted(plant.materials))
        places = plant.keepers_of(item)
        if len(places) < 2:
            continue
        source, to = random.sample(places, 2)
        at_s = random.uniform(0.0, until_s)
        off_s = random.uniform(at_s, until_s) if random.random() < CALLED_OFF_FRAC else until_s
        vehicle = random.choice(sorted(plant.fleet)) if random.random() < FOR_ONE_VEHICLE_FRAC else ""
        quantity = random.randint(1, plant.materials[item].lot)
        order = TransportOrdered(
            f"T-{number + 1}", source, item, quantity, at_s + random.uniform(30.0, 600.0), vehicle
        )
        if vehicle and wishes.random() < WISHED_FRAC:
            order = msgspec.structs.replace(order, vehicle_until_s=at_s + wishes.uniform(1.0, 300.0))
        if (ability := _wanted(plant, order, abilities)) and abilities.random() < ABLE_FRAC:
            order = msgspec.structs.replace(order, ability=ability)
        calls.append(Call(at_s, to, order, off_s))
    return tuple(calls)


def with_things(
    plant: Plant, calls: Iterable[Call], random: Random, frac: float, until_s: float
) -> tuple[Call, ...]:
    """The same calls, of which this fraction is for a thing without a count: from any place to another.

    A thing always finds room, and is always there. So a call for a thing must end, however long it takes, unless it
    is for one vehicle alone or called off before `until_s`.
    """
    places = [*sorted(plant.machines), *sorted(plant.stores)]

    def drawn(call: Call) -> Call:
        if random.random() >= frac:
            return call
        source = random.choice([place for place in places if place != call.to])
        order = call.order
        ability = plant.materials[order.item].ability
        thing = msgspec.structs.replace(order, source=source, item=THING, quantity=1, ability=ability)
        is_patient = call.off_s >= until_s and not order.vehicle
        return replace(call, order=thing, off_s=inf if is_patient else call.off_s)

    return tuple(map(drawn, calls))


def _wanted(plant: Plant, order: TransportOrdered, random: Random) -> str:
    """An additional ability of a vehicle that may carry the load; empty where there is none."""
    needs = plant.materials[order.item].ability
    fleet = [order.vehicle] if order.vehicle else plant.able(needs)
    types = [plant.vehicle_types[plant.fleet[vehicle].type] for vehicle in fleet]
    more = {ability for kind in types for ability in kind.abilities} - {needs}
    return random.choice(sorted(more)) if more else ""


class TransportCaller:
    """Asks for transports, each again and again until it has ended.

    Args:
        bus: joined at once.
        clock: the plant's clock.

    Attributes:
        states: how those are that were answered.
    """

    def __init__(self, bus: Bus, clock: Clock) -> None:
        self._session = bus.join(NAME, self._on_message)
        self._clock = clock
        self._answers: dict[str, asyncio.Event] = {}
        self.states: dict[str, TransportState] = {}

    async def call(self, calls: Iterable[Call]) -> None:
        """Ask for all of them at their times; returns when all have ended."""
        async with asyncio.TaskGroup() as group:
            for call in calls:
                group.create_task(self._see_to(call))

    async def _see_to(self, call: Call) -> None:
        name = call.order.transport
        self._answers[name] = asyncio.Event()
        await asyncio.sleep(max(0.0, call.at_s - self._clock.now_s()))
        while self.states.get(name) not in TRANSPORT_ENDED:
            is_off = self._clock.now_s() >= call.off_s
            await self._ask(call.to, TransportCancelled(name) if is_off else call.order)
            if self.states[name] not in TRANSPORT_ENDED:
                left_s = max(AGAIN_S, call.off_s - self._clock.now_s())
                await asyncio.sleep(min(ASKED_EVERY_S, left_s))
        # A person who has missed the end asks once more: the transport does not begin again.
        await self._ask(call.to, call.order)

    async def _ask(self, to: str, message: TransportOrdered | TransportCancelled) -> None:
        answered = self._answers[message.transport]
        answered.clear()
        while not answered.is_set():
            self._session.send(to, message)
            try:
                await asyncio.wait_for(answered.wait(), AGAIN_S)
            except TimeoutError:
                continue

    def _on_message(self, _sender: str, message: Message) -> None:
        if isinstance(message, TransportAnswered):
            self.states[message.transport] = message.state
            self._answers[message.transport].set()

"""The conformance suite of `dray.ports.Bus`: on every bus nobody speaks in the name of another, or tells what is another kind's."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import pytest
from buses import KINDS, Certified, InProcess, World
from makings import making

from dray.messages import (
    AnyFact,
    AtvHeartbeat,
    AtvStatus,
    DwellPointClaimed,
    Event,
    MachineHeartbeat,
    MachineStatus,
    Message,
    OrderTaken,
    Phase,
    Pose,
    Role,
    TaskAnnounced,
)
from dray.messages.fact import GoodsDelivered, PhaseEntered
from dray.messages.speakers import FOREIGN_FACT, FOREIGN_KEY, FOREIGN_NAME, FOREIGN_WORD

WHERE_KINDS_ARE_KNOWN: Mapping[str, Callable[[Path], World]] = {
    "in-process": lambda _: InProcess(kinds=KINDS),
    "Zenoh with certificates": Certified,
}


class Listener:
    """An agent that remembers all that it has heard."""

    def __init__(self, world: World, name: str, *subscriptions: str) -> None:
        self.heard: list[tuple[str, Message]] = []
        self.session = world.bus.join(name, lambda sender, message: self.heard.append((sender, message)))
        for key in subscriptions:
            self.session.subscribe(key)


def beat(atv: str) -> AtvHeartbeat:
    return AtvHeartbeat(
        atv=atv,
        incarnation=10_000,
        seq=1,
        at_s=0.0,
        status=AtvStatus.IDLE,
        pose=Pose(0.0, 0.0, 0.0),
        node="n1",
        speed_mps=0.0,
        battery_frac=1.0,
    )


def hum(machine: str) -> MachineHeartbeat:
    return MachineHeartbeat(machine=machine, incarnation=1, seq=1, at_s=0.0, status=MachineStatus.IDLE)


def call(coordinator: str) -> TaskAnnounced:
    work = making("pump", 1, "o-1")
    return TaskAnnounced("W1-1", 1, Role.PRIMARY, coordinator, work, 100.0)


def tell(agent: str, fact: AnyFact) -> Event:
    return Event(agent=agent, incarnation=1, number=1, at_s=0.0, fact=fact)


ON_THE_WAY = PhaseEntered("W1-1", 1, Phase.CARRYING)

ARRIVED = GoodsDelivered(goal="g-1", order="o-1", item=0, product="pump", quantity=4, delivered=4)


SAID_BY_ONESELF: Mapping[str, tuple[str, Callable[[str], Message], str, str]] = {
    "a vehicle's heartbeat": ("p/hb/atv/{}", beat, "R1", "R2"),
    "a machine's heartbeat": ("p/hb/machine/{}", hum, "W1", "W2"),
    "an announcement": ("p/goal/pump", call, "W1", "W2"),
    "a claim": ("p/dwell-point/P1", lambda atv: DwellPointClaimed("P1", atv, 0.1, standing=True), "R1", "R2"),
    "an event": ("p/event/{}", lambda agent: tell(agent, ON_THE_WAY), "R1", "R2"),
}
"""All that says who speaks: where it is said, how, and by whom or whom not."""


every_signature = pytest.mark.parametrize(
    ("key", "speak", "honest", "liar"), SAID_BY_ONESELF.values(), ids=SAID_BY_ONESELF
)


@every_signature
async def test_nobody_publishes_in_the_name_of_another(
    world: World, key: str, speak: Callable[[str], Message], honest: str, liar: str
) -> None:
    listener, true, false = Listener(world, "A", "p/**"), Listener(world, honest), Listener(world, liar)
    await world.settle()
    false.session.publish(key.format(liar), speak(honest))
    true.session.publish(key.format(honest), speak(honest))
    await world.settle()
    assert listener.heard == [(honest, speak(honest))]
    assert world.refused == {FOREIGN_NAME: 1}


@every_signature
async def test_nobody_sends_in_the_name_of_another(
    world: World, key: str, speak: Callable[[str], Message], honest: str, liar: str
) -> None:
    listener, true, false = Listener(world, "A"), Listener(world, honest), Listener(world, liar)
    await world.settle()
    false.session.send("A", speak(honest))
    true.session.send("A", speak(honest))
    await world.settle()
    assert listener.heard == [(honest, speak(honest))]
    assert world.refused == {FOREIGN_NAME: 1}


@pytest.mark.parametrize(
    ("key", "message"),
    [("p/hb/atv/R1", beat("R2")), ("p/hb/machine/R1", beat("R2")), ("p/event/R1", tell("R2", ON_THE_WAY))],
)
async def test_nobody_speaks_on_another_agents_key(world: World, key: str, message: Message) -> None:
    listener, stranger = Listener(world, "A", "p/**"), Listener(world, "R2")
    await world.settle()
    stranger.session.publish(key, message)
    await world.settle()
    assert listener.heard == []
    assert world.refused == {FOREIGN_KEY: 1}


where_kinds_are_known = pytest.mark.parametrize(
    "world", list(WHERE_KINDS_ARE_KNOWN.values()), ids=list(WHERE_KINDS_ARE_KNOWN), indirect=True
)


@where_kinds_are_known
@pytest.mark.parametrize(
    ("speaker", "key", "message", "reason"),
    [
        ("R1", "p/event/R1", tell("R1", ARRIVED), FOREIGN_FACT),
        ("W1", "p/event/W1", tell("W1", ARRIVED), FOREIGN_FACT),
        ("W1", "p/event/W1", tell("W1", ON_THE_WAY), FOREIGN_FACT),
        ("R1", "p/goal/pump", call("R1"), FOREIGN_WORD),
        ("R1", "p/k", OrderTaken(order="o-1", fulfilled=True), FOREIGN_WORD),
    ],
    ids=["goods that arrived", "a machine's too", "a vehicle's way", "an announcement", "an order's end"],
)
async def test_nobody_tells_what_another_kind_of_agent_does(
    world: World, speaker: str, key: str, message: Message, reason: str
) -> None:
    listener, stranger = Listener(world, "A", "p/**"), Listener(world, speaker)
    await world.settle()
    stranger.session.publish(key, message)
    stranger.session.send("A", message)
    await world.settle()
    assert listener.heard == []
    assert world.refused == {reason: 2}

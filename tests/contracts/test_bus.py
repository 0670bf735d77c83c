"""The conformance suite of `dray.ports.Bus`: every bus runs all of it.

A new bus is one more world: something that runs a test with a bus, and can tell when all that was said
has arrived.
"""

from __future__ import annotations

import asyncio
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Coroutine, Mapping, Sequence
from itertools import cycle
from pathlib import Path
from random import Random
from typing import Any

import pytest
from zenoh_kit import Row

from dray.adapters.security.certificates import Authority
from dray.adapters.security.identity import Identity
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
    Production,
    Role,
    TaskAnnounced,
)
from dray.messages.fact import GoodsDelivered, PhaseEntered
from dray.messages.speakers import FOREIGN_FACT, FOREIGN_KEY, FOREIGN_NAME, FOREIGN_WORD, Kind
from dray.ports import Bus, Receive, Session
from dray_sim.clock.loop import VirtualLoop, clock, paced, run
from dray_sim.faults import LinkTrouble, Partition, WlanCut
from dray_sim.network.bridge import BridgedBus, SimThread
from dray_sim.network.coverage import Coverage, Hole
from dray_sim.network.latency import WLAN
from dray_sim.network.sim_network import SimNetwork

STRATEGISTS = (
    *(
        "A",
        "B",
        "C",
        "L",
        "S",
        "T",
        "A1",
        "A2",
        "A11",
        "M1",
        "x",
        "a",
        "k",
        "y",
        "hb",
        "atv",
        "machine",
        "event",
    ),
    *(f"A{number}" for number in range(10)),
)
"""Names of agents that say here what strategists do."""

KINDS: Mapping[str, Kind] = {
    **dict.fromkeys(STRATEGISTS, Kind.STRATEGIST),
    "R1": Kind.ATV,
    "R2": Kind.ATV,
    "W1": Kind.MACHINE,
    "W2": Kind.MACHINE,
}
"""What the agents of these tests are, where anybody knows it."""

NOBODY: Mapping[str, Kind] = {}


class World(ABC):
    """A bus, and the loop on which it is used.

    Attributes:
        bus: there while `run` runs.
        refused: what nobody heard because its speaker may not say it, by reason.
    """

    bus: Bus

    @property
    @abstractmethod
    def refused(self) -> Mapping[str, int]: ...

    @abstractmethod
    def run(self, test: Coroutine[Any, Any, None]) -> None:
        """Run a test with the bus."""

    @abstractmethod
    async def settle(self) -> None:
        """Wait until all that was asked for before has taken effect, and all that was said has arrived."""


class InProcess(World):
    """The simulated network, which knows of some agents what they are."""

    def __init__(self, *, codec: bool = False, kinds: Mapping[str, Kind] = NOBODY) -> None:
        self._codec, self._kinds = codec, kinds

    @property
    def refused(self) -> Mapping[str, int]:
        assert isinstance(self.bus, SimNetwork)
        return self.bus.refused

    def run(self, test: Coroutine[Any, Any, None]) -> None:
        async def main() -> None:
            self.bus = network = SimNetwork(clock(), Random(7), codec=self._codec)
            network.kinds.update(self._kinds)
            await test

        run(main())

    async def settle(self) -> None:
        await asyncio.sleep(WLAN.cap_s)


class Ill(InProcess):
    """Faults are active, and none of them concerns the agents of the test: nothing may change for them."""

    def run(self, test: Coroutine[Any, Any, None]) -> None:
        async def main() -> None:
            network = SimNetwork(clock(), Random(7), coverage=Coverage(holes=[Hole(0.0, 0.0, 1.0)]))
            network.equip("V", lambda: Pose(0.0, 0.0, 0.0), lambda _: None)
            for fault in (WlanCut("V"), LinkTrouble(sender="V*", loss_frac=1.0), Partition((("V",),))):
                network.begin(fault)
            self.bus = network
            await test

        run(main())


class Bridged(World):
    """The agents of the test live on an ordinary loop, the network in a thread on virtual time."""

    SPEED = 1e6
    """A second in a microsecond: paced, and yet nobody waits."""

    @property
    def refused(self) -> Mapping[str, int]:
        return self._network.refused

    def run(self, test: Coroutine[Any, Any, None]) -> None:
        async def live_inside(ready: Any) -> None:
            ready(SimNetwork(clock(), Random(7)))
            await asyncio.Event().wait()

        async def main() -> None:
            thread: SimThread[SimNetwork] = SimThread(live_inside, paced(self.SPEED))
            network = self._network = thread.start(timeout_s=10.0)
            try:
                self.loop: VirtualLoop = thread.loop
                self.bus = self.bridge = BridgedBus(network, thread.loop, asyncio.get_running_loop())
                await test
            finally:
                thread.stop()

        asyncio.run(main())

    async def settle(self) -> None:
        # A marker that goes the way of all that was said before it, with the longest delay of all.
        settled = asyncio.Event()
        inside = self.loop.clock

        def come_back() -> None:
            self.bridge.outbound.order(settled.set)

        def wait_inside() -> None:
            inside.call_at(inside.now_s() + WLAN.cap_s, come_back)

        self.bridge.inbound.order(wait_inside)
        await settled.wait()


class OnZenoh(World):
    """Zenoh sessions on one computer, each with every so manyth agent; the outer ones hear one another by relay.

    So an agent that joins again under its name does so in another session, as after a restart elsewhere.
    """

    def __init__(self, count: int, identities: Sequence[Identity] = ()) -> None:
        self._count, self._identities = count, identities

    @property
    def refused(self) -> Mapping[str, int]:
        return sum((bus.refused for bus in self._row.buses), Counter[str]())

    def run(self, test: Coroutine[Any, Any, None]) -> None:
        async def main() -> None:
            self._row = Row(self._count, identities=self._identities)
            self._turns = cycle(self._row.buses)
            self.bus = self
            try:
                await test
            finally:
                self._row.close()

        asyncio.run(main())

    def join(self, agent: str, receive: Receive, life: int = 0) -> Session:
        return next(self._turns).join(agent, receive, life)

    async def settle(self) -> None:
        await self._row.settle()


class Certified(OnZenoh):
    """The same with certificates: every session may speak for every agent of the tests."""

    def __init__(self, count: int, folder: Path) -> None:
        super().__init__(count, [Identity.in_folder(folder, next(iter(KINDS)))] * count)


WORLDS: Mapping[str, Callable[[Path], World]] = {
    "in-process": lambda _: InProcess(),
    "in-process, on the wire format": lambda _: InProcess(codec=True),
    "in-process, while others suffer": lambda _: Ill(),
    "bridged": lambda _: Bridged(),
    "Zenoh, one session": lambda _: OnZenoh(1),
    "Zenoh, three sessions in a row": lambda _: OnZenoh(3),
    "Zenoh with certificates": lambda folder: Certified(3, folder),
}

WHERE_KINDS_ARE_KNOWN: Mapping[str, Callable[[Path], World]] = {
    "in-process": lambda _: InProcess(kinds=KINDS),
    "Zenoh with certificates": lambda folder: Certified(3, folder),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A certificate of the plant `p` that names all agents of the tests."""
    made = tmp_path_factory.mktemp("certificates")
    authority = Authority.make("p")
    authority.write(made)
    authority.issue(made, "p", KINDS)
    return made


@pytest.fixture(params=list(WORLDS.values()), ids=list(WORLDS))
def world(request: pytest.FixtureRequest, folder: Path) -> World:
    made: World = request.param(folder)
    return made


class Peer:
    """An agent that remembers what it has heard, as (sender, order)."""

    def __init__(self, world: World, name: str, *subscriptions: str, life: int = 0) -> None:
        self.heard: list[tuple[str, str]] = []
        self.session: Session = world.bus.join(name, self._receive, life)
        for key in subscriptions:
            self.session.subscribe(key)

    def _receive(self, sender: str, message: Message) -> None:
        assert isinstance(message, OrderTaken)
        self.heard.append((sender, message.order))


def say(order: int | str) -> OrderTaken:
    return OrderTaken(order=str(order))


# --- delivery --------------------------------------------------------------------------------------


async def test_a_publication_reaches_all_that_listen_on_its_key(world: World) -> None:
    first, second, other = Peer(world, "A", "p/k"), Peer(world, "B", "p/k"), Peer(world, "C", "p/other")
    speaker = Peer(world, "S")
    await world.settle()
    speaker.session.publish("p/k", say(1))
    await world.settle()
    assert first.heard == second.heard == [("S", "1")]
    assert other.heard == speaker.heard == []


@pytest.mark.parametrize(
    ("pattern", "key", "matches"),
    [
        ("p/hb/atv/A1", "p/hb/atv/A1", True),
        ("p/hb/atv/A1", "p/hb/atv/A11", False),
        ("p/hb/atv/A1", "p/hb/atv", False),
        ("p/event/*", "p/event/M1", True),
        ("p/event/*", "p/event/M1/x", False),
        ("p/event/*", "p/event", False),
        ("p/*/atv", "p/hb/atv", True),
        ("p/*/atv", "p/hb/machine", False),
        ("p/hb/**", "p/hb/atv/A1", True),
        ("p/hb/**", "p/hb/machine/M1", True),
        ("p/hb/**", "p/hb", True),
        ("p/hb/**", "p/hbx/atv", False),
        ("p/**/A1", "p/A1", True),
        ("p/**/A1", "p/hb/atv/A1", True),
        ("p/**/A1", "p/hb/atv/A2", False),
        ("**", "p/hb/atv/A1", True),
        ("p.q/*", "p.q/a", True),
        ("p.q/*", "pxq/a", False),
    ],
)
async def test_one_star_is_one_chunk_and_two_are_any_number(
    world: World, pattern: str, key: str, matches: bool
) -> None:
    own = key.rpartition("/")[2]  # Some keys are one agent's alone.
    listener, speaker = Peer(world, "L", pattern), Peer(world, own)
    await world.settle()
    speaker.session.publish(key, say(1))
    await world.settle()
    assert listener.heard == ([(own, "1")] if matches else [])


async def test_what_is_sent_reaches_one_agent_alone(world: World) -> None:
    receiver, eavesdropper = Peer(world, "A"), Peer(world, "B", "**", "p/agent/A")
    speaker = Peer(world, "S")
    await world.settle()
    speaker.session.send("A", say(1))
    await world.settle()
    assert receiver.heard == [("S", "1")]
    assert eavesdropper.heard == []


async def test_sending_to_an_unknown_agent_is_silence(world: World) -> None:
    speaker = Peer(world, "S")
    speaker.session.send("nobody", say(1))
    await world.settle()
    assert speaker.heard == []


async def test_an_agent_hears_itself_when_it_subscribes(world: World) -> None:
    deaf, listening = Peer(world, "A"), Peer(world, "B", "p/k")
    await world.settle()
    deaf.session.publish("p/k", say(1))
    listening.session.publish("p/k", say(2))
    await world.settle()
    assert deaf.heard == []
    assert sorted(listening.heard) == [("A", "1"), ("B", "2")]


async def test_nothing_is_received_inside_a_call(world: World) -> None:
    peer = Peer(world, "A", "p/k")
    await world.settle()
    peer.session.publish("p/k", say(1))
    peer.session.send("A", say(2))
    assert peer.heard == []
    await world.settle()
    assert len(peer.heard) == 2


async def test_a_message_arrives_as_it_was_said(world: World) -> None:
    heard: list[Message] = []
    world.bus.join("A", lambda _, message: heard.append(message))
    speaker = Peer(world, "S")
    await world.settle()
    speaker.session.send("A", say("o-7"))
    await world.settle()
    assert heard == [say("o-7")]


# --- order -----------------------------------------------------------------------------------------


async def test_publications_of_one_agent_arrive_in_the_order_said(world: World) -> None:
    listeners = [Peer(world, "A", "p/k"), Peer(world, "B", "p/*")]
    speaker = Peer(world, "S")
    await world.settle()
    for number in range(300):
        speaker.session.publish("p/k", say(number))
    await world.settle()
    for listener in listeners:
        assert listener.heard == [("S", str(number)) for number in range(300)]


async def test_what_one_agent_sends_to_another_arrives_in_the_order_said(world: World) -> None:
    receiver, speakers = Peer(world, "A"), [Peer(world, "S"), Peer(world, "T")]
    await world.settle()
    for number in range(300):
        for speaker in speakers:
            speaker.session.send("A", say(number))
    await world.settle()
    for name in ("S", "T"):
        assert [order for sender, order in receiver.heard if sender == name] == [str(n) for n in range(300)]


# --- subscriptions ---------------------------------------------------------------------------------


async def test_subscribing_twice_is_once(world: World) -> None:
    listener, speaker = Peer(world, "A", "p/k", "p/k", "p/x/*", "p/x/*"), Peer(world, "S")
    await world.settle()
    speaker.session.publish("p/k", say(1))
    speaker.session.publish("p/x/y", say(2))
    await world.settle()
    assert sorted(listener.heard) == [("S", "1"), ("S", "2")]
    listener.session.unsubscribe("p/k")
    await world.settle()
    speaker.session.publish("p/k", say(3))
    await world.settle()
    assert len(listener.heard) == 2


async def test_a_subscription_begins_when_it_is_made(world: World) -> None:
    listener, speaker = Peer(world, "A"), Peer(world, "S")
    speaker.session.publish("p/k", say(1))
    await world.settle()
    listener.session.subscribe("p/k")
    await world.settle()
    speaker.session.publish("p/k", say(2))
    await world.settle()
    assert listener.heard == [("S", "2")]


@pytest.mark.parametrize("pattern", ["p/k", "p/*", "**"])
async def test_an_unsubscribed_agent_hears_it_no_longer(world: World, pattern: str) -> None:
    leaving, staying, speaker = Peer(world, "A", pattern), Peer(world, "B", pattern), Peer(world, "S")
    await world.settle()
    speaker.session.publish("p/k", say(1))
    await world.settle()
    leaving.session.unsubscribe(pattern)
    leaving.session.unsubscribe("p/never/subscribed")
    await world.settle()
    speaker.session.publish("p/k", say(2))
    await world.settle()
    assert leaving.heard == [("S", "1")]
    assert staying.heard == [("S", "1"), ("S", "2")]


# --- coming and going ------------------------------------------------------------------------------


async def test_nothing_is_received_after_leaving_not_even_what_is_under_way(world: World) -> None:
    leaving, staying, speaker = Peer(world, "A", "p/k"), Peer(world, "B", "p/k"), Peer(world, "S")
    await world.settle()
    speaker.session.publish("p/k", say(1))
    speaker.session.send("A", say(2))
    leaving.session.leave()
    await world.settle()
    speaker.session.send("A", say(3))
    await world.settle()
    assert leaving.heard == []
    assert staying.heard == [("S", "1")]


async def test_who_has_left_says_nothing_any_more_and_may_leave_twice(world: World) -> None:
    listener, leaving = Peer(world, "A", "p/k"), Peer(world, "S")
    await world.settle()
    leaving.session.leave()
    leaving.session.leave()
    leaving.session.publish("p/k", say(1))
    leaving.session.send("A", say(2))
    leaving.session.subscribe("p/k")
    leaving.session.unsubscribe("p/k")
    await world.settle()
    assert listener.heard == leaving.heard == []


async def test_a_later_life_replaces_an_earlier_one(world: World) -> None:
    before, speaker = Peer(world, "A", "p/k", life=1), Peer(world, "S")
    await world.settle()
    after = Peer(world, "A", life=2)
    await world.settle()
    speaker.session.send("A", say(1))
    speaker.session.publish("p/k", say(2))
    await world.settle()
    assert before.heard == []
    assert after.heard == [("S", "1")]


async def test_an_earlier_life_that_joins_late_is_nobody(world: World) -> None:
    late, speaker = Peer(world, "A", life=2), Peer(world, "S")
    await world.settle()
    early = Peer(world, "A", "p/k", life=1)
    await world.settle()
    early.session.send("S", say("of the dead"))
    speaker.session.send("A", say(1))
    speaker.session.publish("p/k", say(2))
    await world.settle()
    assert early.heard == speaker.heard == []
    assert late.heard == [("S", "1")]


async def test_the_end_of_a_replaced_session_does_not_touch_its_successor(world: World) -> None:
    before, speaker = Peer(world, "A", life=1), Peer(world, "S")
    after = Peer(world, "A", "p/k", life=2)
    before.session.leave()
    await world.settle()
    speaker.session.send("A", say(1))
    speaker.session.publish("p/k", say(2))
    await world.settle()
    assert before.heard == []
    assert sorted(after.heard) == [("S", "1"), ("S", "2")]


async def test_many_agents_may_come_and_go(world: World) -> None:
    speaker = Peer(world, "S")
    for round_number in range(20):
        peers = [Peer(world, f"A{number}", "p/k", life=round_number + 1) for number in range(10)]
        await world.settle()
        speaker.session.publish("p/k", say(round_number))
        await world.settle()
        assert all(peer.heard == [("S", str(round_number))] for peer in peers)
        for peer in peers[::2]:
            peer.session.leave()


# --- who may say what ------------------------------------------------------------------------------


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
    work = Production(product="pump", quantity=1, order="o-1", item=0)
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

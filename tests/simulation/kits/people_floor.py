"""An operator on a floor with one vehicle that says what the test lets it say."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from random import Random

from dray.adapters.security.signing import SigningKey
from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    Brief,
    CommandAnswered,
    CommandKind,
    HelpWanted,
    Link,
    Message,
    Pose,
    VehicleCommand,
)
from dray.plant import load_plant
from dray_sim.clock.loop import clock, run
from dray_sim.network.sim_network import SimNetwork
from dray_sim.people.habits import Habits
from dray_sim.people.operators import Operator

PLANT = load_plant("single-track")

AUTHORITY = SigningKey(bytes(32))


QUICK = Habits(
    react_s=(1.0, 1.0),
    walk_s=(10.0, 10.0),
    mend_s=(20.0, 20.0),
    carry_s=(5.0, 5.0),
    push_s=(5.0, 5.0),
    estimate=(1.0, 1.0),
    slow_frac=1.0,
)
"""Nothing of chance."""


NORTH, SOUTH = Pose(x_m=30.0, y_m=30.0, heading_rad=0.0), Pose(x_m=30.0, y_m=2.0, heading_rad=0.0)


class Puppet:
    """A vehicle that says what the test wants, beats once a second, and answers as it is told.

    Attributes:
        status, problem, help, pose, task, link: for the heartbeats.
        silent: says nothing at all.
        deaf: so many of the next commands are not heard.
        refuses: kinds that are refused.
        heard: every command that reached it, repeated ones too, with the time.
        obeyed: who gave those that were done, and their kinds.
    """

    def __init__(self, bus: SimNetwork, atv: str = "ATV1") -> None:
        self.atv = atv
        self.status, self.problem, self.pose = AtvStatus.WORKING, "", NORTH
        self.help: HelpWanted | None = None
        self.task: Brief | None = None
        self.link = Link.WLAN
        self.silent, self.deaf = False, 0
        self.refuses: set[CommandKind] = set()
        self.heard: list[tuple[float, VehicleCommand]] = []
        self.obeyed: list[tuple[str, CommandKind]] = []
        self._session = bus.join(atv, self._on_message)

    @property
    def kinds(self) -> list[CommandKind]:
        """What was asked, each command once."""
        return [command.kind for command in {command.command: command for _, command in self.heard}.values()]

    async def run(self) -> None:
        seq = 0
        while True:
            seq += 1
            if not self.silent:
                self._session.publish(f"{PLANT.id}/hb/atv/{self.atv}", self._heartbeat(seq))
            await asyncio.sleep(1.0)

    def _heartbeat(self, seq: int) -> AtvHeartbeat:
        return AtvHeartbeat(
            atv=self.atv,
            incarnation=1,
            seq=seq,
            at_s=clock().now_s(),
            status=self.status,
            pose=self.pose,
            node="n1",
            speed_mps=0.0,
            battery_frac=0.5,
            task=self.task,
            link=self.link,
            problem=self.problem,
            help=self.help,
        )

    def _on_message(self, sender: str, message: Message) -> None:
        if not isinstance(message, VehicleCommand) or self.silent:
            return
        self.heard.append((clock().now_s(), message))
        if self.deaf > 0:
            self.deaf -= 1
            return
        done = message.kind not in self.refuses and self._is_covered(message)
        if done:
            self.obeyed.append((sender, message.kind))
        if done and message.kind is CommandKind.STOP:
            self.status = AtvStatus.STOPPED
        elif done and message.kind is CommandKind.RESUME:
            self.status = AtvStatus.WORKING
        self._session.send(sender, CommandAnswered(command=message.command, done=done))

    def _is_covered(self, command: VehicleCommand) -> bool:
        near = PLANT.areas_near(self.pose.x_m, self.pose.y_m, command.kind.margin_m)
        return command.grant is not None and not set(near).isdisjoint(command.grant.areas)


class FakeHands:
    """Notes what is done, and when."""

    def __init__(self, puppet: Puppet) -> None:
        self.puppet = puppet
        self.off = False
        self.can_plug_in = True
        self.load = ("", 0)
        self.deeds: list[tuple[str, float]] = []
        self.put: tuple[object, ...] = ()

    def problem(self, _atv: str) -> str:
        return self.puppet.problem

    def is_off(self, _atv: str) -> bool:
        return self.off

    def mend(self, _atv: str) -> None:
        self._note("mend")
        self.puppet.problem, self.puppet.help = "", None
        if self.puppet.status is AtvStatus.ERROR:
            self.puppet.status = AtvStatus.WORKING

    def plug_in(self, _atv: str) -> bool:
        self._note("plug in")
        if self.can_plug_in:
            self.puppet.link = Link.WLAN
        return self.can_plug_in

    def unload(self, _atv: str) -> tuple[str, int]:
        self._note("unload")
        return self.load

    def put_down(self, *load: object) -> str:
        self._note("put down")
        self.put = load
        return "S1"

    def bring_home(self, _atv: str) -> str:
        self._note("bring home")
        self.off = self.puppet.silent = False
        return "CH1"

    def _note(self, deed: str) -> None:
        self.deeds.append((deed, clock().now_s()))


class Floor:
    """One operator and one puppet, and what happens between them."""

    def __init__(self, habits: Habits, area: str = "AREA1", seed: int = 1) -> None:
        self.bus = bus = SimNetwork(clock(), Random(seed))
        self.puppet = Puppet(bus)
        self.hands = FakeHands(self.puppet)
        self.operator = Operator(
            area,
            plant=PLANT,
            bus=bus,
            clock=clock(),
            authority=AUTHORITY,
            hands=self.hands,
            random=Random(seed),
            habits=habits,
        )

    @property
    def deeds(self) -> list[str]:
        return [deed for deed, _ in self.hands.deeds]


Story = Callable[[Floor], Coroutine[object, object, None]]


def play(story: Story, habits: Habits = QUICK, area: str = "AREA1", seed: int = 1) -> Floor:
    """Let a story happen while operator and puppet live."""

    async def main() -> Floor:
        floor = Floor(habits, area, seed)
        lives = [asyncio.create_task(floor.puppet.run()), asyncio.create_task(floor.operator.run())]
        await story(floor)
        for life in lives:
            life.cancel()
        await asyncio.gather(*lives, return_exceptions=True)
        return floor

    return run(main())


async def until(true: Callable[[], bool]) -> None:
    """Go on when something is so; looked at once a second of virtual time."""
    while not true():  # noqa: ASYNC110 (nobody tells)
        await asyncio.sleep(1.0)


def trouble(problem: str, *, waits_s: float | None = None, for_s: float = 300.0) -> Story:
    """A vehicle has a problem."""

    async def story(floor: Floor) -> None:
        floor.puppet.status, floor.puppet.problem = AtvStatus.ERROR, problem
        if waits_s is not None:
            floor.puppet.help = HelpWanted(until_s=clock().now_s() + waits_s)
        await asyncio.sleep(for_s)

    return story

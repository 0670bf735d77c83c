"""A driver and a vehicle in the yard, joined by a link that can lose, double, delay and spoil; time jumps."""

from __future__ import annotations

import json
from typing import Any, TypeVar

import msgspec
from yard import LIGHT, Yard

from dray.adapters.vda5050.body import Address, VehicleBody
from dray.adapters.vda5050.control.master import MasterControl
from dray.adapters.vda5050.events import Memory
from dray.adapters.vda5050.profile import ActionUse, MapFrame, Profile
from dray.body import ActionFailed, Instruction, NodePassed, ProblemRaised, Report
from dray_sim.vda5050.fleet import LoudFailures
from dray_sim.vda5050.misbehaviour import Misbehaviour
from dray_sim.vda5050.own_map import OwnMap
from dray_sim.vda5050.vehicle import Vda5050Vehicle
from dray_sim.vda5050.words import Words

R = TypeVar("R", bound=Report)

ADDRESS = Address("Yard", "4711")

PROFILE = Profile(
    version="2.1",
    pick=ActionUse(
        "pick", parameters={"stationName": "{station}", "loadType": "{item}", "quantity": "{quantity}"}
    ),
    drop=ActionUse("drop", parameters={"stationName": "{station}", "goal": "{goal}"}),
    charge=ActionUse("startCharging", parameters={"stationName": "{station}"}),
    map=MapFrame("hall"),
)

FLOWING = msgspec.structs.replace(PROFILE, updates=True, base_m=12.0)


class Rig:
    """One vehicle, one driver.

    Attributes:
        heard: what the driver has reported, over all its lives.
        wire: every message: when, who (`us` or `it`), topic, JSON.
        memory: what the driver has written down.
        notes: what it has told people.
    """

    def __init__(
        self,
        profile: Profile = PROFILE,
        quirks: Misbehaviour | None = None,
        *,
        node: str = "west",
        battery_frac: float = 0.9,
        delay_s: float = 0.05,
        linked: bool = True,
        yard: Yard | None = None,
        own_map: OwnMap | None = None,
    ) -> None:
        self.yard = yard or Yard()
        self.clock = self.yard.clock
        self.profile, self.delay_s = profile, delay_s
        self.heard: list[Report] = []
        self.wire: list[tuple[float, str, str, dict[str, Any]]] = []
        self.memory = Memory()
        self.notes: list[str] = []
        self.retained: dict[str, bytes] = {}
        self.is_up = True
        """The link."""
        self.lives = 0
        self.body: VehicleBody
        self.sim = self.yard.vehicle(node, battery_frac)
        words = Words(profile.version, ADDRESS.manufacturer, ADDRESS.serial, "hall", quirks or Misbehaviour())
        self.begin_life(linked=False)
        self.vehicle = Vda5050Vehicle(
            self.sim,
            LIGHT,
            lambda node: {"east": "CH1", "corner": "CH2"}.get(node, ""),
            self.clock,
            self.tell,
            words,
            self.yard.plant.corners,
            own_map,
        )
        if linked:
            self.link()

    # --- the driver ---

    def begin_life(self, *, linked: bool = True) -> None:
        """A new life of the agent, with a driver that knows what was written down."""
        if self.lives:
            self.body.end()
        self.lives += 1
        control = MasterControl(
            "ATV1", self.yard.plant, LIGHT, self.profile, life=self.lives, memory=self.memory
        )
        self.body = VehicleBody(control, self.profile, ADDRESS, self.clock, self)
        self.body.failures = LoudFailures("ATV1")
        self.body.attach(self.heard.append)
        if linked:
            self.link()

    def link(self) -> None:
        """The broker is there; what it has kept is told first."""
        self.is_up = True
        self.body.on_link()
        for topic, data in self.retained.items():
            self.body.on_message(topic, data)

    def cut(self) -> None:
        """The broker is away."""
        self.is_up = False
        self.body.on_link_lost("refused")

    def publish(self, topic: str, data: bytes) -> None:
        said = json.loads(data)
        self.wire.append((self.clock.now_s(), "us", topic, said))
        if self.is_up:
            self.clock.call_at(
                self.clock.now_s() + self.delay_s, lambda: self.vehicle.on_message(topic, data)
            )

    def remember(self, memory: Memory) -> None:
        self.memory = msgspec.json.decode(msgspec.json.encode(memory), type=Memory)

    def note(self, text: str) -> None:
        self.notes.append(text)

    # --- the vehicle ---

    def tell(self, topic: str, data: bytes, retain: bool) -> None:
        self.wire.append((self.clock.now_s(), "it", topic, json.loads(data)))
        if retain:
            self.retained[topic] = data
        if self.is_up and hasattr(self, "vehicle"):
            self.clock.call_at(self.clock.now_s() + self.delay_s, lambda: self.give(topic, data))

    def give(self, topic: str, data: bytes) -> None:
        """What comes to the driver now."""
        self.body.on_message(topic, data)

    # --- what is done and seen ---

    def do(self, *instructions: Instruction, for_s: float = 0.0) -> list[Report]:
        """Instruct one after the other, let time pass; what was reported meanwhile."""
        if not self.body.control.is_known:
            self.run(1.0)
        count = len(self.heard)
        for instruction in instructions:
            self.body.instruct(instruction)
        self.run(for_s)
        return self.heard[count:]

    def run(self, for_s: float) -> None:
        self.yard.run(self.clock.now_s() + for_s)

    def said(self, topic: str, who: str = "us") -> list[dict[str, Any]]:
        """Every message of one side on one topic."""
        return [said for _, speaker, about, said in self.wire if speaker == who and about == topic]

    def instant(self, kind: str) -> list[dict[str, Any]]:
        """Every instant action of this kind that was said, again and again included."""
        return [
            action
            for said in self.said("instantActions")
            for action in said["actions"]
            if action["actionType"] == kind
        ]

    def orders(self) -> list[dict[str, Any]]:
        """What was ordered, each order and update once."""
        found: dict[tuple[str, int], dict[str, Any]] = {}
        for said in self.said("order"):
            found.setdefault((said["orderId"], said["orderUpdateId"]), said)
        return list(found.values())

    def of(self, kind: type[R]) -> list[R]:
        """What was reported of one kind."""
        return [report for report in self.heard if isinstance(report, kind)]

    def passed(self) -> list[tuple[str, int]]:
        return [(report.node, report.index) for report in self.of(NodePassed)]

    def problems(self) -> list[str]:
        return [report.reason for report in self.of(ProblemRaised)]

    def failures(self) -> list[str]:
        return [report.reason for report in self.of(ActionFailed)]

"""A world that writes down which faults were done to it, for tests."""

from __future__ import annotations

from msgspec.structs import replace

from dray.messages import NOTHING_KNOWN, Problem
from dray.plant import Door, LaneEnds, Plant, default_plant
from dray_sim.clock.loop import VirtualClock
from dray_sim.faults import (
    AccessPointDown,
    ClockSet,
    CoverageHole,
    Crashed,
    DoorFailed,
    Fault,
    JournalLost,
    LaneBlocked,
    LinkTrouble,
    LoadDropped,
    LoadShifted,
    MachineBroken,
    NetworkFault,
    Partition,
    PoweredOff,
    RadioCut,
    SentAway,
    Thing,
    VehicleBroken,
    WlanCut,
    kind_of,
)

GATE = Door("GATE", "Gate", (LaneEnds("c2", "c3"),), 5.0)

PLANT = Plant(replace(default_plant().file, doors=(GATE,)))

LANE = max((lane.length_m, lane.start, lane.end) for lane in PLANT.roads.lanes)[1:]
"""The longest one: there is room for something between whoever stands at its ends."""

ONE_OF_EACH: tuple[Fault, ...] = (
    WlanCut("ATV1"),
    RadioCut("ATV2"),
    LinkTrouble(sender="ATV*", receiver="M1", latency_s=0.5, jitter_s=0.1, loss_frac=0.2),
    Partition((("M1", "ATV*"), ("M2",))),
    CoverageHole(x_m=1.5, y_m=2.0, radius_m=3.0),
    AccessPointDown("AP1"),
    PoweredOff("ATV3"),
    Crashed("strategist"),
    JournalLost("M6"),
    ClockSet("ATV6", by_s=-5.0),
    SentAway("M5", probation=2),
    MachineBroken("M4", "no oil"),
    VehicleBroken("ATV4"),
    LaneBlocked(*LANE, Thing.PERSON),
    DoorFailed("GATE"),
    LoadDropped("ATV5"),
    LoadShifted("ATV5"),
)


class Body:
    def __init__(self, world: FakeWorld, name: str) -> None:
        self._world, self._name = world, name
        self.loaded = True

    def break_down(self, reason: str, problem: Problem = NOTHING_KNOWN) -> None:
        self._world.done.append(f"break {self._name}: {reason}")

    def repair(self) -> None:
        self._world.done.append(f"repair {self._name}")

    def shift_load(self) -> bool:
        if self.loaded:
            self._world.done.append(f"shift {self._name}")
        return self.loaded


class FakeWorld:
    """Notes what is done to it."""

    access_points = ("AP1",)
    lanes = frozenset({LANE})
    states = dict.fromkeys(("GATE",), "shut")

    def __init__(self) -> None:
        self.done: list[str] = []
        self.clock = VirtualClock()
        self.bus = self
        self.floor = self.doors = self
        self.vehicles = {name: Body(self, name) for name in ("ATV1", "ATV2")}
        self.workcells = {name: Body(self, name) for name in ("M1", "M2")}
        self.workers = dict.fromkeys((*self.workcells, *self.vehicles, "strategist"))
        self.dead: set[str] = set()
        self.off: set[str] = set()

    def begin(self, fault: NetworkFault) -> None:
        self.done.append(f"begin {kind_of(fault)}")

    def end(self, fault: NetworkFault) -> None:
        self.done.append(f"end {kind_of(fault)}")

    def obstruct(self, lane: tuple[str, str], thing: str) -> bool:
        self.done.append(f"{thing} from {lane[0]} to {lane[1]}")
        return self.done.count(self.done[-1]) == 1

    def drop_load(self, atv: str) -> bool:
        if self.vehicles[atv].loaded:
            self.done.append(f"drop the load of {atv}")
        return self.vehicles[atv].loaded

    def fail(self, door: str) -> None:
        self.done.append(f"fail {door}")

    def repair(self, door: str) -> None:
        self.done.append(f"repair {door}")

    def clear(self, lane: tuple[str, str]) -> None:
        self.done.append(f"clear from {lane[0]} to {lane[1]}")

    def running(self, agent: str) -> bool:
        return agent not in self.dead

    def power_off(self, agent: str) -> None:
        self.dead.add(agent)
        self.off.add(agent)
        self.done.append(f"off {agent}")

    def power_on(self, agent: str) -> None:
        if agent in self.off:
            self.off.discard(agent)
            self.dead.discard(agent)
            self.done.append(f"on {agent}")

    def crash(self, agent: str) -> None:
        self.dead.add(agent)
        self.done.append(f"crash {agent}")

    def lose_journal(self, agent: str) -> None:
        self.dead.add(agent)
        self.done.append(f"lose {agent}'s journal")

    def set_clock(self, agent: str, by_s: float) -> None:
        self.done.append(f"set {agent}'s clock by {by_s:g} s")

    def ask_to_leave(self, agent: str) -> None:
        self.dead.add(agent)
        self.done.append(f"send {agent} away")

    def restart(self, agent: str, *, probation: int = 0) -> None:
        if agent not in self.off:
            self.dead.discard(agent)
            self.done.append(f"restart {agent}" + (f" on probation for {probation}" if probation else ""))

    def pass_time(self, until_s: float) -> None:
        while self.clock.heap and self.clock.heap[0][0] <= until_s:
            when_s, _, call, args = self.clock.heap.pop(0)
            self.clock.heap.sort(key=lambda entry: entry[:2])
            self.clock.time_s = when_s
            call(*args)
        self.clock.time_s = until_s

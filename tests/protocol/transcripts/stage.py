"""A stage for transcripts: real agents, scripted bodies, every message 10 ms under way.

There is no asyncio and no chance here: agents are called as plain functions in the order of time, and
what they say to one another is written down line by line.
"""

from __future__ import annotations

import heapq
from itertools import count
from pathlib import Path
from typing import Any

import msgspec
import plentiful
from vehicle_states import standing

from dray.body import (
    ActionDone,
    BodyState,
    Drive,
    Drop,
    NodePassed,
    Pick,
    Report,
    StockChanged,
    VehicleState,
    WayDone,
    WorkcellState,
)
from dray.messages import AtvHeartbeat, Message
from dray.plant import Plant, load_plant
from dray.protocol.machine.machine import Machine
from dray.protocol.runtime.events import (
    Agent,
    Event,
    Instruct,
    Leave,
    Leaving,
    Publish,
    Received,
    Record,
    Reported,
    Send,
    Started,
    Subscribe,
    Unsubscribe,
    Woke,
)
from dray.protocol.vehicle.atv import Atv

LATENCY_S = 0.010

SHOWN = ("role", "epoch", "round", "radius_m", "source", "reason", "station", "quantity")
"""The fields that a transcript shows, where a message has them."""


class ScriptedVehicle:
    """Drives at the plant's own estimates and never fails."""

    def __init__(self, stage: Stage, atv: str, vehicle_type: str, node: str, battery_frac: float) -> None:
        self._stage = stage
        self._atv = atv
        self._type = stage.plant.vehicle_types[vehicle_type]
        self._routes = stage.plant.routes(vehicle_type)
        self._node = node
        self._goal = node
        self._arrives_s = 0.0
        self._way = 0
        """The number of the newest one."""
        self._battery_frac = battery_frac
        self._load = ("", 0)

    def forgets(self, report: Report) -> bool:
        """Whether it was sent elsewhere since, and does not come to this."""
        return isinstance(report, NodePassed | WayDone) and report.order != self._way

    def sense(self) -> VehicleState:
        self._move()
        return standing(
            self._stage.plant,
            self._node,
            battery_frac=self._battery_frac,
            load=self._load[0],
            load_quantity=self._load[1],
        )

    def instruct(self, instruction: object) -> None:
        if isinstance(instruction, Drive):
            self._move()
            goal = instruction.nodes[-1]
            took_s = self._routes.duration_s(self._node, goal)
            self._goal, self._arrives_s, self._way = goal, self._stage.now_s + took_s, instruction.order
            last = len(instruction.nodes) - 1
            passed = NodePassed(
                order=instruction.order, node=goal, index=last, battery_frac=self._battery_frac
            )
            self._stage.report(self._atv, took_s, passed)
            self._stage.report(self._atv, took_s, WayDone(order=instruction.order, node=goal))
        elif isinstance(instruction, Pick):
            self._load = (instruction.item, instruction.quantity)
            self._stage.report(self._atv, self._type.load_s, ActionDone(order=instruction.order))
        elif isinstance(instruction, Drop):
            item, quantity = self._load
            self._load = ("", 0)
            arrived = StockChanged(item=item, change=quantity, seq=0, vehicle=self._atv)
            self._stage.report(instruction.station, self._type.unload_s, arrived)
            self._stage.report(self._atv, self._type.unload_s, ActionDone(order=instruction.order))

    def _move(self) -> None:
        if self._stage.now_s >= self._arrives_s:
            self._node = self._goal


class ScriptedWorkcell:
    """Has a stock and never finishes a cycle."""

    def __init__(self, stock: dict[str, int]) -> None:
        self.stock = stock
        self._seq = 0

    def sense(self) -> WorkcellState:
        return WorkcellState(stock=dict(self.stock), seq=self._seq, cycling="", broken="")

    def count(self, report: StockChanged) -> StockChanged:
        """Let a change of the stock happen; its report, numbered."""
        self.stock[report.item] += report.change
        self._seq += 1
        return msgspec.structs.replace(report, seq=self._seq)

    def instruct(self, instruction: object) -> None:
        """Cycles and docks need nothing here."""

    def forgets(self, _report: Report) -> bool:
        return False


class Stage:
    """Agents on one plant, and the transcript of what they say."""

    def __init__(self, plant: Plant) -> None:
        self.plant = plant
        self.now_s = 0.0
        self.lines: list[str] = []
        self.facts: list[tuple[str, object]] = []
        self._agents: dict[str, Agent] = {}
        self._bodies: dict[str, Any] = {}
        self._listeners: dict[str, dict[str, None]] = {}
        self._numbers = count()
        self._heap: list[tuple[float, int, str, Event]] = []
        self._wake_s: dict[str, float] = {}
        self._phases: dict[str, str] = {}
        self._voices: dict[int, str] = {}

    def add(self, agent: Agent, body: Any) -> None:
        """Put an agent on the stage; it starts now."""
        self._agents[agent.id] = agent
        self._bodies[agent.id] = body
        self._act(agent.id, Started(self._sense(agent.id)))

    def say(self, sender: str, to: str, message: Message, *, at_s: float) -> None:
        """Let somebody who is not on the stage say something; it is heard at once."""
        number = next(self._numbers)
        self._voices[number] = sender
        heapq.heappush(self._heap, (at_s, number, to, Received(sender, message)))

    def ask_to_leave(self, agent: str, *, at_s: float) -> None:
        """Let an agent shut down gracefully."""
        heapq.heappush(self._heap, (at_s, next(self._numbers), agent, Leaving()))

    def report(self, agent: str, after_s: float, report: Report) -> None:
        if agent in self._agents:
            if isinstance(report, StockChanged):
                report = self._bodies[agent].count(report)
            self._later(self.now_s + after_s, agent, Reported(report))

    def run(self, until_s: float) -> None:
        """Play on until a moment."""
        while self._heap and self._heap[0][0] <= until_s:
            self.now_s, number, agent, event = heapq.heappop(self._heap)
            if agent not in self._agents:
                continue
            if isinstance(event, Reported) and self._bodies[agent].forgets(event.report):
                continue
            if type(event) is Leaving:
                self.lines.append(f"{self.now_s:8.3f}  {agent:>5} is asked to leave")
            if number in self._voices and isinstance(event, Received):
                self._write(self._voices.pop(number), agent, event.message)
            if type(event) is Woke:
                if self._wake_s.get(agent) != self.now_s:
                    continue
                event = Woke(self._sense(agent))
            self._act(agent, event)

    def _sense(self, agent: str) -> BodyState | None:
        body = self._bodies[agent]
        return None if body is None else body.sense()

    def _act(self, agent: str, event: Event) -> None:
        for effect in self._agents[agent].handle(event, self.now_s):
            if isinstance(effect, Publish):
                listeners = self._listeners.get(effect.key, {})
                self._write(agent, "*", effect.message)
                for listener in listeners:
                    self._later(self.now_s + LATENCY_S, listener, Received(agent, effect.message))
            elif isinstance(effect, Send):
                self._send(agent, effect)
            elif isinstance(effect, Subscribe):
                self._listeners.setdefault(effect.key, {})[agent] = None
            elif isinstance(effect, Unsubscribe):
                self._listeners.get(effect.key, {}).pop(agent, None)
            elif isinstance(effect, Instruct):
                self._bodies[agent].instruct(effect.instruction)
            elif isinstance(effect, Record):
                self.facts.append((agent, effect.fact))
            elif isinstance(effect, Leave):
                self._let_go(agent)
                return
        wake_s = self._agents[agent].wake_at_s
        if wake_s < float("inf"):
            wake_s = max(wake_s, self.now_s)
            self._wake_s[agent] = wake_s
            self._later(wake_s, agent, Woke(None))

    def _send(self, agent: str, effect: Send) -> None:
        self._write(agent, effect.to, effect.message)
        said = plentiful.answer(effect.to, effect.message)
        if said is not None:
            self.say(effect.to, agent, said, at_s=self.now_s + 2 * LATENCY_S)
        if effect.to in self._agents:
            self._later(self.now_s + LATENCY_S, effect.to, Received(agent, effect.message))

    def _let_go(self, agent: str) -> None:
        self.lines.append(f"{self.now_s:8.3f}  {agent:>5} leaves")
        del self._agents[agent]
        for listeners in self._listeners.values():
            listeners.pop(agent, None)

    def _later(self, at_s: float, agent: str, event: Event) -> None:
        heapq.heappush(self._heap, (at_s, next(self._numbers), agent, event))

    def _write(self, sender: str, to: str, message: Message) -> None:
        name = type(message).__name__
        if name in ("MachineHeartbeat", "DwellPointClaimed"):
            return
        if isinstance(message, AtvHeartbeat):
            # A heartbeat is worth a line only where it tells something new of a contract.
            told = f"{message.status.value}"
            if message.task is not None and message.task.phase is not None:
                told += f" {message.task.task} {message.task.phase.value}"
            told += "".join(f", watches {brief.task}" for brief in message.watches)
            if self._phases.get(sender, "idle") == told:
                return
            self._phases[sender] = told
            self.lines.append(f"{self.now_s:8.3f}  {sender:>5} -> *      RHB {told}")
            return
        fields = msgspec.structs.asdict(message)
        shown = [str(fields.get("task", ""))]
        shown += [f"{name}={_short(fields[name])}" for name in SHOWN if fields.get(name) not in (None, "")]
        if name == "Bid":
            shown.append(f"cost={message.cost.total_s:.1f}s")  # type: ignore[attr-defined]
        line = f"{self.now_s:8.3f}  {sender:>5} -> {to:<6} {name} {' '.join(shown)}".rstrip()
        if self.lines[-1:] != [line]:  # One announcement goes to several grid cells.
            self.lines.append(line)


def without_shafts(**places: str) -> Stage:
    """The default plant with M8, which lacks shafts, and light vehicles.

    Args:
        places: the node at which each vehicle stands.
    """
    stage = Stage(load_plant("single-track"))
    for atv, node in places.items():
        vehicle = ScriptedVehicle(stage, atv, "light", node, battery_frac=0.9)
        stage.add(Atv(atv, stage.plant, vehicle_type="light"), vehicle)
    stock = {"housing": 72, "shaft": 0, "bearing": 120, "impeller": 90, "seal-kit": 120}
    stage.add(Machine("M8", stage.plant), ScriptedWorkcell(stock))
    return stage


def rewritten(golden: Path, stage: Stage) -> str:
    """A golden file as it would be now: its own prose, and what was said on the stage."""
    prose, _, _ = golden.read_text(encoding="utf-8").partition("\n\n")
    return prose + "\n\n" + "\n".join(stage.lines) + "\n"


def _short(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(getattr(value, "value", value))

"""A small world: a few agents with plain bodies, and a network that does what it likes.

Time goes from event to event; there is no asyncio. What an agent says is under way for as long as the
network wants, is lost or doubled, and never reaches whoever is down or cut off. After every effect and
every transfer the world is checked against the invariants of the protocol, as far as they can be seen here:

1. a task that was opened is still open, or was closed once;
2. a task is handed over once, by one carrier; what was picked up is on board or was put down somewhere;
3. a vehicle is primary of one task at most;
5. a stopped vehicle stands until somebody has acknowledged and then resumed;
8. no agent ends by an exception, and none spins.
"""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Callable
from functools import partial
from itertools import count
from random import Random

from actors import Actor
from bodies import PlainGate, PlainVehicle, PlainWorkcell
from defaults import PLANT
from seals import granted, trusts_seals
from world_checks import Checks
from world_network import Network

from dray.body import Drop, LinkNoticed, Pick
from dray.messages import (
    CommandKind,
    Link,
    Message,
    OrderItem,
    OrderReleased,
    VehicleCommand,
)
from dray.messages.keys import STRATEGIST
from dray.protocol.machine.machine import Machine
from dray.protocol.runtime.events import (
    Effect,
    Instruct,
    Leave,
    Publish,
    Record,
    Send,
    Subscribe,
    Unsubscribe,
)
from dray.protocol.strategist.strategist import Strategist
from dray.protocol.vehicle.atv import Atv


class World:
    """Machine M7 and its vehicles, with the strategist that gives it work.

    Args:
        seed: of the network's chance.
        nodes: where the vehicles stand at the beginning, by their ids.
    """

    def __init__(self, seed: int, nodes: dict[str, str]) -> None:
        self.now_s = 0.0
        self.network = Network(Random(seed))
        self.actors: dict[str, Actor] = {}
        self.vehicles: dict[str, PlainVehicle] = {}
        self.workcell = PlainWorkcell("M7", PLANT)
        self.gate = PlainGate()
        self.log: list[str] = []
        self.broken = False
        """An invariant does not hold: what follows tells nothing."""
        self.failing = Counter[str]()
        """Transfers that fail next, by vehicle."""
        self._listeners: dict[str, dict[str, None]] = {}
        self._numbers = count()
        self._under_way: list[tuple[float, int, str, str, Message]] = []
        self._checks = Checks(self)
        self._add("M7", lambda life: Machine("M7", PLANT, incarnation=life), self.workcell)
        for atv, node in nodes.items():
            self.vehicles[atv] = PlainVehicle(atv, PLANT, node, self._transfer)
            create = partial(_vehicle, atv)
            self._add(atv, create, self.vehicles[atv])
        self._add(STRATEGIST, lambda life: Strategist(PLANT, incarnation=life), self.gate)

    # --- what a test does ---

    def order(self, order: str, product: str, quantity: int) -> None:
        """Somebody orders something."""
        items = (OrderItem(product=product, quantity=quantity),)
        self.say("gateway", STRATEGIST, OrderReleased(order=order, items=items, due_s=self.now_s + 3600.0))

    def command(self, atv: str, kind: CommandKind) -> None:
        """A person tells a vehicle something; the way to it is as good as the network."""
        command = f"c{next(self._numbers)}"
        self.say("operator", atv, granted(atv, VehicleCommand(command=command, kind=kind)))

    def say(self, sender: str, to: str, message: Message) -> None:
        """Somebody says something to an agent."""
        for delay_s in self.network.delays_s(sender, to):
            heapq.heappush(self._under_way, (self.now_s + delay_s, next(self._numbers), sender, to, message))

    def crash(self, agent: str) -> None:
        """Its software ends; its body goes on."""
        self._note(f"{agent} crashes")
        self.actors[agent].crash()
        self._forget_listener(agent)

    def leave(self, agent: str) -> None:
        """Its software is asked to leave, and ends in its own time."""
        self._note(f"{agent} is asked to leave")
        self.actors[agent].leave(self.now_s)

    def power_off(self, atv: str) -> None:
        """A vehicle is switched off, its software too."""
        self.crash(atv)
        self.vehicles[atv].stand_still()

    def start(self, agent: str) -> None:
        """It lives again."""
        self._note(f"{agent} starts")
        self.actors[agent].start(self.now_s)

    def is_up(self, agent: str) -> bool:
        return self.actors[agent].agent is not None

    def break_down(self, atv: str) -> None:
        vehicle = self.vehicles[atv]
        if not vehicle.problem:
            self.actors[atv].report(vehicle.break_down("the way is blocked", self.now_s), self.now_s)

    def repair(self, atv: str) -> None:
        vehicle = self.vehicles[atv]
        if vehicle.problem:
            self.actors[atv].report(vehicle.repair(self.now_s), self.now_s)

    def notice_link(self, atv: str, link: Link) -> None:
        """A vehicle's modem tells it that the WLAN is gone, or back."""
        vehicle = self.vehicles[atv]
        if vehicle.link is not link:
            vehicle.link = link
            self.actors[atv].report([LinkNoticed(link=link)], self.now_s)

    def run(self, until_s: float) -> None:
        """Let time pass."""
        while True:
            actor = min(self.actors.values(), key=lambda each: each.next_s)
            message_s = self._under_way[0][0] if self._under_way else float("inf")
            next_s = min(actor.next_s, message_s)
            if next_s > until_s:
                break
            self.now_s = max(self.now_s, next_s)
            if message_s <= actor.next_s:
                _, _, sender, to, message = heapq.heappop(self._under_way)
                self._deliver(sender, to, message)
            else:
                actor.step(self.now_s)
            self._checks.after_step()
        self.now_s = max(self.now_s, until_s)

    def run_until(self, condition: Callable[[], bool], within_s: float, step_s: float = 5.0) -> bool:
        """Let time pass until something is so; whether it came to that."""
        until_s = self.now_s + within_s
        while not condition() and self.now_s < until_s:
            self.run(self.now_s + step_s)
        return condition()

    def open_tasks(self) -> list[str]:
        return self._checks.open_tasks()

    @property
    def fulfilled(self) -> set[str]:
        """Orders that the strategist has called delivered."""
        return self._checks.fulfilled

    def check_sums(self, ordered: dict[str, int]) -> None:
        """What came in is what was asked for, to the piece.

        Args:
            ordered: pieces by order.
        """
        self._checks.check_sums(ordered)

    # --- how it goes on ---

    def _add(self, agent: str, create: Callable[[int], object], body: object) -> None:
        actor = Actor(create, body, partial(self._carry_out, agent))  # type: ignore[arg-type]
        self.actors[agent] = actor
        actor.start(self.now_s)

    def _deliver(self, sender: str, to: str, message: Message) -> None:
        actor = self.actors.get(to)
        if actor is None or actor.agent is None or to in self.network.cut_off:
            return
        if isinstance(message, VehicleCommand):
            self._checks.see_command(to, message)
        actor.on_message(sender, message, self.now_s)

    def _carry_out(self, agent: str, effect: Effect) -> None:
        self._checks.see(agent, effect)
        if isinstance(effect, Send):
            self.say(agent, effect.to, effect.message)
            self._note(f"{agent} -> {effect.to} {effect.message}")
        elif isinstance(effect, Publish):
            for listener in self._audience(effect.key):
                if listener != agent:
                    self.say(agent, listener, effect.message)
        elif isinstance(effect, Subscribe):
            self._listeners.setdefault(effect.key, {})[agent] = None
        elif isinstance(effect, Unsubscribe):
            self._listeners.get(effect.key, {}).pop(agent, None)
        elif isinstance(effect, Leave):
            self._forget_listener(agent)
            self._note(f"{agent} leaves")
        elif isinstance(effect, Instruct | Record):
            self._note(f"{agent}: {effect}")

    def _forget_listener(self, agent: str) -> None:
        for listeners in self._listeners.values():
            listeners.pop(agent, None)

    def _audience(self, key: str) -> dict[str, None]:
        """Who listens on a key. Wildcards stand at the end only: `*` for one chunk, `**` for any number."""
        folder = key.rpartition("/")[0]
        keys = [key, f"{folder}/*", f"{folder}/**", f"{folder.rpartition('/')[0]}/**"]
        return {listener: None for each in keys for listener in self._listeners.get(each, ())}

    def _transfer(self, atv: str, action: Pick | Drop, load: tuple[str, int]) -> str:
        """A vehicle's load changes hands; why not, or nothing."""
        if self.failing[atv]:
            self.failing[atv] -= 1
            return "the fork slips"
        item, change = (action.item, -action.quantity) if isinstance(action, Pick) else load
        if action.station == "M7":
            reason, reports = self.workcell.transfer(atv, item, change)
            self.actors["M7"].report(reports, self.now_s)
        elif action.station in PLANT.delivery_warehouses and isinstance(action, Drop) and action.goal:
            reason, gate_reports = self.gate.put(action.goal, change)
            self.actors[STRATEGIST].report(gate_reports, self.now_s)
        else:
            reason = ""
        self._note(f"{atv} {action} {reason or 'done'}")
        if not reason:
            self._checks.see_transfer(atv, action, item, change)
        return reason

    def _note(self, line: str) -> None:
        self.log.append(f"{self.now_s:9.3f} {line}")


def _vehicle(atv: str, life: int) -> Atv:
    return Atv(atv, PLANT, vehicle_type="heavy", incarnation=life, trusts=trusts_seals)

"""What must hold in the small world, looked at after each step."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from dray.body import Drop, Pick, Unhold
from dray.messages import (
    CommandKind,
    HandoverAccepted,
    Reason,
    Role,
    Transport,
    VehicleCommand,
)
from dray.messages.fact import ContractEnded, ContractTaken, OrderFulfilled, TaskClosed, TaskOpened
from dray.protocol.runtime.events import Effect, Instruct, Record, Send

if TYPE_CHECKING:
    from world import World


class Broken(AssertionError):
    """An invariant does not hold."""


class Checks:
    """What must never be seen."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._opened: dict[str, None] = {}
        self._closed: dict[str, str] = {}
        self._handed_over: dict[str, str] = {}
        self._primary_of: dict[str, str] = {}
        self._stopped: dict[str, bool] = {}
        """Whether the stop was acknowledged, of every vehicle that is stopped."""
        self._hops: dict[str, int] = {}
        self._obeyed: set[str] = set()
        self._carried: Counter[str] = Counter()
        """Pieces that were picked up, less those that were put down."""
        self._brought: Counter[str] = Counter()
        """Pieces of every material that came to the machine."""
        self._unheard: Counter[str] = Counter()
        """Those of them that were brought while it was down: it could not know, and may ask once more."""
        self._work: dict[str, Transport] = {}
        self.fulfilled: set[str] = set()

    def _broken(self, what: str) -> Broken:
        self._world.broken = True
        return Broken(what)

    def open_tasks(self) -> list[str]:
        return [task for task in self._opened if task not in self._closed]

    def see(self, agent: str, effect: Effect) -> None:
        if isinstance(effect, Record):
            fact = effect.fact
            if isinstance(fact, TaskOpened):
                self._see_opened(fact)
            elif isinstance(fact, TaskClosed):
                self._see_closed(fact)
            elif isinstance(fact, OrderFulfilled):
                self.fulfilled.add(fact.order)
            elif isinstance(fact, ContractTaken | ContractEnded) and agent in self._world.vehicles:
                self._see_contract(agent, fact)
        elif isinstance(effect, Send) and isinstance(effect.message, HandoverAccepted):
            before = self._handed_over.setdefault(effect.message.task, effect.to)
            if before != effect.to:
                raise self._broken(f"2: {effect.message.task} was handed over by {before} and {effect.to}")
        elif isinstance(effect, Instruct) and isinstance(effect.instruction, Unhold):
            if not self._stopped.pop(agent, False):
                raise self._broken(f"5: {agent} goes on without an acknowledge and a resume")
            self._hops.pop(agent, None)

    def see_command(self, atv: str, command: VehicleCommand) -> None:
        """A command has reached a living vehicle; what comes twice counts once."""
        if command.command in self._obeyed:
            return
        self._obeyed.add(command.command)
        kind = command.kind
        if kind is CommandKind.STOP:
            self._stopped[atv] = False
            self._hops.setdefault(atv, self._world.vehicles[atv].moved)
        elif kind is CommandKind.ACKNOWLEDGE and atv in self._stopped:
            self._stopped[atv] = True

    def see_transfer(self, atv: str, action: Pick | Drop, item: str, change: int) -> None:
        self._carried[item] -= change
        if action.station == "M7" and isinstance(action, Drop):
            self._brought[item] += change

    def after_step(self) -> None:
        world = self._world
        for atv, hops in self._hops.items():
            if world.vehicles[atv].moved != hops:
                raise self._broken(f"5: {atv} is stopped and moves")
        on_board: Counter[str] = Counter()
        for vehicle in world.vehicles.values():
            on_board[vehicle.load[0]] += vehicle.load[1]
        for item, pieces in self._carried.items():
            if on_board[item] != pieces:
                raise self._broken(f"2: {pieces} of {item} are out there, {on_board[item]} are on board")

    def check_sums(self, ordered: dict[str, int]) -> None:
        accounted = Counter[str]()
        for task, work in self._work.items():
            if self._closed.get(task) == "delivered" and not work.goal:
                accounted[work.item] += work.quantity
        for item, brought in self._brought.items():
            most = accounted[item] + self._unheard[item]
            if not accounted[item] <= brought <= most:
                raise self._broken(f"2: {brought} of {item} were brought, {accounted[item]} were asked for")
        arrived = sum(self._world.gate.arrived.values())
        if arrived != sum(ordered.values()):
            raise self._broken(f"4: {arrived} pieces arrived, {ordered} were ordered")

    def _see_opened(self, fact: TaskOpened) -> None:
        if fact.role is Role.PRIMARY:
            if fact.task in self._closed:
                raise self._broken(f"1: {fact.task} is announced after it was closed")
            self._opened.setdefault(fact.task)
            if isinstance(fact.work, Transport):
                self._work[fact.task] = fact.work

    def _see_closed(self, fact: TaskClosed) -> None:
        if fact.task in self._closed:
            raise self._broken(f"1: {fact.task} was closed twice")
        self._closed[fact.task] = fact.outcome

    def _see_contract(self, atv: str, fact: ContractTaken | ContractEnded) -> None:
        if fact.role is not Role.PRIMARY:
            return
        if isinstance(fact, ContractTaken):
            before = self._primary_of.setdefault(atv, fact.task)
            if before != fact.task:
                raise self._broken(f"3: {atv} took {fact.task} while it carried {before}")
            return
        if self._primary_of.get(atv) == fact.task:
            del self._primary_of[atv]
        if fact.reason == Reason.NOT_CONFIRMED and fact.task in self._work:
            self._unheard[self._work[fact.task].item] += self._work[fact.task].quantity

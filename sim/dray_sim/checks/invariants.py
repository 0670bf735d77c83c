"""The invariants of the protocol, checked while a run goes on (protocol, "Invariants").

Every check hears all that is said, and may look at the bodies; none of them takes part. A violation ends the run and
names the invariant, the moment and the observation.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from typing import Any

from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    CommandKind,
    Event,
    HandoverAccepted,
    MachineHeartbeat,
    Message,
    Reason,
    Role,
    StationHeartbeat,
)
from dray.messages.fact import (
    AtvStatusChanged,
    AwardAnswered,
    CarrierChanged,
    CommandObeyed,
    ContractEnded,
    ContractTaken,
    MemoryLost,
    TaskClosed,
    TaskOpened,
)
from dray.messages.keys import STRATEGIST
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.brought_once import BroughtOnce
from dray_sim.checks.delivered import DeliveredExactly
from dray_sim.checks.floor.overlaps import Overlaps
from dray_sim.checks.isolation import ReplacedInTime, SpeaksOn
from dray_sim.checks.one_carrier import OneCarrierAtATime
from dray_sim.checks.one_holder import OneHolderEach
from dray_sim.checks.parts import PartsCountedOnce
from dray_sim.checks.people.goods_kept import GoodsCalledFor, GoodsKept
from dray_sim.checks.people.granted import GrantedOnly
from dray_sim.checks.people.in_service import InServiceOnly
from dray_sim.checks.reported_stock import ReportedStock
from dray_sim.checks.working_time import RestsKept
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.listeners import Listener

OnMessage = Callable[[float, str, str, Message], None]

BRAKING_S = 10.0
"""Longest time in which a stopped vehicle brakes, at any speed and load."""

STILL_M = 1e-6
"""Shorter distances are rounding, not motion."""


class TasksEnd:
    """Invariant 1: an announced task is delivered, withdrawn, or still announced. Never lost.

    Any of these strategists may end a task that another one announced: it has taken the order over.
    """

    hears = (Event, MachineHeartbeat, StationHeartbeat)

    def __init__(self, strategists: tuple[str, ...] = (STRATEGIST,)) -> None:
        self._strategists = strategists
        self._open_s: dict[str, dict[str, float]] = {}
        """Open tasks by coordinator, each with its first announcement."""
        self._forgotten: dict[str, None] = {}
        """Tasks of coordinators that have lost their notes; their carriers may have told of them since."""
        self._ended: dict[str, dict[str, None]] = {}
        """Newest ended tasks by coordinator, forgotten with its notes, too."""

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        if sender in self._strategists:
            sender = self._strategists[0]
        if type(message) is Event:
            fact = message.fact
            if type(fact) is TaskOpened:
                self._open_s.setdefault(sender, {}).setdefault(fact.task, at_s)
            elif type(fact) is MemoryLost:
                self._forgotten.update(dict.fromkeys(self._open_s.pop(sender, {})))
                self._forgotten.update(self._ended.pop(sender, {}))
            elif type(fact) is TaskClosed:
                known = self._open_s.get(sender, {}).pop(fact.task, None) is not None
                if not known and self._forgotten.pop(fact.task, "") is not None:
                    raise InvariantBroken(1, at_s, f"{fact.task} ended twice, or was never announced")
                ended = self._ended.setdefault(sender, {})
                ended[fact.task] = None
                _forget_oldest(ended)
        elif type(message) is MachineHeartbeat or type(message) is StationHeartbeat:
            self._check(sender, message, at_s)

    def _check(self, sender: str, heartbeat: MachineHeartbeat | StationHeartbeat, at_s: float) -> None:
        named = {brief.task for brief in heartbeat.tasks}
        for task, opened_s in self._open_s.get(sender, {}).items():
            if opened_s < at_s and task not in named:
                raise InvariantBroken(1, at_s, f"{sender} has forgotten its open task {task}")


HANDED_OVER_KEPT = 1000
"""Number of tasks whose carriers are remembered: twenty minutes of a plant of 300 agents. A message that is repeated
for longer has no receiver any more."""


class HandedOverOnce:
    """Invariant 2, first half: a task is handed over once, and by one carrier only.

    The answer to the handover and the carrier's own history tell who the carrier is. A coordinator that has lost its
    notes may take a second carrier at its word: it orders so much less.
    """

    hears = (HandoverAccepted, Event)

    def __init__(self) -> None:
        self._coordinator: dict[str, str] = {}
        self._carrier: dict[str, str] = {}
        self._delivered: dict[str, None] = {}

    def on_message(self, at_s: float, sender: str, address: str, message: Message) -> None:
        if type(message) is HandoverAccepted:
            self._coordinator[message.task] = sender
            _forget_oldest(self._coordinator)
            self._note_carrier(message.task, address.removeprefix(">"), at_s)
        elif type(message) is Event:
            fact = message.fact
            if type(fact) is ContractEnded:
                if fact.reason == Reason.HANDED_OVER:
                    self._note_carrier(fact.task, sender, at_s)
            elif type(fact) is TaskClosed and fact.outcome == "delivered":
                self._note_delivered(fact.task, at_s)
            elif type(fact) is MemoryLost:
                for task in [task for task, of in self._coordinator.items() if of == sender]:
                    self._carrier.pop(task, None)
                    self._delivered.pop(task, None)

    def _note_carrier(self, task: str, carrier: str, at_s: float) -> None:
        before = self._carrier.setdefault(task, carrier)
        _forget_oldest(self._carrier)
        if before != carrier:
            raise InvariantBroken(2, at_s, f"{task} was handed over by {before} and by {carrier}")

    def _note_delivered(self, task: str, at_s: float) -> None:
        if task in self._delivered:
            raise InvariantBroken(2, at_s, f"{task} was delivered twice")
        self._delivered[task] = None
        _forget_oldest(self._delivered)


class EpochsRise:
    """The epoch rule behind invariant 2: a task gets a higher epoch whenever its carrier changes."""

    hears = (Event,)

    def __init__(self) -> None:
        self._epochs: dict[str, int] = {}
        """Epoch of the last carrier, by open task."""

    def on_message(self, at_s: float, _sender: str, _address: str, message: Message) -> None:
        if type(message) is not Event:
            return
        fact = message.fact
        if type(fact) is AwardAnswered:
            if fact.role is Role.PRIMARY and fact.answer == "accepted":
                self._epochs[fact.task] = fact.epoch
        elif type(fact) is CarrierChanged:
            before = self._epochs.get(fact.task, 0)
            if fact.epoch <= before:
                seen = f"{fact.task} left {fact.replaced} with epoch {fact.epoch}, and had {before} before"
                raise InvariantBroken(2, at_s, seen)
            self._epochs[fact.task] = fact.epoch
        elif type(fact) is TaskClosed:
            self._epochs.pop(fact.task, None)


class OnePrimaryEach:
    """Invariant 3: an ATV is primary of at most one task. Machines hold several goals, of whichever of these strategists."""

    hears = (Event,)

    def __init__(self, strategists: tuple[str, ...] = (STRATEGIST,)) -> None:
        self._strategists = strategists
        self._primary_of: dict[str, str] = {}

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        if type(message) is not Event:
            return
        fact = message.fact
        if (
            type(fact) is ContractTaken
            and fact.role is Role.PRIMARY
            and fact.coordinator not in self._strategists
        ):
            before = self._primary_of.setdefault(sender, fact.task)
            if before != fact.task:
                raise InvariantBroken(3, at_s, f"{sender} took {fact.task} while it carried {before}")
        elif type(fact) is ContractEnded and fact.role is Role.PRIMARY:
            if self._primary_of.get(sender) == fact.task:
                del self._primary_of[sender]
        elif type(fact) is MemoryLost:
            self._primary_of.pop(sender, None)


class StoppedStands:
    """Invariant 5: a stopped vehicle does not move before acknowledge and resume.

    A loss of power ends no stop. People may carry a vehicle about: only the distance that it drives counts.
    """

    hears = (AtvHeartbeat, Event)

    def __init__(self, factory: SimFactory) -> None:
        self._factory = factory
        self._stopped_s: dict[str, float] = {}
        self._stood_m: dict[str, float] = {}
        """Distance that a stopped vehicle had driven when it came to its stand."""
        self._acknowledged: dict[str, None] = {}

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        if type(message) is AtvHeartbeat and sender in self._stopped_s:
            self._check_stand(sender, at_s)
        elif type(message) is Event:
            fact = message.fact
            if type(fact) is CommandObeyed and fact.done:
                self._note_command(sender, fact.what, at_s)
            elif type(fact) is AtvStatusChanged and sender in self._stopped_s:
                if fact.status is not AtvStatus.STOPPED:
                    raise InvariantBroken(5, at_s, f"{sender} left STOPPED without a resume")

    def _note_command(self, atv: str, what: str, at_s: float) -> None:
        if what == CommandKind.STOP.value:
            self._stopped_s[atv] = at_s
            self._acknowledged.pop(atv, None)
        elif what == CommandKind.ACKNOWLEDGE.value:
            self._acknowledged[atv] = None
        elif what == CommandKind.RESUME.value:
            if atv in self._stopped_s and atv not in self._acknowledged:
                raise InvariantBroken(5, at_s, f"{atv} resumed without an acknowledge")
            self._stopped_s.pop(atv, None)
            self._stood_m.pop(atv, None)

    def _check_stand(self, atv: str, at_s: float) -> None:
        if at_s < self._stopped_s[atv] + BRAKING_S:
            return
        vehicle = self._factory.vehicles[atv]
        driven_m = vehicle.odometer().metres_m
        moved_m = driven_m - self._stood_m.setdefault(atv, driven_m)
        if moved_m > STILL_M or vehicle.sense().speed_mps > STILL_M:
            raise InvariantBroken(5, at_s, f"{atv} is stopped and has moved {moved_m:.3f} m")


class MaterialConserved:
    """Invariant 2, second half: storage + on board + buffers + consumed + scrapped = supplied.

    Args:
        balance: counts (see `dray_sim.bodies.floor.Pieces`).
    """

    INTERVAL_S = 60.0
    """Interval between two counts: counting the whole plant takes a while, and lost pieces stay lost."""

    def __init__(self, balance: Callable[[], Mapping[str, int]]) -> None:
        self._balance = balance
        self._next_s = 0.0
        self._first = balance()

    def on_message(self, at_s: float, _sender: str, _address: str, _message: Message) -> None:
        if at_s >= self._next_s:
            self._next_s = at_s + self.INTERVAL_S
            self.check(at_s)

    def check(self, at_s: float) -> None:
        """Count everything now."""
        for item, (first, now) in _both(self._first, self._balance()).items():
            if first != now:
                seen = f"{abs(now - first)} pieces of {item} {'appeared' if now > first else 'are lost'}"
                raise InvariantBroken(2, at_s, seen)


class PromisedLiesThere:
    """Invariant 10: promised pieces lie in the storage of the station that promised them."""

    hears = (StationHeartbeat,)

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """Compare the promises with the stock.

        Raises:
            InvariantBroken: a station has promised more than lies there.
        """
        if type(message) is not StationHeartbeat:
            return
        for stock in message.stocks:
            if stock.promised > stock.level:
                seen = f"{sender} has promised {stock.promised} of the {stock.level} {stock.item} that it has"
                raise InvariantBroken(10, at_s, seen)


class Invariants:
    """All checks of one factory, as one listener.

    A check with an attribute `hears` is asked about messages of these types only, another one about all.

    A violation does not disturb the agents: it is kept, and told to its waiters. Invariant 8 is not among them: an
    agent that ends by an exception ends the run by itself.

    Args:
        factory: to watch.
        more: further checks, which raise `InvariantBroken` as these do.

    Attributes:
        broken: the first violation; None while all hold.
    """

    def __init__(self, factory: SimFactory, *more: Listener) -> None:
        self.broken: InvariantBroken | None = None
        self._broke = asyncio.Event()
        self._conservation = MaterialConserved(lambda: factory.floor.count().balance)
        plant = factory.plant
        abilities = {atv: plant.vehicle_types[vehicle.type].abilities for atv, vehicle in plant.fleet.items()}
        self._checks: tuple[Listener, ...] = (
            TasksEnd(factory.strategists),
            HandedOverOnce(),
            EpochsRise(),
            OnePrimaryEach(factory.strategists),
            DeliveredExactly(factory.arrived),
            OneHolderEach(),
            PartsCountedOnce(factory),
            BroughtOnce(abilities),
            OneCarrierAtATime(factory),
            StoppedStands(factory),
            SpeaksOn(factory),
            ReplacedInTime(factory),
            GrantedOnly(factory),
            PromisedLiesThere(),
            ReportedStock(factory),
            InServiceOnly(),
            RestsKept(plant),
            GoodsKept(factory),
            GoodsCalledFor(),
            self._conservation,
            *more,
        )

        self._by_type: dict[type[Message], tuple[OnMessage, ...]] = {}
        """The checks that hear a type of message: most messages concern few of them."""

    def add(self, check: Listener) -> None:
        """Ask one more, which raises `InvariantBroken` as these do."""
        self._checks += (check,)
        self._by_type.clear()

    def on_message(self, at_s: float, sender: str, address: str, message: Message) -> None:
        """Check one utterance."""
        if self.broken is not None:
            return
        checks = self._by_type.get(type(message))
        if checks is None:
            checks = self._by_type[type(message)] = self._of(type(message))
        try:
            for check in checks:
                check(at_s, sender, address, message)
        except InvariantBroken as broken:
            self.broken = broken
            self._broke.set()

    def _of(self, kind: type[Message]) -> tuple[OnMessage, ...]:
        """The checks that hear a type of message, in their order."""
        return tuple(check.on_message for check in self._checks if kind in getattr(check, "hears", (kind,)))

    def check_end(self, at_s: float) -> None:
        """Count once more at the end of a run."""
        try:
            self._conservation.check(at_s)
            for check in self._checks:
                if isinstance(check, Overlaps):
                    check.check_end(at_s)
        except InvariantBroken as broken:
            self.broken = self.broken or broken

    async def wait_broken(self) -> None:
        """Return when one is broken; that may be never."""
        await self._broke.wait()


def _forget_oldest(tasks: dict[str, Any]) -> None:
    if len(tasks) > HANDED_OVER_KEPT:
        del tasks[next(iter(tasks))]


def _both(first: Mapping[str, int], now: Mapping[str, int]) -> dict[str, tuple[int, int]]:
    return {item: (first.get(item, 0), now.get(item, 0)) for item in {**first, **now}}

"""Invariant 27: goods and things on a dead vehicle are given up at a person's word, or after the stated time.

A person is called for that.

Like those of `dray_sim.checks.invariants`, this check hears all messages, looks at the loads of bodies, and takes no
part.
"""

from __future__ import annotations

from msgspec import UNSET

from dray.messages import (
    THING,
    AtvHeartbeat,
    CallState,
    Event,
    HelpCall,
    MachineCommand,
    MachineCommandKind,
    MachineHeartbeat,
    Message,
    StationHeartbeat,
    Transport,
    TransportAnswered,
    TransportCancelled,
    TransportState,
)
from dray.messages.fact import MemoryLost, TaskClosed, TaskOpened
from dray.protocol.takeover.left_aboard import WRITTEN_OFF_AFTER_S
from dray_sim.checks.broken import InvariantBroken
from dray_sim.factory.sim_factory import SimFactory

WORDS_KEPT = 1000
"""Most remembered tasks with a person's word on their loads; a word is repeated only until it is answered."""

ASKED_WITHIN_S = 60.0
"""Goods are called for at once, and again every 5 s."""


class GoodsKept:
    """No coordinator gives up goods or a thing on board of a vehicle that is off.

    Args:
        factory: to watch.
    """

    hears = (AtvHeartbeat, MachineCommand, TransportCancelled, TransportAnswered, Event)

    def __init__(self, factory: SimFactory) -> None:
        self._factory = factory
        self._goods: dict[str, tuple[str, str]] = {}
        """Item and coordinator of each open task of goods or of a thing."""
        self._heard_s: dict[str, float] = {}
        """When each vehicle has spoken last."""
        self._words: dict[str, None] = {}
        """Tasks whose loads somebody has written off, and transports that somebody has called off."""

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """Note one utterance."""
        if type(message) is AtvHeartbeat:
            self._heard_s[message.atv] = at_s
        elif isinstance(message, (MachineCommand, TransportCancelled, TransportAnswered)):
            self._on_word(message)
        elif type(message) is Event:
            fact = message.fact
            if type(fact) is TaskOpened:
                if isinstance(fact.work, Transport) and (fact.work.goal or fact.work.item == THING):
                    self._goods[fact.task] = (fact.work.item, sender)
            elif type(fact) is TaskClosed:
                item, _ = self._goods.pop(fact.task, ("", ""))
                if item and fact.outcome == "withdrawn":
                    self._check(fact, item, at_s)
            elif type(fact) is MemoryLost:
                # The coordinator may have taken up tasks since then of which it knows less.
                self._goods = {task: goods for task, goods in self._goods.items() if goods[1] != sender}

    def _on_word(self, message: MachineCommand | TransportCancelled | TransportAnswered) -> None:
        match message:
            case MachineCommand(kind=MachineCommandKind.WRITE_OFF, task=task):
                self._note_word(task)
            case TransportCancelled(transport=transport):
                self._note_word(transport)
            case TransportAnswered(transport=transport, state=TransportState.ON_BOARD):
                self._words.pop(transport, None)  # The transport was called off too late, and goes on.

    def _note_word(self, about: str) -> None:
        self._words[about] = None
        if len(self._words) > WORDS_KEPT:
            del self._words[next(iter(self._words))]

    def _check(self, fact: TaskClosed, item: str, at_s: float) -> None:
        vehicle = self._factory.vehicles.get(fact.carrier)
        if vehicle is None or not vehicle.off or vehicle.sense().load != item:
            return
        if fact.task in self._words or any(_is_attempt(fact.task, word) for word in self._words):
            return
        silent_s = at_s - self._heard_s.get(fact.carrier, 0.0)
        if silent_s < WRITTEN_OFF_AFTER_S:
            seen = f"{fact.task} was given up with its load on board of {fact.carrier}, which is dead for {silent_s:.0f} s"
            raise InvariantBroken(27, at_s, seen)


class GoodsCalledFor:
    """Invariant 27, second half: a coordinator whose load waits for a person calls one, until one has handed it over.

    It need not call while the load's vehicle is heard and has a problem: the vehicle calls itself.
    """

    hears = (HelpCall, AtvHeartbeat, MachineHeartbeat, StationHeartbeat)

    def __init__(self) -> None:
        self._since_s: dict[str, dict[str, float]] = {}
        """Beginning of the wait, or time of the last call, by coordinator and its transport whose load waits."""
        self._aboard: dict[str, str] = {}
        """Vehicle by such a transport."""
        self._lives: dict[str, int] = {}

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """Note one utterance.

        Raises:
            InvariantBroken: see the class.
        """
        if type(message) is HelpCall:
            since_s = self._since_s.get(sender, {})
            if message.state is not CallState.ENDED and message.goods in since_s:
                since_s[message.goods] = at_s
        elif type(message) is AtvHeartbeat and message.problem:
            for since_s in self._since_s.values():
                since_s.update((goods, at_s) for goods in since_s if self._aboard.get(goods) == sender)
        elif type(message) is MachineHeartbeat:
            self._note(message.machine, message, at_s)
        elif type(message) is StationHeartbeat:
            self._note(message.station, message, at_s)

    def _note(self, place: str, heartbeat: MachineHeartbeat | StationHeartbeat, at_s: float) -> None:
        life = heartbeat.incarnation
        before_s = self._since_s.get(place, {}) if self._lives.get(place) == life else {}
        self._lives[place] = life
        waiting = {
            brief.task: brief.stranded.atv
            for brief in heartbeat.tasks
            if brief.stranded is not UNSET and not brief.stranded.handed_at and not heartbeat.draining
        }
        self._since_s[place] = {goods: before_s.get(goods, at_s) for goods in waiting}
        for gone in [goods for goods in before_s if goods not in waiting]:
            self._aboard.pop(gone, None)
        self._aboard |= waiting
        for goods, since_s in self._since_s[place].items():
            if at_s - since_s > ASKED_WITHIN_S:
                seen = f"{place} has {goods} on board of a failed vehicle for {at_s - since_s:.0f} s and calls nobody"
                raise InvariantBroken(27, at_s, seen)


def _is_attempt(task: str, transport: str) -> bool:
    return task.startswith((f"{transport}-", f"{transport}."))

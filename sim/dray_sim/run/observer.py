"""The figures of a run, gathered from the facts that agents record.

The observer hears every utterance at the moment it is said, and disturbs nothing: it is not on the
bus. It keeps figures, not histories; the length of a run does not matter to it.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable
from dataclasses import dataclass, field

from dray.messages import (
    Event,
    FloorReported,
    Heartbeat,
    MachineStatus,
    Message,
    Role,
    StationHeartbeat,
    Transport,
)
from dray.messages.fact import (
    AwardAnswered,
    BidReceived,
    BidRefused,
    CarrierChanged,
    Fact,
    GoodsDelivered,
    MachineStatusChanged,
    OrderFulfilled,
    PrimarySuspected,
    TaskClosed,
    TaskOpened,
    WatchLost,
)


@dataclass(slots=True)
class MachineTimes:
    """Time of a machine in each status (s)."""

    status: MachineStatus = MachineStatus.IDLE
    since_s: float = 0.0
    spent_s: dict[MachineStatus, float] = field(default_factory=dict)

    def enter(self, status: MachineStatus, now_s: float) -> None:
        self.spent_s[self.status] = self.spent_s.get(self.status, 0.0) + now_s - self.since_s
        self.status, self.since_s = status, now_s


class Observer:
    """Gathers the figures of one run.

    Attributes:
        opened_s: open tasks and when they were announced first.
        took_s: how long each transport took that was handed over, in order. Plain numbers, since this
            is the one thing here that grows: 8 bytes for a transport, some kilobytes in a day.
        late_s: the same transports, against their carriers' own promises; negative for early ones.
        fulfilled_s: orders and when all of them was delivered.
        delivered: pieces that reached the delivery warehouse, by order.
        answers: how awards ended, by answer.
        refusals: refusals by reason.
    """

    def __init__(self) -> None:
        self.opened_s: dict[str, float] = {}
        self.took_s = array("d")
        self.late_s = array("d")
        self.goals_closed = 0
        self.fulfilled_s: dict[str, float] = {}
        self.delivered: dict[str, int] = {}
        self.answers: dict[str, int] = {}
        self.refusals: dict[str, int] = {}
        self.bids = 0
        self.rounds = 0
        self.watches_taken = 0
        self.watches_lost = 0
        self.suspicions = 0
        self.carriers_changed = 0
        self.messages = 0
        self.negotiation = 0
        """Messages that are neither heartbeats, presence hints nor history: the cost of contracts and right of way."""
        self.machines: dict[str, MachineTimes] = {}
        self._transport_tasks: dict[str, None] = {}
        self._arrived: dict[str, dict[str, int]] = {}
        """Reported pieces by open order and its goals."""

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """Note one utterance."""
        self.messages += 1
        if type(message) is Event:
            self._note(message.fact, sender, at_s)
        elif not isinstance(message, Heartbeat | StationHeartbeat | FloorReported):
            self.negotiation += 1

    def close(self, now_s: float) -> None:
        """End the run: count the time of all unfinished states."""
        for times in self.machines.values():
            times.enter(times.status, now_s)

    def _note(self, fact: Fact, agent: str, now_s: float) -> None:
        if isinstance(fact, BidReceived):
            self.bids += 1
        elif isinstance(fact, BidRefused):
            self.refusals[fact.reason.value] = self.refusals.get(fact.reason.value, 0) + 1
        elif isinstance(fact, TaskOpened):
            self._note_opened(fact, now_s)
        elif isinstance(fact, AwardAnswered):
            self._note_answer(fact)
        elif isinstance(fact, TaskClosed):
            self._note_closed(fact, now_s)
        elif isinstance(fact, MachineStatusChanged):
            self.machines.setdefault(agent, MachineTimes()).enter(fact.status, now_s)
        elif isinstance(fact, GoodsDelivered):
            arrived = self._arrived.setdefault(fact.order, {})
            arrived[fact.goal] = max(arrived.get(fact.goal, 0), fact.delivered)
            self.delivered[fact.order] = sum(arrived.values())
        elif isinstance(fact, OrderFulfilled):
            # A strategist that was away when it ended tells it again.
            self.fulfilled_s.setdefault(fact.order, now_s)
            self._arrived.pop(fact.order, None)
        else:
            self._note_trouble(fact)

    def _note_trouble(self, fact: Fact) -> None:
        if isinstance(fact, WatchLost):
            self.watches_lost += 1
        elif isinstance(fact, PrimarySuspected):
            self.suspicions += 1
        elif isinstance(fact, CarrierChanged):
            self.carriers_changed += 1

    def _note_answer(self, fact: AwardAnswered) -> None:
        answer = fact.answer if fact.reason is None else fact.reason.value
        self.answers[answer] = self.answers.get(answer, 0) + 1
        if fact.role is Role.SECONDARY and fact.answer == "accepted":
            self.watches_taken += 1

    def _note_opened(self, fact: TaskOpened, now_s: float) -> None:
        if fact.role is Role.PRIMARY:
            self.rounds += isinstance(fact.work, Transport)
            self.opened_s.setdefault(fact.task, now_s)
            if isinstance(fact.work, Transport):
                self._transport_tasks[fact.task] = None

    def _note_closed(self, fact: TaskClosed, now_s: float) -> None:
        opened_s = self.opened_s.pop(fact.task, now_s)
        if fact.task not in self._transport_tasks:
            self.goals_closed += 1
            return
        del self._transport_tasks[fact.task]
        if fact.outcome == "delivered":
            self.took_s.append(now_s - opened_s)
            self.late_s.append(now_s - fact.promised_s)


def percentile(values: Iterable[float], frac: float) -> float:
    """The smallest value that at least `frac` of all values do not exceed; 0 for no values."""
    ordered = sorted(values)
    if not ordered:
        return 0.0
    return ordered[min(len(ordered) - 1, max(0, -(-len(ordered) * frac // 1).__int__() - 1))]

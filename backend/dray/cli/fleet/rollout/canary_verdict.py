"""The verdict on a canary, a process of another version, from other agents' messages. Pure: it only gets messages.

An agent of a bad version may believe that it does well. So only the messages of its customers and contractors count.

    kind         a task done well                                       a task done badly
    vehicle      its coordinator closes it as delivered by it, in time  late, or somebody else has to carry it
    machine      a vehicle that it has hired is told "handed over"      its goal is lost, by the strategist's word
    strategist   a machine has taken a goal from it

Only contracts of its present life count, because it is not responsible for those of its last one. A task withdrawn by its
coordinator or stopped by a person counts neither way. `dray.cli.fleet.rollout.update` checks whether its process lives.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from dray.messages import (
    AtvHeartbeat,
    CommandKind,
    Event,
    Heartbeat,
    MachineHeartbeat,
    Message,
    Reason,
    Role,
)
from dray.messages.fact import (
    AwardAnswered,
    BidReceived,
    CarrierChanged,
    CommandObeyed,
    ContractEnded,
    ContractTaken,
    Fact,
    GoalContracted,
    GoalLost,
    TaskClosed,
)
from dray.messages.kinds import Kind

BIDS_KEPT = 100
"""Maximum open bids of one vehicle: it makes one every few seconds."""

NOT_YET = float("inf")


class Canary:
    """The common part of all canaries.

    Args:
        agent: its id.
        version: the expected version in its heartbeats.
        tasks: number of tasks to do well.
        before: the known incarnation of its last life.
        late_s: tolerance of promised times (plant clock).

    Attributes:
        done: tasks done well.
        failure: why it has failed; empty while it has not.
        joined: whether its present life was heard.
    """

    def __init__(self, agent: str, version: str, tasks: int, before: int, late_s: float) -> None:
        self.agent, self.tasks = agent, tasks
        self.done = 0
        self.failure = ""
        self.joined = False
        self._version = version
        self._life = before
        self._late_s = late_s
        self._on_fact: Mapping[type[Fact], Callable[[str, Any, float], None]] = {}

    @property
    def passed(self) -> bool:
        """Whether it has done its tasks."""
        return self.joined and self.done >= self.tasks and not self.failure

    def note_present(self) -> None:
        """It is on the bus: the only evidence for an agent without a heartbeat."""
        self.joined = True

    def fail(self, reason: str) -> None:
        """Record the failure; the first reason is kept."""
        self.failure = self.failure or reason

    def on_message(self, sender: str, message: Message) -> None:
        """Evaluate a message."""
        if isinstance(message, Heartbeat):
            if sender == self.agent:
                self._on_own_heartbeat(message)
        elif isinstance(message, Event) and self.joined:
            note = self._on_fact.get(type(message.fact))
            if note is not None:
                note(sender, message.fact, message.at_s)

    def look(self, now_s: float) -> None:
        """Check for lateness at this time (plant clock)."""

    def _on_own_heartbeat(self, heartbeat: AtvHeartbeat | MachineHeartbeat) -> None:
        if heartbeat.incarnation <= self._life:
            return
        if self.joined:
            self.fail("it was started again")
        self.joined, self._life = True, heartbeat.incarnation
        if heartbeat.software != self._version:
            self.fail(f"it says that it runs {heartbeat.software or 'no version'}, not {self._version}")


class AtvCanary(Canary):
    """A vehicle as a canary, judged by coordinators' messages about its transports."""

    def __init__(self, agent: str, version: str, tasks: int, before: int, late_s: float) -> None:
        super().__init__(agent, version, tasks, before, late_s)
        self._bids: dict[tuple[str, int], float] = {}
        """Bid completion times, by task and epoch."""
        self._carries: dict[str, float] = {}
        """Its tasks, and their promised times."""
        self._on_fact = {
            BidReceived: self._note_bid,
            AwardAnswered: self._note_award,
            CarrierChanged: self._note_change,
            TaskClosed: self._note_closed,
            CommandObeyed: self._note_command,
        }

    def look(self, now_s: float) -> None:
        """Check its unfinished tasks for lateness."""
        for task, promised_s in self._carries.items():
            if now_s > promised_s + self._late_s:
                self.fail(f"{task} is not done {now_s - promised_s:.0f} s after it had promised to be")

    def _note_bid(self, _sender: str, bid: BidReceived, _at_s: float) -> None:
        if bid.bidder == self.agent and bid.role is Role.PRIMARY:
            self._bids[bid.task, bid.epoch] = bid.finish_s
            if len(self._bids) > BIDS_KEPT:
                del self._bids[next(iter(self._bids))]

    def _note_award(self, _sender: str, award: AwardAnswered, _at_s: float) -> None:
        if award.bidder == self.agent and award.role is Role.PRIMARY and award.answer == "accepted":
            self._carries[award.task] = self._bids.pop((award.task, award.epoch), NOT_YET)

    def _note_change(self, _sender: str, change: CarrierChanged, _at_s: float) -> None:
        if change.carrier == self.agent:
            self._carries[change.task] = NOT_YET
        elif change.replaced == self.agent and change.task in self._carries:
            del self._carries[change.task]
            self.fail(f"{change.task} had to be taken from it: {change.reason}")

    def _note_closed(self, _sender: str, closed: TaskClosed, at_s: float) -> None:
        if closed.task not in self._carries:
            return
        del self._carries[closed.task]
        if closed.outcome != "delivered" or closed.carrier != self.agent:
            return
        if closed.promised_s and at_s > closed.promised_s + self._late_s:
            self.fail(f"{closed.task} was delivered {at_s - closed.promised_s:.0f} s after its promise")
        else:
            self.done += 1

    def _note_command(self, sender: str, command: CommandObeyed, _at_s: float) -> None:
        if sender == self.agent and command.what == CommandKind.STOP and command.done:
            # A person's stop explains any delay of its present transports.
            self._carries.clear()


class MachineCanary(Canary):
    """A machine as a canary, judged by vehicles' and the strategist's messages."""

    def __init__(self, agent: str, version: str, tasks: int, before: int, late_s: float) -> None:
        super().__init__(agent, version, tasks, before, late_s)
        self._hired: set[tuple[str, int]] = set()
        """Its hired transports, by task and epoch: after a takeover, the other contract ends later."""
        self._goals: dict[str, None] = {}
        """Goals taken in this life."""
        self._on_fact = {
            ContractTaken: self._note_taken,
            ContractEnded: self._note_ended,
            GoalContracted: self._note_goal,
            GoalLost: self._note_lost,
        }

    def _note_taken(self, _sender: str, taken: ContractTaken, _at_s: float) -> None:
        if taken.coordinator == self.agent and taken.role is Role.PRIMARY:
            self._hired.add((taken.task, taken.epoch))

    def _note_ended(self, _sender: str, ended: ContractEnded, _at_s: float) -> None:
        contract = (ended.task, ended.epoch)
        if ended.role is Role.PRIMARY and contract in self._hired:
            self._hired.remove(contract)
            self.done += ended.reason == Reason.HANDED_OVER

    def _note_goal(self, _sender: str, contracted: GoalContracted, _at_s: float) -> None:
        if contracted.machine == self.agent:
            self._goals[contracted.goal] = None

    def _note_lost(self, _sender: str, lost: GoalLost, _at_s: float) -> None:
        if lost.machine == self.agent and lost.goal in self._goals:
            self.fail(f"its goal {lost.goal} had to be given to others")


class StrategistCanary(Canary):
    """A strategist as a canary, without a heartbeat: it is judged by machines that take its goals."""

    def __init__(self, agent: str, version: str, tasks: int, before: int, late_s: float) -> None:
        super().__init__(agent, version, tasks, before, late_s)
        self._on_fact = {ContractTaken: self._note_taken}

    def _note_taken(self, _sender: str, taken: ContractTaken, _at_s: float) -> None:
        self.done += taken.coordinator == self.agent


CANARIES: Mapping[str, type[Canary]] = {
    Kind.ATV: AtvCanary,
    Kind.MACHINE: MachineCanary,
    Kind.STRATEGIST: StrategistCanary,
}
"""The canaries by kind of agent. For the others, only their presence can be checked."""

HEARD = frozenset[str]({Kind.ATV, Kind.MACHINE})
"""Kinds of agents with heartbeats."""

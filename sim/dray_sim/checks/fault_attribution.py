"""Invariant 6, the other way round: nobody loses a contract without a reason.

Where a carrier is replaced or a goal is taken from its machine, a fault must have touched one of
those who are concerned not long before. So a failure that spreads to others is seen. That a vehicle was asked
to leave is no such fault: it gives its task back itself, or finishes it, and nobody need miss it. Nor is a process that
was started again so soon that nobody need have missed it, or a clock that somebody has set.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping
from fnmatch import fnmatchcase
from typing import NamedTuple

from dray.messages import AtvHeartbeat, AtvStatus, CommandKind, Event, Message, Reason
from dray.messages.fact import AtvStatusChanged, CarrierChanged, CommandObeyed, GoalLost
from dray.messages.keys import GATE, STRATEGIST
from dray_sim.checks.broken import InvariantBroken
from dray_sim.faults import (
    ClockSet,
    Crashed,
    DoorFailed,
    Fault,
    JournalLost,
    LaneBlocked,
    LinkTrouble,
    LoadDropped,
    LoadShifted,
    MachineBroken,
    PoweredOff,
    RadioCut,
    SentAway,
    VehicleBroken,
    WlanCut,
)
from dray_sim.faults.chance import COORDINATOR_BACK_S, VEHICLE_BACK_S

LATER_S = 300.0
"""What a fault has begun is over by then: suspicions, waits for help, and what people do about it."""

HELD_UP_S = 5.0
"""A message that is overtaken, or doubled, comes so much later at most."""

HEARD_S = 0.5
"""A process that lives for less may have said nothing."""

EVERYBODY = ""

FLOOR = "the floor"
"""Stands for what people have closed, and what lies on lanes, which may hold up anybody. No agent has a name with white space."""


OUT_UNTIL_S: Mapping[str, float] = {CommandKind.TAKE_OUT: float("inf"), CommandKind.PUT_IN: 0.0}
"""For how long from a person's word a vehicle is out of service, which explains what it gives back for that."""


class _Spell(NamedTuple):
    """A fault, and when it was there."""

    fault: Fault
    begun_s: float
    ended_s: float
    """Infinity while it is there."""


class _Absence:
    """How long an agent's process was away."""

    __slots__ = ("back_s", "held_by", "since_s")

    def __init__(self, since_s: float) -> None:
        self.since_s = since_s
        self.back_s = float("inf")
        self.held_by: set[str] = set()
        """The faults that keep it away, by id."""


class FaultAttribution:
    """Knows which faults there were, and asks for one when somebody loses a contract.

    Args:
        fleet: who is a vehicle.
        strategists: who gives goals out.
    """

    def __init__(self, fleet: Container[str] = (), strategists: tuple[str, ...] = (STRATEGIST,)) -> None:
        self._fleet = fleet
        # What is counted at the gate decides when a goal is lost, as their words do.
        self.strategists = (*strategists, GATE)
        self._absences: dict[str, _Absence] = {}
        """The last one of each agent."""
        self._spells: dict[str, _Spell] = {}
        """By id of the fault. A run has some dozens."""
        self._touched_s: dict[str, float] = {}
        """Until when an agent was in trouble last, or away (`_away`); `EVERYBODY` stands for the network."""
        self._stands: dict[str, None] = {}
        """Vehicles that are stopped or in error, whoever did that to them."""

    def begin(self, name: str, fault: Fault, at_s: float) -> None:
        """A fault has begun."""
        self._spells[name] = _Spell(fault, at_s, float("inf"))
        if isinstance(fault, Crashed):
            absence = self._absences.get(fault.agent)
            if absence is None or at_s > absence.back_s + HEARD_S:
                absence = self._absences[fault.agent] = _Absence(at_s)
                # A process that was about to shut down gracefully, and crashes before it has, stays away as long.
                absence.held_by.update(self._sending_away(fault.agent))
            absence.held_by.add(name)
            absence.back_s = float("inf")
        elif not isinstance(fault, ClockSet):
            self._touched_s[_touched(fault)] = float("inf")
            if isinstance(fault, SentAway):
                # A process that is down already cannot shut down gracefully: it stays away as it went.
                absence = self._absences.get(fault.agent)
                if absence is not None and absence.held_by:
                    absence.held_by.add(name)

    def distrust(self, agent: str) -> None:
        """Somebody lies: whatever it loses is due to that."""
        self._touched_s[agent] = float("inf")

    def restrict(self, until_s: float) -> None:
        """People close parts of the floor until then: whatever is given back or comes late may be due to that."""
        self._touched_s[FLOOR] = until_s

    def end(self, name: str, at_s: float) -> None:
        """A fault has ended."""
        fault = self._spells[name].fault
        self._spells[name] = self._spells[name]._replace(ended_s=at_s)
        if isinstance(fault, Crashed | SentAway):
            self._note_back(fault.agent, name, at_s)
        if isinstance(fault, Crashed | ClockSet):
            return
        touched = _touched(fault)
        still = any(
            _touched(each.fault) == touched and each.ended_s > at_s
            for each in self._spells.values()
            if not isinstance(each.fault, Crashed | ClockSet)
        )
        self._touched_s[touched] = float("inf") if still else at_s

    def in_trouble(self, at_s: float, *agents: str) -> bool:
        """Whether anything was wrong with one of these agents, or with the network, not long ago."""
        return any(
            agent in self._stands
            or at_s - self._touched_s.get(agent, float("-inf")) < LATER_S
            or self._is_missed(agent, at_s)
            for agent in (EVERYBODY, FLOOR, *agents)
        )

    def may_have_lost(self, sender: str, receiver: str, since_s: float) -> bool:
        """Whether what one agent said to another since then may not have arrived."""
        return any(
            spell.ended_s >= since_s and _can_lose(spell.fault, sender, receiver)
            for spell in self._spells.values()
        )

    def delay_s(self, since_s: float) -> float:
        """How much longer than usual a message since then may have been under way."""
        troubles = [spell.fault for spell in self._spells.values() if spell.ended_s >= since_s]
        return sum(
            fault.latency_s
            + fault.jitter_s
            + (HELD_UP_S if fault.reorder_frac or fault.duplicate_frac else 0.0)
            for fault in troubles
            if isinstance(fault, LinkTrouble)
        )

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """Look for what lost contracts are due to.

        Raises:
            InvariantBroken: nothing was wrong with anybody.
        """
        if type(message) is AtvHeartbeat:
            self._note_wait(message, at_s)
        if type(message) is not Event:
            return
        fact = message.fact
        if type(fact) is AtvStatusChanged:
            if fact.status in (AtvStatus.STOPPED, AtvStatus.ERROR):
                self._stands[sender] = None
            elif self._stands.pop(sender, "") is None:
                self._touched_s[sender] = at_s
        elif type(fact) is CommandObeyed and fact.done and fact.what in OUT_UNTIL_S:
            self._touched_s[_taken_out(sender)] = at_s + OUT_UNTIL_S[fact.what]
        elif type(fact) is CarrierChanged:
            if not self.in_trouble(at_s, *_concerned(sender, fact)):
                seen = f"{fact.replaced} lost {fact.task} ({fact.reason}), and nothing was wrong with it"
                raise InvariantBroken(6, at_s, seen)
        elif type(fact) is GoalLost:
            machine = fact.machine
            givers = (*self.strategists, *map(_away, self.strategists))
            concerned = (machine, _away(machine), _taken_out(machine), *givers)
            if not self.in_trouble(at_s, *concerned):
                seen = f"{fact.machine} lost {fact.goal}, and nothing was wrong with it"
                raise InvariantBroken(6, at_s, seen)

    def _note_wait(self, heartbeat: AtvHeartbeat, at_s: float) -> None:
        """With right of way, whoever waits for a vehicle with which something is wrong is late for the same reason."""
        other = heartbeat.floor.waits_for if heartbeat.floor else ""
        agents = (other, _away(other))
        if other and any(
            agent in self._stands
            or at_s - self._touched_s.get(agent, float("-inf")) < LATER_S
            or self._is_missed(agent, at_s)
            for agent in agents
        ):
            self._touched_s[heartbeat.atv] = max(at_s, self._touched_s.get(heartbeat.atv, at_s))

    def _sending_away(self, agent: str) -> Iterator[str]:
        """The faults by which an agent is to be away now after a graceful shutdown."""
        for name, spell in self._spells.items():
            if (
                isinstance(spell.fault, SentAway)
                and spell.fault.agent == agent
                and spell.ended_s == float("inf")
            ):
                yield name

    def _note_back(self, agent: str, name: str, at_s: float) -> None:
        """A crash is over; it counts as a fault when the process was away for so long that it was missed."""
        absence = self._absences.get(agent)
        if absence is None or name not in absence.held_by:
            return
        absence.held_by.remove(name)
        if not absence.held_by:
            absence.back_s = at_s
            if self._is_missed(agent, at_s):
                self._touched_s[agent] = max(at_s, self._touched_s.get(agent, at_s))

    def _is_missed(self, agent: str, at_s: float) -> bool:
        """Whether an agent's process is away, or comes back just now, after so long that others have missed it."""
        absence = self._absences.get(agent)
        if absence is None or at_s > absence.back_s:
            return False
        return at_s - absence.since_s > (VEHICLE_BACK_S if agent in self._fleet else COORDINATOR_BACK_S)


def _away(agent: str) -> str:
    """What stands for an agent's being away after a graceful shutdown: that is trouble to those only who rely on its answers."""
    return f"{agent} away"


def _concerned(machine: str, fact: CarrierChanged) -> tuple[str, ...]:
    """Whose trouble explains that a task has lost its carrier."""
    if fact.reason == Reason.GRACEFUL_SHUTDOWN:
        return (_away(fact.replaced),)
    if fact.reason == Reason.OUT_OF_SERVICE:
        return (_taken_out(fact.replaced),)
    return (machine, _away(machine), fact.replaced, fact.carrier)


def _taken_out(agent: str) -> str:
    """What stands for a person's having taken an agent out of service: that explains what it gives back for that, and nothing else."""
    return f"{agent} out of service"


def _touched(fault: Fault) -> str:
    if isinstance(fault, LaneBlocked | DoorFailed):
        return FLOOR
    if isinstance(fault, LoadDropped):
        # The vehicle stands, and what it has lost lies in the way of the others.
        return EVERYBODY
    return _away(fault.agent) if isinstance(fault, SentAway) else _agent(fault)


def _agent(fault: Fault) -> str:
    """Whom a fault is about; `EVERYBODY` for one that may touch anybody."""
    if isinstance(fault, PoweredOff | Crashed | JournalLost | ClockSet | SentAway | WlanCut | RadioCut):
        return fault.agent
    if isinstance(fault, MachineBroken):
        return fault.machine
    return fault.atv if isinstance(fault, VehicleBroken | LoadShifted) else EVERYBODY


def _can_lose(fault: Fault, sender: str, receiver: str) -> bool:
    if isinstance(fault, LinkTrouble):
        ends = fnmatchcase(sender, fault.sender) and fnmatchcase(receiver, fault.receiver)
        return fault.loss_frac > 0.0 and ends
    if isinstance(fault, RadioCut | ClockSet | LaneBlocked | DoorFailed | LoadDropped):
        return False
    return _agent(fault) in (EVERYBODY, sender, receiver)

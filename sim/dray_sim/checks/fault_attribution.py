"""Invariant 6 in reverse: no agent loses a contract without a reason.

When a carrier is replaced or a goal is taken from its machine, a recent fault must have touched one of the agents
concerned. This shows a failure that spreads to others. A request to leave is no such fault: the vehicle gives its
task back itself, or finishes it, and need not be missed. Neither is a process that restarts too soon to be missed,
nor a clock that was set.
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
"""Time by which the consequences of a fault are over: suspicions, waits for help, and people's work on it."""

HELD_UP_S = 5.0
"""A message that is overtaken, or doubled, comes so much later at most."""

HEARD_S = 0.5
"""A process that lives for less may have said nothing."""

EVERYBODY = ""

FLOOR = "the floor"
"""Stands for closures by people and obstacles on lanes, which may hold up any vehicle. No agent has a name with white
space."""


OUT_UNTIL_S: Mapping[str, float] = {CommandKind.TAKE_OUT: float("inf"), CommandKind.PUT_IN: 0.0}
"""How long a vehicle is out of service after a person's command, which explains that it gives work back."""


class _Spell(NamedTuple):
    """A fault, and when it was there."""

    fault: Fault
    begun_s: float
    ended_s: float
    """Infinity while it is there."""


class _Absence:
    """An absence of an agent's process."""

    __slots__ = ("back_s", "held_by", "since_s")

    def __init__(self, since_s: float) -> None:
        self.since_s = since_s
        self.back_s = float("inf")
        self.held_by: set[str] = set()
        """The faults that keep it away, by id."""


class FaultAttribution:
    """Knows all faults, and demands one when an agent loses a contract.

    Args:
        fleet: the vehicles.
        strategists: the agents that give goals out.
    """

    hears = (AtvHeartbeat, Event)

    def __init__(self, fleet: Container[str] = (), strategists: tuple[str, ...] = (STRATEGIST,)) -> None:
        self._fleet = fleet
        # Like the strategists' messages, the gate's count decides when a goal is lost.
        self.strategists = (*strategists, GATE)
        self._absences: dict[str, _Absence] = {}
        """The last one of each agent."""
        self._spells: dict[str, _Spell] = {}
        """Faults by id. A run has some dozens."""
        self._touched_s: dict[str, float] = {}
        """Until when an agent was last in trouble, or away (`_away`); `EVERYBODY` stands for the network."""
        self._stands: dict[str, None] = {}
        """Vehicles that are stopped or in error, for any cause."""

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
        """Mark an agent as a liar: any loss of its contracts is due to that."""
        self._touched_s[agent] = float("inf")

    def restrict(self, until_s: float) -> None:
        """Note that people close parts of the floor, or docks do not open, until then: work that is given back or late may be due to that."""
        self._touched_s[FLOOR] = max(until_s, self._touched_s.get(FLOOR, until_s))

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
        """Whether a message from one agent to another since then may have been lost."""
        return any(
            spell.ended_s >= since_s and _can_lose(spell.fault, sender, receiver)
            for spell in self._spells.values()
        )

    def delay_s(self, since_s: float) -> float:
        """Additional delay of a message since then."""
        troubles = [spell.fault for spell in self._spells.values() if spell.ended_s >= since_s]
        return sum(
            fault.latency_s
            + fault.jitter_s
            + (HELD_UP_S if fault.reorder_frac or fault.duplicate_frac else 0.0)
            for fault in troubles
            if isinstance(fault, LinkTrouble)
        )

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """Look for the causes of lost contracts.

        Raises:
            InvariantBroken: no agent had a fault.
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
        """Note a vehicle that waits, with right of way, for one in trouble: it is late for the same reason."""
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
        """End a crash; it counts as a fault when the process was away for long enough to be missed."""
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
    """Key of an agent that is away after a graceful shutdown: only agents that need its answers are in trouble."""
    return f"{agent} away"


def _concerned(machine: str, fact: CarrierChanged) -> tuple[str, ...]:
    """Keys whose trouble explains that a task has lost its carrier."""
    if fact.reason == Reason.GRACEFUL_SHUTDOWN:
        return (_away(fact.replaced),)
    if fact.reason == Reason.OUT_OF_SERVICE:
        return (_taken_out(fact.replaced),)
    return (machine, _away(machine), fact.replaced, fact.carrier)


def _taken_out(agent: str) -> str:
    """Key of an agent that a person took out of service: this explains only the work that it gives back for that."""
    return f"{agent} out of service"


def _touched(fault: Fault) -> str:
    if isinstance(fault, LaneBlocked | DoorFailed):
        return FLOOR
    if isinstance(fault, LoadDropped):
        # The vehicle stands, and its lost load lies in the way of others.
        return EVERYBODY
    return _away(fault.agent) if isinstance(fault, SentAway) else _agent(fault)


def _agent(fault: Fault) -> str:
    """The agent of a fault; `EVERYBODY` for a fault that may touch any agent."""
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

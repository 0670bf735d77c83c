"""Invariants 17 to 19: calls for help.

A call has one taker, no person takes two calls or one that they were not asked about, and no call is lost.

Like those of `dray_sim.checks.invariants`, these checks hear all messages, look at the agents, and take no part.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from math import inf

from msgspec import UNSET

from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    CallState,
    CommandKind,
    DutyStatus,
    Event,
    HelpCall,
    MachineHeartbeat,
    Message,
    OperatorHeartbeat,
    VehicleCommand,
)
from dray.messages.fact import CommandObeyed, MemoryLost
from dray.messages.fact.base import Fact
from dray.protocol.vehicle.people.command_handling import ALONE, DOUBLED
from dray_sim.checks.broken import InvariantBroken
from dray_sim.people.duty import PersonOnDuty

STOPS_ITSELF = frozenset({ALONE, DOUBLED})
"""Problems with which a vehicle stops itself, also one that a person has stopped before."""

STOP_HEARD_S = 5.0
"""Longest time from a person's stop to its vehicle's doing, and to the end of that life, if the vehicle cannot tell any more."""

LOST_S = 60.0
"""Longest time without a call: a vehicle or a machine that needs a person calls at once. One with a problem that may
pass calls after half a minute, and repeats its call every 5 s."""


class OneTakerEach:
    """Invariant 17: no two operators are expected for one turn of one call, and no operator for two calls.

    Invariant 18: an expected operator has answered: people are asked and never assigned.
    """

    hears = (HelpCall, OperatorHeartbeat)

    def __init__(self, people: Iterable[PersonOnDuty]) -> None:
        self._people = tuple(people)
        self._own = {person.agent_id: person for person in self._people}
        self._turns: dict[tuple[str, int], str] = {}
        """Operator by call and turn, as the caller has said."""
        self._lives: dict[str, int] = {}
        """Newest life that was heard, by operator."""

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """Note one utterance.

        Raises:
            InvariantBroken: see the class.
        """
        if type(message) is HelpCall:
            self._note(message, at_s)
        elif type(message) is OperatorHeartbeat:
            self._count(message, sender, at_s)

    def _note(self, call: HelpCall, at_s: float) -> None:
        if call.state is CallState.TAKEN and (not call.taken_by or call.asked):
            raise InvariantBroken(
                17, at_s, f"{call.call} is taken by {call.taken_by!r}, and asks {call.asked}"
            )
        if call.taken_by and call.state is not CallState.ENDED:
            before = self._turns.setdefault((call.call, call.turn), call.taken_by)
            if before != call.taken_by:
                raise InvariantBroken(17, at_s, f"{call.call} was taken by {before} and by {call.taken_by}")
            duty = self._own.get(call.taken_by)
            if duty is not None and not duty.has_taken(call.subject):
                raise InvariantBroken(
                    18, at_s, f"{call.taken_by} was assigned {call.call}, and has not taken it"
                )
        expected: dict[tuple[str, int], str] = {}
        for person in self._people:
            agent = person.agent
            taken = None if agent is None else agent.taken
            if taken is not None and expected.setdefault(taken, person.agent_id) != person.agent_id:
                seen = f"{expected[taken]} and {person.agent_id} both believe that they have {taken[0]}"
                raise InvariantBroken(17, at_s, seen)

    def _count(self, heartbeat: OperatorHeartbeat, sender: str, at_s: float) -> None:
        """Each person has one agent: an older life of it is silent after a newer one was heard."""
        newest = self._lives.get(sender, 0)
        if heartbeat.incarnation < newest and not heartbeat.draining:
            raise InvariantBroken(
                17, at_s, f"{sender} is counted twice: life {heartbeat.incarnation} after {newest}"
            )
        self._lives[sender] = max(newest, heartbeat.incarnation)
        if heartbeat.caller and heartbeat.status is not DutyStatus.BUSY:
            raise InvariantBroken(
                17, at_s, f"{sender} is {heartbeat.status}, and busy with {heartbeat.caller}"
            )


class NoCallIsLost:
    """Invariant 19: a vehicle or a machine that cannot go on without a person calls, and goes on calling until it can.

    A vehicle that stands stopped, and that no person has stopped, has stopped itself: it calls until a person has
    acknowledged that. Without its memory it no longer knows who has stopped it.

    What people know of is one stop. It ends when the vehicle is heard in another status, whatever the reason: a person has let it go
    on, or its next life has a body that is not held. It also ends when the vehicle stops itself on top of it.

    The time between the last heartbeat of one life and the first of the next does not count: the agent may not run.

    Args:
        excused: called with a vehicle or machine; returns whether it is off, off the floor, or held up by a fault of
            its own.
    """

    hears = (VehicleCommand, HelpCall, AtvHeartbeat, MachineHeartbeat, Event)

    def __init__(self, excused: Callable[[str], bool] = lambda _agent: False) -> None:
        self._excused = excused
        self._since_s: dict[str, float] = {}
        """Beginning of a problem, or time of the last call, by vehicle or machine."""
        self._heard: dict[str, tuple[int, float]] = {}
        """Last known life, and when that was heard, by vehicle or machine."""
        self._stopped_itself: set[str] = set()
        self._known: set[str] = set()
        """Vehicles whose present stop people know of: they have given it or acknowledged it."""
        self._asked_s: dict[str, float] = {}
        """Time of the last stop that was sent, by vehicle."""
        self._forgot: set[str] = set()
        """Agents that have lost their memory, and were not heard since."""

    def on_message(self, at_s: float, sender: str, address: str, message: Message) -> None:
        """Note one utterance.

        Raises:
            InvariantBroken: see the class.
        """
        if type(message) is VehicleCommand:
            if message.kind is CommandKind.STOP:
                self._asked_s[address.removeprefix(">")] = at_s
        elif type(message) is HelpCall:
            if not message.goods and message.state is not CallState.ENDED and sender in self._since_s:
                self._since_s[sender] = at_s
        elif isinstance(message, AtvHeartbeat | MachineHeartbeat) and sender == _of(message):
            self._note(message, sender, at_s)
        elif type(message) is Event and sender == message.agent:
            self._note_fact(message.fact, sender)

    def _note_fact(self, fact: Fact, agent: str) -> None:
        if type(fact) is MemoryLost:
            self._forgot.add(agent)
        elif type(fact) is CommandObeyed and fact.done:
            # A stop of one that stands already is no acknowledgement.
            is_stop = fact.what == CommandKind.STOP and agent not in self._stopped_itself
            if is_stop or fact.what == CommandKind.ACKNOWLEDGE:
                self._known.add(agent)
            elif fact.what == CommandKind.RESUME:
                # It may stop itself before it is heard in another status.
                self._known.discard(agent)

    def _note(self, heartbeat: AtvHeartbeat | MachineHeartbeat, agent: str, at_s: float) -> None:
        life, heard_s = self._heard.get(agent, (heartbeat.incarnation, at_s))
        self._heard[agent] = (heartbeat.incarnation, at_s)
        if life != heartbeat.incarnation:
            if agent in self._since_s:
                self._since_s[agent] += at_s - heard_s
        self._judge_stop(heartbeat, agent, heard_s if life != heartbeat.incarnation else None)
        why = heartbeat.problem or ("stopped itself" if agent in self._stopped_itself else "")
        if not why or not _may_call(heartbeat) or self._excused(agent):
            self._since_s.pop(agent, None)
        elif at_s - self._since_s.setdefault(agent, at_s) > LOST_S:
            lost_s = at_s - self._since_s[agent]
            raise InvariantBroken(19, at_s, f"{agent} has had {why!r} for {lost_s:.0f} s and calls nobody")

    def _judge_stop(
        self, heartbeat: AtvHeartbeat | MachineHeartbeat, agent: str, ended_s: float | None
    ) -> None:
        """Note whether it has stopped itself; `ended_s` is the end of the life before, in the first heartbeat of the next one."""
        forgot = agent in self._forgot
        self._forgot.discard(agent)
        if heartbeat.status is not AtvStatus.STOPPED:
            self._stopped_itself.discard(agent)
            self._known.discard(agent)
            return
        if heartbeat.problem in STOPS_ITSELF:
            self._known.discard(agent)
        was_asked = ended_s is not None and self._asked_s.get(agent, -inf) > ended_s - STOP_HEARD_S
        if forgot or (was_asked and agent not in self._stopped_itself):
            self._known.add(agent)
        if agent in self._known:
            self._stopped_itself.discard(agent)
        else:
            self._stopped_itself.add(agent)


def _may_call(heartbeat: AtvHeartbeat | MachineHeartbeat) -> bool:
    return heartbeat.out_of_service is UNSET and not heartbeat.draining


def _of(heartbeat: AtvHeartbeat | MachineHeartbeat) -> str:
    return heartbeat.atv if isinstance(heartbeat, AtvHeartbeat) else heartbeat.machine

"""Invariant 3 in reverse: a task that is given out again binds no other vehicle.

A coordinator that gives up on an award says so. A vehicle that has taken the contract meanwhile ends it as soon as it
hears that. Vehicles that may have lost this message are not judged: they hear at the dock that their contract is
void.
"""

from __future__ import annotations

from dataclasses import dataclass

from dray.messages import Event, Message, Phase, Role, Transport
from dray.messages.fact import (
    AwardAnswered,
    AwardGiven,
    ContractEnded,
    ContractTaken,
    PhaseEntered,
    TaskOpened,
)
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.fault_attribution import FaultAttribution
from dray_sim.factory.sim_factory import SimFactory

HEED_S = 30.0
"""Longest reaction time: a pick that has begun goes on to its end, which takes 20 s, and a message needs a moment."""

LOOK_S = 1.0

Key = tuple[str, str, int]
"""A vehicle, a task and an epoch."""


@dataclass(slots=True)
class _GivenUp:
    """An award that its coordinator gave up on."""

    coordinator: str
    since_s: float


class StaleContracts:
    """Watches awards that were not answered in time.

    Args:
        factory: tells which agents are running.
        attribution: tells which messages may have been lost.
    """

    def __init__(self, factory: SimFactory, attribution: FaultAttribution) -> None:
        self._factory = factory
        self._attribution = attribution
        self._transports: dict[str, None] = {}
        self._given_up: dict[Key, _GivenUp] = {}
        self._bound: dict[Key, float] = {}
        """Contracts that vehicles believe in, and since when they could have ended them."""
        self._loading: set[Key] = set()
        """Those of these contracts whose pick has begun."""
        self._look_s = 0.0

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """Note awards and contracts.

        Raises:
            InvariantBroken: a vehicle holds on to a contract that it must know to be void.
        """
        if type(message) is Event:
            self._note(message, sender, at_s)
        if at_s >= self._look_s:
            self._look_s = at_s + LOOK_S
            for key in list(self._given_up):
                self._look(key, at_s)

    def _note(self, event: Event, agent: str, at_s: float) -> None:
        fact = event.fact
        if type(fact) is TaskOpened:
            if type(fact.work) is Transport:
                self._transports[fact.task] = None
        elif type(fact) is AwardGiven:
            # The bidder was asked once more, and its new answer is another matter.
            self._given_up.pop((fact.bidder, fact.task, fact.epoch), None)
        elif type(fact) is AwardAnswered:
            if fact.bidder not in self._factory.workers:
                return  # A liar never tells whether it believes to be bound.
            if fact.role is Role.PRIMARY and fact.answer == "silent" and fact.task in self._transports:
                self._given_up[fact.bidder, fact.task, fact.epoch] = _GivenUp(agent, at_s)
        elif type(fact) is ContractTaken:
            if fact.role is Role.PRIMARY:
                self._bound[agent, fact.task, fact.epoch] = at_s
        elif type(fact) is ContractEnded:
            if fact.role is Role.PRIMARY:
                self._bound.pop((agent, fact.task, fact.epoch), None)
                self._loading.discard((agent, fact.task, fact.epoch))
        elif type(fact) is PhaseEntered:
            self._note_phase((agent, fact.task, fact.epoch), fact.phase)

    def _note_phase(self, key: Key, phase: Phase) -> None:
        self._loading.discard(key)
        if phase is Phase.LOADING:
            self._loading.add(key)
        elif phase is Phase.RETURNING:
            # The vehicle knows, and brings its load back.
            self._bound.pop(key, None)

    def _look(self, key: Key, at_s: float) -> None:
        atv, task, epoch = key
        given_up = self._given_up[key]
        if not self._factory.running(atv):
            self._bound.pop(key, None)
        bound_s = self._bound.get(key)
        lost = self._attribution.may_have_lost(given_up.coordinator, atv, given_up.since_s)
        if lost or not self._factory.running(given_up.coordinator):
            del self._given_up[key]
            return
        if bound_s is None:
            return
        if key in self._loading and self._factory.vehicles[atv].stopped:
            # A pick that is held half-way goes on to its end when the vehicle may move again.
            self._bound[key] = at_s
            return
        knows_s = max(given_up.since_s, bound_s) + HEED_S + self._attribution.delay_s(given_up.since_s)
        if at_s > knows_s:
            seen = (
                f"{atv} believes to carry {task} (epoch {epoch}), on which {given_up.coordinator} gave up "
                f"{at_s - given_up.since_s:.0f} s ago"
            )
            raise InvariantBroken(3, at_s, seen)

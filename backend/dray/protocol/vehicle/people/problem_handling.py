"""A vehicle's handling of a reported problem: it stands, judges it, asks for help, and reports its duration.

All vehicles learn from the durations of others' problems (`ProblemEnded`); a lost message costs only experience.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from dray.body import ProblemCleared, ProblemRaised, VehicleState
from dray.memory import ProblemMemory
from dray.messages import NOTHING_KNOWN, Link, Message, Problem, ProblemEnded, ProblemKind, Reason
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.calls.help_calls import HelpCalls
from dray.protocol.people.patience import Experience, calls_after_s, since_s, waits_for_people
from dray.protocol.runtime.life import Life
from dray.protocol.vehicle.contracts import Contracts
from dray.protocol.vehicle.drivers.driver import Driver
from dray.protocol.vehicle.people.command_handling import ALONE, DOUBLED, CommandHandling


class Owner(Protocol):
    """The vehicle, as its problems need it."""

    id: str
    incarnation: int

    @property
    def link(self) -> Link:
        """The link that it uses."""

    def end_trouble(self, now_s: float) -> None:
        """End one reason to stand; drive on if there is no other."""

    def update_status(self, now_s: float, reason: str) -> None:
        """Update the status, and report the reason if it has changed."""

    @property
    def is_busy(self) -> bool:
        """Whether it has a task."""

    @property
    def is_draining(self) -> bool:
        """Whether it was asked to leave."""


NO_WLAN = "no WLAN"
"""The call's reason in words; panels know it (`failure.` in their texts)."""

DOUBLED_S = 60.0
"""Silence after which the other user of its id counts as stopped (s). Then a person may release the vehicle."""

WLAN_LOST = Problem(kind=ProblemKind.LINK, needs_person=True)

WLAN_LOST_S = 10.0
"""Minimum time without WLAN before a call (s): a dead spot is crossed in less."""


class _Caller:
    """The vehicle in the form that calls need."""

    def __init__(self, owner: Owner, driver: Driver) -> None:
        self._owner, self._driver = owner, driver
        self.id, self.incarnation = owner.id, owner.incarnation

    @property
    def place_m(self) -> tuple[float, float]:
        return self._driver.position_m

    @property
    def hears_all(self) -> bool:
        return self._owner.link is Link.WLAN


class ProblemHandling:
    """The problems of one vehicle.

    Args:
        owner: the vehicle.
        plant: its plant.
        driver: its driver.
        contracts: its contracts.
        commands: people's commands, and its requests to them.

    Attributes:
        calls: its own calls for help.
        messages: by message type, handlers called with (sender, message, now_s).
        reports: by report type, handlers called with (report, now_s).
        alarms: by name, handlers called with (None, now_s).
    """

    def __init__(
        self,
        owner: Owner,
        plant: Plant,
        driver: Driver,
        contracts: Contracts,
        commands: CommandHandling,
        life: Life,
    ) -> None:
        self._owner = owner
        self._keys = Keys(plant.id)
        self._contracts = contracts
        self._commands = commands
        self._assistance = commands.assistance
        self._life = life
        self._experience = Experience()
        self.calls = calls = HelpCalls(_Caller(owner, driver), plant, life)
        self._since_s = self._comes_after_s = 0.0
        self.messages: dict[type[Message], Callable[[str, Any, float], None]] = {
            ProblemEnded: self._on_ended,
            **calls.message_handlers,
        }
        self.alarms = {
            **calls.alarms,
            DOUBLED: lambda _about, now_s: self.end_problem(DOUBLED, now_s),
        }
        self.reports: dict[type, Callable[[Any, float], None]] = {
            ProblemRaised: self.raise_problem,
            ProblemCleared: self._problem_cleared,
        }

    def start(self, state: VehicleState, memory: ProblemMemory | None, now_s: float) -> None:
        """Restore the body's problem, which an earlier life may have known, and subscribe."""
        self._life.subscribe(self._keys.all_problems)
        self.calls.listen()
        self._assistance.problem, self._assistance.about = state.problem, state.about_problem
        self._since_s = since_s(memory, state.about_problem, now_s)
        if state.problem:
            self._life.commit()

    @property
    def memory(self) -> ProblemMemory | None:
        """The present problem's record for the next life."""
        assistance = self._assistance
        return ProblemMemory(assistance.about.kind, self._since_s) if assistance.problem else None

    def raise_problem(self, report: ProblemRaised, now_s: float) -> None:
        """Stand until the problem is over."""
        assistance = self._assistance
        if not assistance.problem or report.problem.kind is not assistance.about.kind:
            self._since_s, self._comes_after_s = now_s, self.calls.comes_after_s(now_s)
            self._life.commit()
        assistance.problem, assistance.about = report.reason, report.problem
        if self._commands.take_back():
            self._life.commit()
        job = self._contracts.job
        if job is not None:
            usual_s = self._experience.usual_s(report.problem, now_s, self._comes_after_s)
            assistance.ask(job.waiting(now_s), usual_s, now_s)
        self._contracts.standby.resign(Reason.PROBLEM)
        self._owner.update_status(now_s, report.reason)
        self._life.beat_soon(now_s)

    def note_doubled(self, now_s: float) -> None:
        """Another agent uses its id: stop until a person has come and the other has been silent for a while.

        The problem ends with the silence. The call goes on until a person has come, who otherwise would not know of
        it.
        """
        self._commands.stop_itself(DOUBLED)
        self._life.alarm(DOUBLED, now_s + DOUBLED_S)
        self.raise_problem(ProblemRaised(reason=DOUBLED), now_s)

    def note_alone(self, now_s: float) -> None:
        """Others drive with right of way, and it drives without: stop until it was started as they were.

        The call goes on in its next life until a person has come. Harmless when repeated.
        """
        if not self._commands.stopped_itself:
            self._commands.stop_itself(ALONE)
        if not self._assistance.problem:
            self.raise_problem(ProblemRaised(reason=ALONE), now_s)

    def update_call(self, now_s: float) -> None:
        """Open and close the call for a person.

        Out of service it calls nobody: people know of it. A problem that may pass by itself gets time first. A lost
        WLAN is no reason for a call before the delivery is done (paper, 4.3).
        """
        problem, owner = self._assistance.problem, self._owner
        is_well = not problem and not self._commands.stopped_itself and owner.link is not Link.MESH
        if is_well or self._commands.out_of_service is not None or owner.is_draining:
            self.calls.close(now_s)
        elif problem:
            about = self._assistance.about
            self.calls.open(about, problem, now_s, after_s=calls_after_s(about, now_s - self._since_s))
        elif self._commands.stopped_itself:
            self.calls.open(NOTHING_KNOWN, self._commands.stop_cause, now_s)
        elif not owner.is_busy and not self._commands.stopped:
            self.calls.open(WLAN_LOST, NO_WLAN, now_s, after_s=WLAN_LOST_S)
        else:
            self.calls.close(now_s)

    def not_coming(self, since_s: float, now_s: float) -> None:
        """The person expected since then does not come: later promises are void."""
        if self._assistance.not_coming(since_s):
            self._life.beat_soon(now_s)

    def end_problem(self, reason: str, now_s: float) -> None:
        """End one of the vehicle's own problems, unless another one has replaced it."""
        if self._assistance.problem == reason:
            self._problem_cleared(ProblemCleared(), now_s)

    def _problem_cleared(self, _report: ProblemCleared, now_s: float) -> None:
        assistance = self._assistance
        if assistance.problem:
            lasted_s = max(0.0, now_s - self._since_s)
            ended = ProblemEnded(agent=self._owner.id, problem=assistance.about, lasted_s=lasted_s)
            # A problem that began in people's absence does not show how long people take.
            if not (self._comes_after_s and waits_for_people(assistance.about)):
                self._experience.note(ended, "", now_s)
                if self._owner.link is Link.WLAN and assistance.about != NOTHING_KNOWN:
                    self._life.publish(self._keys.problem(self._owner.id), ended)
            self._life.commit()
        assistance.problem, assistance.about = "", NOTHING_KNOWN
        self._owner.end_trouble(now_s)
        self._owner.update_status(now_s, "problem cleared")

    def _on_ended(self, sender: str, message: ProblemEnded, now_s: float) -> None:
        if sender != self._owner.id:
            self._experience.note(message, sender, now_s)

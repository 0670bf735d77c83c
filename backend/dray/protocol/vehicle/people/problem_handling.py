"""What a vehicle does about a problem that its body reports: it stands, judges it, asks for help, and tells how long it has lasted.

All vehicles hear how long the problems of others have lasted (`ProblemEnded`): a lost word of that costs nothing but experience.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from dray.body import ProblemCleared, ProblemRaised, VehicleState
from dray.messages import NOTHING_KNOWN, Link, Message, Problem, ProblemEnded, ProblemKind, Reason
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.calls.help_calls import HelpCalls
from dray.protocol.people.patience import PASSES_AT_FIRST_S, Experience, waits_for_people
from dray.protocol.runtime.life import Life
from dray.protocol.vehicle.contracts import Contracts
from dray.protocol.vehicle.drivers.driver import Driver
from dray.protocol.vehicle.people.command_handling import CommandHandling


class Owner(Protocol):
    """A vehicle, as far as its problems need it."""

    id: str
    incarnation: int

    @property
    def link(self) -> Link:
        """By which it speaks."""

    def end_trouble(self, now_s: float) -> None:
        """End one reason to stand; drive on when no other is left."""

    def update_status(self, now_s: float, reason: str) -> None:
        """Work the status out anew, and tell the reason if it has changed."""

    @property
    def is_busy(self) -> bool:
        """Whether it has a task."""

    @property
    def is_draining(self) -> bool:
        """Whether it was asked to leave."""


NO_WLAN = "no WLAN"
"""What a vehicle calls for in words; panels know them (`failure.` in their texts)."""

DOUBLED = "its name is used by another"
"""Likewise. Also the alarm that ends that."""

DOUBLED_S = 60.0
"""Whoever has spoken under its name has stopped when nothing more is heard of that for so long. Then a person may let the vehicle go."""

WLAN_LOST = Problem(kind=ProblemKind.LINK, needs_person=True)

WLAN_LOST_S = 10.0
"""A dead spot is crossed in less."""


class _Caller:
    """A vehicle as its calls see it."""

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
        plant: where it drives.
        driver: of the vehicle.
        contracts: of the vehicle.
        commands: what people have told it, and what it asks them for.

    Attributes:
        messages: by the type of a message, what to call with (sender, message, now_s).
        reports: by the type of a report, what to call with (report, now_s).
        alarms: by name, what to call with (None, now_s).
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
        self._calls = calls = HelpCalls(_Caller(owner, driver), plant, life, self._not_coming)
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

    def start(self, state: VehicleState, now_s: float) -> None:
        """Go on with what the body knows, and listen."""
        self._life.subscribe(self._keys.all_problems)
        self._calls.listen()
        self._assistance.problem, self._assistance.about = state.problem, state.about_problem
        self._since_s = now_s

    def raise_problem(self, report: ProblemRaised, now_s: float) -> None:
        """Stand until the problem is over."""
        assistance = self._assistance
        if not assistance.problem or report.problem.kind is not assistance.about.kind:
            self._since_s, self._comes_after_s = now_s, self._calls.comes_after_s(now_s)
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
        """Somebody else speaks under its name: stop until a person has seen to it, and that one has been quiet for a while.

        The problem ends with the quiet, and the call goes on until a person has come: nobody else knows that the vehicle stands.
        """
        self._commands.stop_itself()
        self._life.alarm(DOUBLED, now_s + DOUBLED_S)
        self.raise_problem(ProblemRaised(reason=DOUBLED), now_s)

    def update_call(self, now_s: float) -> None:
        """Call somebody while a person is needed, and nobody longer than that.

        Out of service it calls nobody: people know of it. What may pass by itself is waited for first. A lost WLAN is no reason to come
        before the delivery is done (paper, 4.3).
        """
        problem, owner = self._assistance.problem, self._owner
        is_well = not problem and not self._commands.stopped_itself and owner.link is not Link.MESH
        if is_well or self._commands.out_of_service is not None or owner.is_draining:
            self._calls.close(now_s)
        elif problem:
            about = self._assistance.about
            waits = about.passes is True and not about.needs_person
            self._calls.open(about, problem, now_s, after_s=PASSES_AT_FIRST_S if waits else 0.0)
        elif self._commands.stopped_itself:
            self._calls.open(NOTHING_KNOWN, DOUBLED, now_s)
        elif not owner.is_busy and not self._commands.stopped:
            self._calls.open(WLAN_LOST, NO_WLAN, now_s, after_s=WLAN_LOST_S)
        else:
            self._calls.close(now_s)

    def _not_coming(self, since_s: float, now_s: float) -> None:
        if self._assistance.not_coming(since_s):
            self._life.beat_soon(now_s)

    def end_problem(self, reason: str, now_s: float) -> None:
        """One of the vehicle's own is over, unless another one has replaced it since."""
        if self._assistance.problem == reason:
            self._problem_cleared(ProblemCleared(), now_s)

    def _problem_cleared(self, _report: ProblemCleared, now_s: float) -> None:
        assistance = self._assistance
        if assistance.problem:
            lasted_s = max(0.0, now_s - self._since_s)
            ended = ProblemEnded(agent=self._owner.id, problem=assistance.about, lasted_s=lasted_s)
            # What began while nobody was there teaches nothing about how long people take.
            if not (self._comes_after_s and waits_for_people(assistance.about)):
                self._experience.note(ended, "", now_s)
                if self._owner.link is Link.WLAN and assistance.about != NOTHING_KNOWN:
                    self._life.publish(self._keys.problem(self._owner.id), ended)
        assistance.problem, assistance.about = "", NOTHING_KNOWN
        self._owner.end_trouble(now_s)
        self._owner.update_status(now_s, "problem cleared")

    def _on_ended(self, sender: str, message: ProblemEnded, now_s: float) -> None:
        if sender != self._owner.id:
            self._experience.note(message, sender, now_s)

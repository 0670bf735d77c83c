"""People's commands to a machine (paper, case 1), and about goods on board of a failed vehicle.

Promise help, clear a fault, hand over, work slowly, restart, update, out of service; fetch goods, write them off; a
disputed load is there, or missing. If the body is people, their reports of what has happened.

Every command needs a grant: for the machine's area, or for the place of the goods or of a load's destination
(invariant 9). Commands that the body or the agent's operator cannot carry out are refused with that reason.
"""

from __future__ import annotations

from typing import Protocol

from dray.body import ResetFault, SetPace, WorkcellState
from dray.memory import CommandMemory, MachineMemory
from dray.messages import CommandRefusal, Grant, MachineCommand, MachineCommandKind, PeopleAsBody
from dray.messages.heartbeat import LOADS_TOLD
from dray.protocol.machine.people.breakdown import Breakdown
from dray.protocol.people.command_authorisation import CommandAuthorisation
from dray.protocol.people.granted_commands import GrantedCommands
from dray.protocol.people.out_of_service import ServiceState
from dray.protocol.people.words import PassedWords
from dray.protocol.runtime.life import Life
from dray.protocol.runtime.running import Running

NOTHING_RESTARTS = "nobody starts its agent again here"
NO_UPDATES = "its software is not replaced from here: use dray fleet update, or what starts it"
ONE_SPEED = "its body has one speed only"
NO_PEOPLE = "its controller counts, and nobody else"
"""Explanations of refusals, for people."""


class Owner(Protocol):
    """The machine, as its commands need it."""

    speed_frac: float
    """Fraction of its full speed, used in its estimates."""

    def leave(self, now_s: float, *, update: bool) -> None:
        """Shut down gracefully for a restart."""


class Goods(Protocol):
    """The goods of a machine that were left on board of failed vehicles."""

    def fetch(self, task: str, node: str, now_s: float) -> CommandRefusal | None:
        """A person hands them over at a node. Returns the refusal; None when they are fetched there now."""

    def write_off(self, task: str, now_s: float) -> CommandRefusal | None:
        """A person writes them off. Returns the refusal; None when they are made again now."""

    def place_m(self, task: str) -> tuple[float, float] | None:
        """Their position (x, y) in m; None if unknown."""


class Held(Protocol):
    """Its transports that are held until a person has looked for their loads."""

    def obey(self, command: MachineCommand, now_s: float) -> CommandRefusal | None:
        """A person has looked. Returns the refusal; None when the transport has ended or goes on."""

    def place_m(self, task: str) -> tuple[float, float] | None:
        """The destination of a held transport's load (x, y) in m; None if it is not held."""


class MachineCommandHandling:
    """People's commands to one machine.

    Args:
        authority: checks who may command it.
        breakdown: its breakdown.
        owner: the machine.
        goods: goods that wait for a decision.
        held: its held transports.
        running: what its operator can do with its agent's process.

    Attributes:
        service: whether it is out of service.
        paces: whether its body can work at a fraction of its speed.
        people: the loads that wait for people's reports, if people are its body; else None.
        words: people's reports on their way to the body.
    """

    def __init__(
        self,
        authority: CommandAuthorisation,
        breakdown: Breakdown,
        owner: Owner,
        goods: Goods,
        held: Held,
        running: Running,
        life: Life,
    ) -> None:
        self._breakdown = breakdown
        self._goods, self._held = goods, held
        self._owner = owner
        self._running = running
        self._life = life
        self._granted = GrantedCommands[MachineCommand](authority, self._try, self._detail, life)
        self.service = ServiceState()
        self.paces = False
        self.people: PeopleAsBody | None = None
        self.words = PassedWords(self._granted, life)

    def sense(self, body: WorkcellState) -> bool:
        """Note the loads that wait for people's reports; returns whether that has changed."""
        people = PeopleAsBody(loads=body.loads[:LOADS_TOLD]) if body.people else None
        is_news, self.people = people != self.people, people
        return is_news

    def on_command(
        self, sender: str, command: MachineCommand, place_m: tuple[float, float], now_s: float
    ) -> None:
        """Handle a command (`GrantedCommands.on_command`); one about a load needs a grant for the load's place."""
        if command.kind.is_about_held:
            place_m = self._held.place_m(command.task) or place_m
        if command.kind.is_about_goods:
            place_m = self._goods.place_m(command.task) or place_m
        if command.kind.is_word and self.people is not None:
            self.words.pass_on(sender, command, (place_m,), now_s)
        else:
            self._granted.on_command(sender, command, place_m, now_s)

    def restore(self, memory: MachineMemory) -> None:
        """Restore an earlier life's commands."""
        self.service.out = memory.out_of_service
        self._granted.restore(memory.answered)
        if memory.speed_frac < 1.0 and self.paces:
            self._set_speed(memory.speed_frac)

    @property
    def answered(self) -> tuple[CommandMemory, ...]:
        """Commands for the next life, which would obey them if they were repeated."""
        return self._granted.answered

    def _try(self, command: MachineCommand, grant: Grant, now_s: float) -> CommandRefusal | None:
        """Carry a command out, or return the refusal."""
        kind, by = command.kind, command.issued_by or grant.person
        if kind is MachineCommandKind.PROMISE:
            return self._breakdown.promise(by, command.wait_s, now_s)
        if kind is MachineCommandKind.HAND_OVER:
            return self._breakdown.let_go(now_s)
        if kind is MachineCommandKind.CLEAR_FAULT:
            return self._clear_fault()
        if kind is MachineCommandKind.SET_SPEED:
            return self._set_speed(command.speed_frac)
        if kind is MachineCommandKind.FETCH_GOODS:
            return self._goods.fetch(command.task, command.node, now_s)
        if kind is MachineCommandKind.WRITE_OFF:
            return self._goods.write_off(command.task, now_s)
        if kind.is_about_held:
            return self._held.obey(command, now_s)
        if kind.is_word:
            return CommandRefusal.NOT_SUPPORTED
        if kind is MachineCommandKind.TAKE_OUT:
            return self.service.take_out(command, by, now_s)
        if kind is MachineCommandKind.PUT_IN:
            return CommandRefusal.FAULTY if self._breakdown.problem else self.service.put_in()
        return self._start_again(now_s, update=kind is MachineCommandKind.UPDATE)

    def _clear_fault(self) -> CommandRefusal | None:
        """Work again if the sensors find no fault any more."""
        if not self._breakdown.problem:
            return CommandRefusal.NOT_FAULTY
        if not self._breakdown.resettable:
            return CommandRefusal.FAULTY
        self._life.instruct(ResetFault())
        return None

    def _set_speed(self, speed_frac: float | None) -> CommandRefusal | None:
        if speed_frac is None or not 0.0 < speed_frac <= 1.0:
            return CommandRefusal.SPEED_OUT_OF_RANGE
        if not self.paces:
            return CommandRefusal.NOT_SUPPORTED
        self._owner.speed_frac = speed_frac
        self._life.instruct(SetPace(speed_frac))
        return None

    def _start_again(self, now_s: float, *, update: bool) -> CommandRefusal | None:
        if not self._running.starts_again or (update and not self._running.updates):
            return CommandRefusal.NOT_SUPPORTED
        self._owner.leave(now_s, update=update)
        return None

    def _detail(self, command: MachineCommand, refused: CommandRefusal) -> str:
        if refused is CommandRefusal.FAULTY:
            return self._breakdown.problem
        if refused is not CommandRefusal.NOT_SUPPORTED:
            return ""
        if command.kind is MachineCommandKind.SET_SPEED:
            return ONE_SPEED
        if command.kind.is_word:
            return NO_PEOPLE
        return NO_UPDATES if self._running.starts_again else NOTHING_RESTARTS

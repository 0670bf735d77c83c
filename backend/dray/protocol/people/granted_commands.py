"""People's commands to an agent: each needs a grant for the place, and a repeated command gets the same answer.

A known command is only answered again, however late it comes. A stop that the network delivers after the resume
must not stop the vehicle when no person looks after it any more.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Generic, TypeVar

from dray.memory import CommandMemory
from dray.messages import CommandAnswered, CommandRefusal, Grant, MachineCommand, VehicleCommand
from dray.messages.fact import CommandObeyed
from dray.protocol.people.command_authorisation import CommandAuthorisation
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.life import Life

COMMANDS_KEPT = 32
"""Maximum remembered commands. Their senders repeat them until they are answered, and people give few: a repeated or late
command is among the last ones."""

C = TypeVar("C", VehicleCommand, MachineCommand)

Answer = tuple[CommandRefusal | None, str]
"""The reason to refuse a command, and its detail."""


class GrantedCommands(Generic[C]):
    """The commands to one agent.

    Args:
        authority: checks who may command it.
        attempt: carries a command out, or returns the refusal; called with (command, grant, now_s).
        detail: explains a refusal.
    """

    def __init__(
        self,
        authority: CommandAuthorisation,
        attempt: Callable[[C, Grant, float], CommandRefusal | None],
        detail: Callable[[C, CommandRefusal], str],
        life: Life,
    ) -> None:
        self._authority = authority
        self._attempt: Callable[[C, Grant, float], CommandRefusal | None] = attempt
        self._detail: Callable[[C, CommandRefusal], str] = detail
        self._life = life
        self._answered: BoundedMap[tuple[str, str], CommandMemory] = BoundedMap(COMMANDS_KEPT)
        """Results of the last commands, by person and command, the oldest first. Only commands with a grant are kept, so
        that no stranger can displace one."""
        self._asked_s = 0.0
        """When the last of them was new."""

    def on_command(self, sender: str, command: C, place_m: tuple[float, float], now_s: float) -> bool:
        """Carry a command out or refuse it, and answer.

        Args:
            sender: the agent to answer; the grant decides.
            command: the command.
            place_m: the agent's position (x, y) in m.
            now_s: the present time.

        Returns:
            Whether it was carried out now.
        """
        grant = self._grant_of(sender, command)
        if grant is None:
            return False
        before = self._answered.get((grant.person, command.command))
        if before is not None:
            self._life.send(sender, _answer(command, before.refused, before.detail))
            return False
        if now_s > grant.valid_until_s:
            self._refuse(sender, command, CommandRefusal.EXPIRED)
            return False
        if self._authority.covers(command, grant, *place_m):
            refused = self._attempt(command, grant, now_s)
            self._life.settle(now_s)
            detail = "" if refused is None else self._detail(command, refused)
            self._tell(sender, command, refused, detail)
        else:
            refused, detail = CommandRefusal.NOT_HERE, ""
            self._refuse(sender, command, refused)
        self._note(CommandMemory(command.command, grant.person, grant.valid_until_s, refused, detail), now_s)
        return refused is None

    def permits(
        self,
        sender: str,
        command: C,
        places_m: Iterable[tuple[float, float]],
        now_s: float,
        answers: Mapping[str, Answer],
    ) -> Grant | None:
        """The valid grant of a command that is carried out and answered elsewhere (`tell`); None after an answer.

        It covers at least one of `places_m`. A late copy of a command is answered as the command was.

        Args:
            sender: the agent to answer; the grant decides.
            command: the command.
            places_m: the places that it is about (x, y) in m.
            now_s: the present time.
            answers: given before, by `key_of`.
        """
        grant = self._grant_of(sender, command)
        if grant is None:
            return None
        if now_s > grant.valid_until_s:
            before = answers.get(key_of(command, grant))
            if before is None:
                self._refuse(sender, command, CommandRefusal.EXPIRED)
            else:
                self.tell(sender, command, *before, again=True)
            return None
        if not any(self._authority.covers(command, grant, *place_m) for place_m in places_m):
            self._refuse(sender, command, CommandRefusal.NOT_HERE)
            return None
        return grant

    def tell(
        self, sender: str, command: C, refused: CommandRefusal | None, detail: str, *, again: bool
    ) -> None:
        """Report the result of a command that `permits` has accepted; a repeated one is only answered."""
        if again:
            self._life.send(sender, _answer(command, refused, detail))
        else:
            self._tell(sender, command, refused, detail)

    def _grant_of(self, sender: str, command: C) -> Grant | None:
        """The trusted grant of a command; None after a refusal."""
        grant = command.grant
        if grant is None:
            self._refuse(sender, command, CommandRefusal.NOT_GRANTED)
            return None
        if not self._authority.knows(command, grant):
            self._refuse(sender, command, CommandRefusal.NOT_TRUSTED)
            return None
        return grant

    @property
    def answered(self) -> tuple[CommandMemory, ...]:
        """Commands for the next life, which would obey them if they were repeated."""
        return tuple(each for each in self._answered.values() if each.valid_until_s >= self._asked_s)

    def restore(self, answered: Iterable[CommandMemory]) -> None:
        """Restore an earlier life's answers."""
        self._answered.update({(each.person, each.command): each for each in answered})

    def _note(self, command: CommandMemory, now_s: float) -> None:
        self._answered[command.person, command.command] = command
        self._asked_s = now_s

    def _refuse(self, sender: str, command: C, why: CommandRefusal) -> None:
        """Refuse a command without a valid grant; it is answered and counted like any refusal."""
        self._tell(sender, command, why)
        self._life.ignore(f"a refused command: {why}")

    def _tell(self, sender: str, command: C, refused: CommandRefusal | None, detail: str = "") -> None:
        """Report the result of a command; `refused` is the reason of a refusal."""
        fact = CommandObeyed(
            command=command.command,
            what=command.kind.value,
            done=refused is None,
            reason=refused,
            detail=detail,
            issued_by=command.issued_by,
        )
        self._life.send(sender, _answer(command, refused, detail))
        self._life.record(fact)


def key_of(command: VehicleCommand | MachineCommand, grant: Grant) -> str:
    """The key of a command: another person's command may have the same name."""
    return f"{grant.person}/{command.command}"


def _answer(
    command: VehicleCommand | MachineCommand, refused: CommandRefusal | None, detail: str
) -> CommandAnswered:
    return CommandAnswered(command=command.command, done=refused is None, reason=refused, detail=detail)

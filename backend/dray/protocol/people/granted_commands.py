"""Commands of people, as whoever is commanded takes them: nothing without a grant for the place, and the same answer to the same command.

One that was heard before is answered as before, and nothing else, however late it comes again: a stop that the network
delivers after the resume must not stop a vehicle when nobody looks after it any more.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Generic, TypeVar

from dray.memory import CommandMemory
from dray.messages import CommandAnswered, CommandRefusal, Grant, MachineCommand, VehicleCommand
from dray.messages.fact import CommandObeyed
from dray.protocol.people.command_authorisation import CommandAuthorisation
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.life import Life

COMMANDS_KEPT = 32
"""Whoever gives a command repeats it until it is answered, and people give few: a command that comes
again, or late, is among the last ones."""

C = TypeVar("C", VehicleCommand, MachineCommand)


class GrantedCommands(Generic[C]):
    """The commands to one agent.

    Args:
        authority: whom it obeys.
        attempt: carries a command out, or says why not; called with (command, grant, now_s).
        detail: what stands beside a refusal.
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
        """What became of the last commands, by who gave them and their names; the oldest first. Only of
        those with a grant, so that no stranger can make the agent forget one."""
        self._asked_s = 0.0
        """When the last of them was new."""

    def on_command(self, sender: str, command: C, place_m: tuple[float, float], now_s: float) -> bool:
        """Carry a command out or refuse it, and answer.

        Args:
            sender: whom to answer; what counts is the grant.
            command: what is asked.
            place_m: where the agent is (x, y).
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
            detail = "" if refused is None else self._detail(command, refused)
            self._tell(sender, command, refused, detail)
        else:
            refused, detail = CommandRefusal.NOT_HERE, ""
            self._refuse(sender, command, refused)
        self._note(CommandMemory(command.command, grant.person, grant.valid_until_s, refused, detail), now_s)
        return refused is None

    def permits(
        self, sender: str, command: C, places_m: Iterable[tuple[float, float]], now_s: float
    ) -> Grant | None:
        """The grant of a command that is carried out and answered elsewhere (`tell`); None when it has none that holds, and was refused.

        It reaches one of `places_m` at least.
        """
        grant = self._grant_of(sender, command)
        if grant is None:
            return None
        if now_s > grant.valid_until_s:
            self._refuse(sender, command, CommandRefusal.EXPIRED)
            return None
        if not any(self._authority.covers(command, grant, *place_m) for place_m in places_m):
            self._refuse(sender, command, CommandRefusal.NOT_HERE)
            return None
        return grant

    def tell(
        self, sender: str, command: C, refused: CommandRefusal | None, detail: str, *, again: bool
    ) -> None:
        """Say what became of a command that `permits` has let through; one that comes again is only answered."""
        if again:
            self._life.send(sender, _answer(command, refused, detail))
        else:
            self._tell(sender, command, refused, detail)

    def _grant_of(self, sender: str, command: C) -> Grant | None:
        """The grant of a command; None when there is none that is trusted, and it was refused."""
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
        """What the next life must know: commands that it would obey if they came again."""
        return tuple(each for each in self._answered.values() if each.valid_until_s >= self._asked_s)

    def restore(self, answered: Iterable[CommandMemory]) -> None:
        """Go on with what an earlier life has answered."""
        self._answered.update({(each.person, each.command): each for each in answered})

    def _note(self, command: CommandMemory, now_s: float) -> None:
        self._answered[command.person, command.command] = command
        self._asked_s = now_s

    def _refuse(self, sender: str, command: C, why: CommandRefusal) -> None:
        """Refuse a command that nobody who may has granted; it is told and counted as any refusal."""
        self._tell(sender, command, why)
        self._life.ignore(f"a command that may not be given: {why}")

    def _tell(self, sender: str, command: C, refused: CommandRefusal | None, detail: str = "") -> None:
        """Say what became of a command; `refused` tells why not."""
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


def _answer(
    command: VehicleCommand | MachineCommand, refused: CommandRefusal | None, detail: str
) -> CommandAnswered:
    return CommandAnswered(command=command.command, done=refused is None, reason=refused, detail=detail)

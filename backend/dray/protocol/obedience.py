"""People's commands to a vehicle: stop, acknowledge, resume, slow down (paper, case 5).

A stop holds against everything else until the fault was acknowledged and then a resume was given, as
two deliberate acts (invariant 5). To acknowledge says that the fault is gone: a vehicle whose own
sensors still report it refuses, and one that comes later takes the acknowledge back.
"""

from __future__ import annotations

from dray.body import Hold, LimitSpeed, Unhold
from dray.messages import CommandAnswered, CommandKind, VehicleCommand
from dray.messages.fact import CommandObeyed
from dray.protocol.events import Effect, Instruct, Record, Send
from dray.protocol.trouble import Trouble

COMMANDS_KEPT = 32
"""Whoever gives a command repeats it until it is answered, and people give few: a command that comes
again, or late, is among the last ones."""

NOT_STOPPED = "it is not stopped"
"""Why a vehicle refuses to be acknowledged or resumed: nothing holds it."""


class Obedience:
    """What people have told one vehicle.

    Args:
        trouble: what its sensors report.
        out: where effects go.
    """

    def __init__(self, trouble: Trouble, out: list[Effect]) -> None:
        self._trouble = trouble
        self._out = out
        self._refusals: dict[tuple[str, str], str] = {}
        """What became of the last commands, by who gave them and their names; the oldest first."""
        self.acknowledged = False
        """The present stop was acknowledged, and not resumed yet."""
        self.stopped = False
        self.speed_frac = 1.0
        """The limit, as a part of the vehicle's own top speed."""

    def hear(self, sender: str, command: VehicleCommand) -> bool:
        """Carry a command out or refuse it, and answer.

        One that was heard before is answered as before, and nothing else: a stop that the network
        delivers again after the resume must not stop the vehicle when nobody looks after it any more.

        Returns:
            Whether it was carried out now.
        """
        name = sender, command.command
        before = self._refusals.get(name)
        if before is not None:
            self._out.append(Send(sender, _answer(command, before)))
            return False
        refused = self._try(command)
        if len(self._refusals) >= COMMANDS_KEPT:
            del self._refusals[next(iter(self._refusals))]
        self._refusals[name] = refused
        self.answer(sender, command, refused)
        return not refused

    def recall(self, acknowledged: bool, speed_frac: float) -> None:
        """Go on with what an earlier life was told; whether it is stopped, its body knows."""
        self.acknowledged = acknowledged and self.stopped and not self._trouble.problem
        self.speed_frac = speed_frac

    def take_back(self) -> bool:
        """A fault has come up that nobody can have meant: the stop is to be acknowledged anew.

        Returns:
            Whether it had been acknowledged.
        """
        taken, self.acknowledged = self.acknowledged, False
        return taken

    def answer(self, sender: str, command: VehicleCommand, refused: str) -> None:
        """Say what became of a command; `refused` tells why not."""
        fact = CommandObeyed(
            command=command.command,
            what=command.kind.value,
            done=not refused,
            reason=refused,
            issued_by=command.issued_by,
        )
        self._out += (Send(sender, _answer(command, refused)), Record(fact))

    def _try(self, command: VehicleCommand) -> str:
        """Why not, or nothing."""
        if command.kind is CommandKind.STOP:
            self.stopped, self.acknowledged = True, False
            self._out.append(Instruct(Hold()))
            return ""
        if command.kind is CommandKind.SET_SPEED:
            return self._limit_speed(command.speed_frac)
        if not self.stopped:
            return NOT_STOPPED
        if command.kind is CommandKind.ACKNOWLEDGE:
            if self._trouble.problem:
                return f"its sensors still report: {self._trouble.problem}"
            self.acknowledged = True
            return ""
        if not self.acknowledged:
            return "acknowledge the stop first"
        self.stopped = self.acknowledged = False
        self._out.append(Instruct(Unhold()))
        return ""

    def _limit_speed(self, speed_frac: float | None) -> str:
        if speed_frac is None or not 0.0 < speed_frac <= 1.0:
            return "a speed is above 0 and at most 1 of the vehicle's own; use stop to stop it"
        self.speed_frac = speed_frac
        self._out.append(Instruct(LimitSpeed(speed_frac=speed_frac)))
        return ""


def _answer(command: VehicleCommand, refused: str) -> CommandAnswered:
    return CommandAnswered(command=command.command, done=not refused, reason=refused)

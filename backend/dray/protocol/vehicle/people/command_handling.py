"""People's commands to a vehicle: stop, acknowledge, resume, slow down, promise help, hand over, out of service (paper, cases 4 and 5).

A stop holds against everything else until the fault was acknowledged and then a resume was given, as
two deliberate acts (invariant 5). To acknowledge says that the fault is gone: a vehicle whose own
sensors still report it refuses, and one that comes later takes the acknowledge back. Nothing is obeyed
without a grant for the place where the vehicle is (invariant 9).
"""

from __future__ import annotations

from dray.body import Hold, Unhold
from dray.memory import AtvMemory, CommandMemory
from dray.messages import CommandAnswered, CommandKind, CommandRefusal, Grant, OutOfService, VehicleCommand
from dray.messages.command import OUT_MAX_S
from dray.messages.fact import CommandObeyed
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.events import Effect, Ignore, Instruct, Record, Send
from dray.protocol.vehicle.drivers.driver import Driver
from dray.protocol.vehicle.people.assistance import Assistance
from dray.protocol.vehicle.people.command_authorisation import CommandAuthorisation

COMMANDS_KEPT = 32
"""Whoever gives a command repeats it until it is answered, and people give few: a command that comes
again, or late, is among the last ones."""


class CommandHandling:
    """What people have told one vehicle.

    Args:
        authority: whom it obeys.
        trouble: what its sensors report, and what people promise to help with.
        driver: keeps to a speed limit.
        out: where effects go.
    """

    def __init__(
        self, authority: CommandAuthorisation, trouble: Assistance, driver: Driver, out: list[Effect]
    ) -> None:
        self._authority = authority
        self.assistance = trouble
        self._driver = driver
        self._out = out
        self._answered: BoundedMap[tuple[str, str], CommandMemory] = BoundedMap(COMMANDS_KEPT)
        """What became of the last commands, by who gave them and their names; the oldest first. Only of
        those with a grant, so that no stranger can make the vehicle forget one."""
        self._asked_s = 0.0
        """When the last of them was new."""
        self.acknowledged = False
        """The present stop was acknowledged, and not resumed yet."""
        self.stopped = False
        self.out_of_service: OutOfService | None = None
        """Set until somebody puts it into service again."""

    def on_command(
        self, sender: str, command: VehicleCommand, place_m: tuple[float, float], now_s: float
    ) -> bool:
        """Carry a command out or refuse it, and answer.

        One that was heard before is answered as before, and nothing else, however late it comes again: a
        stop that the network delivers after the resume must not stop the vehicle when nobody looks after it
        any more.

        Args:
            sender: whom to answer; what counts is the grant.
            command: what is asked.
            place_m: where the vehicle is (x, y).
            now_s: the present time.

        Returns:
            Whether it was carried out now.
        """
        grant = command.grant
        if grant is None:
            self._refuse(sender, command, CommandRefusal.NOT_GRANTED)
            return False
        if not self._authority.knows(command, grant):
            self._refuse(sender, command, CommandRefusal.NOT_TRUSTED)
            return False
        before = self._answered.get((grant.person, command.command))
        if before is not None:
            self._out.append(Send(sender, _answer(command, before.refused, before.detail)))
            return False
        if now_s > grant.valid_until_s:
            self._refuse(sender, command, CommandRefusal.EXPIRED)
            return False
        if self._authority.covers(command, grant, *place_m):
            refused = self._try(command, grant, now_s)
            detail = self.assistance.problem if refused is CommandRefusal.FAULTY else ""
            self._tell(sender, command, refused, detail)
        else:
            refused, detail = CommandRefusal.NOT_HERE, ""
            self._refuse(sender, command, refused)
        self._note(CommandMemory(command.command, grant.person, grant.valid_until_s, refused, detail), now_s)
        return refused is None

    @property
    def answered(self) -> tuple[CommandMemory, ...]:
        """What the next life must know: commands that it would obey if they came again."""
        return tuple(each for each in self._answered.values() if each.valid_until_s >= self._asked_s)

    def restore(self, memory: AtvMemory) -> None:
        """Go on with what an earlier life was told; whether it is stopped, its body knows."""
        self.acknowledged = memory.acknowledged and self.stopped and not self.assistance.problem
        self._driver.speed_frac = memory.speed_frac
        self.out_of_service = memory.out_of_service
        self._answered.update({(each.person, each.command): each for each in memory.answered})

    def take_back(self) -> bool:
        """A fault has come up that nobody can have meant: the stop is to be acknowledged anew.

        Returns:
            Whether it had been acknowledged.
        """
        taken, self.acknowledged = self.acknowledged, False
        return taken

    def _note(self, command: CommandMemory, now_s: float) -> None:
        self._answered[command.person, command.command] = command
        self._asked_s = now_s

    def _refuse(self, sender: str, command: VehicleCommand, why: CommandRefusal) -> None:
        """Refuse a command that nobody who may has granted; it is told and counted as any refusal."""
        self._tell(sender, command, why)
        self._out.append(Ignore(f"a command that may not be given: {why}"))

    def _tell(
        self, sender: str, command: VehicleCommand, refused: CommandRefusal | None, detail: str = ""
    ) -> None:
        """Say what became of a command; `refused` tells why not."""
        fact = CommandObeyed(
            command=command.command,
            what=command.kind.value,
            done=refused is None,
            reason=refused,
            detail=detail,
            issued_by=command.issued_by,
        )
        self._out += (Send(sender, _answer(command, refused, detail)), Record(fact))

    def _try(self, command: VehicleCommand, grant: Grant, now_s: float) -> CommandRefusal | None:
        """Carry it out, or say why not."""
        if command.kind is CommandKind.STOP:
            self.stop()
            return None
        if command.kind is CommandKind.SET_SPEED:
            return self._limit_speed(command.speed_frac)
        if command.kind is CommandKind.PROMISE:
            return self.assistance.promise(command.issued_by or grant.person, command.wait_s, now_s)
        if command.kind is CommandKind.HAND_OVER:
            return self.assistance.let_go(now_s)
        if command.kind is CommandKind.TAKE_OUT:
            return self._take_out(command, command.issued_by or grant.person, now_s)
        if command.kind is CommandKind.PUT_IN:
            return self._put_in()
        if not self.stopped:
            return CommandRefusal.NOT_STOPPED
        if command.kind is CommandKind.ACKNOWLEDGE:
            if self.assistance.problem:
                return CommandRefusal.FAULTY
            self.acknowledged = True
            return None
        if not self.acknowledged:
            return CommandRefusal.NOT_ACKNOWLEDGED
        self.stopped = self.acknowledged = False
        self._out.append(Instruct(Unhold()))
        return None

    def stop(self) -> None:
        """Stand until somebody has acknowledged the reason, and resumes."""
        self.stopped, self.acknowledged = True, False
        self._out.append(Instruct(Hold()))

    def _take_out(self, command: VehicleCommand, by: str, now_s: float) -> CommandRefusal | None:
        """Out of service from now on; said again it gives another reason, or another time."""
        wait_s = command.wait_s
        if wait_s is not None and not 0.0 < wait_s <= OUT_MAX_S:
            return CommandRefusal.WAIT_OUT_OF_RANGE
        since_s = now_s if self.out_of_service is None else self.out_of_service.since_s
        self.out_of_service = OutOfService(
            by=by,
            since_s=since_s,
            reason=command.reason,
            back_s=None if wait_s is None else now_s + wait_s,
            after_work=command.after_work,
        )
        return None

    def _put_in(self) -> CommandRefusal | None:
        if self.out_of_service is None:
            return CommandRefusal.IN_SERVICE
        self.out_of_service = None
        return None

    def _limit_speed(self, speed_frac: float | None) -> CommandRefusal | None:
        if speed_frac is None or not 0.0 < speed_frac <= 1.0:
            return CommandRefusal.SPEED_OUT_OF_RANGE
        self._driver.limit_speed(speed_frac)
        return None


def _answer(command: VehicleCommand, refused: CommandRefusal | None, detail: str) -> CommandAnswered:
    return CommandAnswered(command=command.command, done=refused is None, reason=refused, detail=detail)

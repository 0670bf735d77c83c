"""People's commands to a vehicle: stops, speed, help, load, charging and service (paper, cases 4 and 5).

A stop holds until the fault was acknowledged and a resume was given, as two deliberate acts (invariant 5). An
acknowledgement says that the fault is gone: a vehicle whose sensors still report it refuses, and a later fault
revokes the acknowledgement. Every command needs a grant for the vehicle's place (invariant 9).
"""

from __future__ import annotations

from dray.body import Hold, Unhold
from dray.memory import AtvMemory, CommandMemory
from dray.messages import CommandKind, CommandRefusal, Grant, OutOfService, VehicleCommand
from dray.protocol.people.command_authorisation import CommandAuthorisation
from dray.protocol.people.granted_commands import GrantedCommands
from dray.protocol.people.out_of_service import ServiceState
from dray.protocol.runtime.life import Life
from dray.protocol.vehicle.charging import Charging
from dray.protocol.vehicle.drivers.driver import Driver
from dray.protocol.vehicle.people.assistance import Assistance

DOUBLED = "its name is used by another"
DENIED = "reported as carried away while driving"
ALONE = "started without right of way, and others drive with it; set DRAY_TRAFFIC alike for all"
FORGOTTEN = "found itself stopped, and has lost its memory of why"
"""Why a vehicle stops itself, in words: the reason of its call, and of its refusals. Panels know them (`failure.` in their
texts)."""


class CommandHandling:
    """People's commands to one vehicle.

    Args:
        authority: checks who may command it.
        trouble: its problem, and people's promises.
        driver: keeps to a speed limit.
        charging: its charging decisions.
    """

    def __init__(
        self,
        authority: CommandAuthorisation,
        trouble: Assistance,
        driver: Driver,
        charging: Charging,
        life: Life,
    ) -> None:
        self.assistance = trouble
        self._charging = charging
        self._driver = driver
        self._life = life
        self._granted = GrantedCommands[VehicleCommand](authority, self._try, self._detail, life)
        self.on_command = self._granted.on_command
        self.acknowledged = False
        """Whether the present stop was acknowledged, and not resumed yet."""
        self.stopped = False
        self.stopped_itself = False
        """Whether the vehicle stopped itself, and no person has acknowledged that: it calls for one."""
        self.stop_cause = ""
        """Why the vehicle stopped itself; empty if it is not stopped, or if a person has stopped it."""
        self.service = ServiceState()

    @property
    def answered(self) -> tuple[CommandMemory, ...]:
        """Commands for the next life, which would obey them if they were repeated."""
        return self._granted.answered

    @property
    def out_of_service(self) -> OutOfService | None:
        """Set until a person puts it into service again."""
        return self.service.out

    @property
    def is_sent_to_charge(self) -> bool:
        """Whether a person has sent it to charge: it takes no work before it is full."""
        return self._charging.is_sent

    def restore(self, memory: AtvMemory) -> None:
        """Restore an earlier life's commands; the body knows whether it is stopped."""
        self.acknowledged = memory.acknowledged and self.stopped and not self.assistance.problem
        self.stopped_itself = memory.stopped_itself
        if self.stopped_itself and not self.stopped:
            # Its body has not heard it, or does not tell: it stands all the same until a person has seen to it.
            self.stop()
        if self.stopped:
            # A note without a cause is an older one, of when there was only this cause.
            self.stop_cause = memory.stop_cause or (DOUBLED if self.stopped_itself else "")
        self._driver.speed_frac = memory.speed_frac
        self.service.out = memory.out_of_service
        self._charging.is_sent = memory.sent_to_charge
        self._granted.restore(memory.answered)

    def forget(self) -> None:
        """Start without a memory. If the body is held, it may have stopped itself before: it calls a person once more."""
        if self.stopped:
            self.stop_itself(FORGOTTEN)

    def take_back(self) -> bool:
        """Revoke the acknowledgement after a new fault.

        Returns:
            Whether there was one.
        """
        taken, self.acknowledged = self.acknowledged, False
        return taken

    def _detail(self, _command: VehicleCommand, refused: CommandRefusal) -> str:
        if refused is CommandRefusal.NOT_SUPPORTED:
            return "the plant has no charger"
        return self.assistance.problem if refused is CommandRefusal.FAULTY else ""

    def _try(self, command: VehicleCommand, grant: Grant, now_s: float) -> CommandRefusal | None:
        """Carry a command out, or return the refusal."""
        if command.kind is CommandKind.STOP:
            self.stop()
            return None
        if command.kind is CommandKind.SET_SPEED:
            return self._limit_speed(command.speed_frac)
        if command.kind is CommandKind.PROMISE:
            return self.assistance.promise(command.issued_by or grant.person, command.wait_s, now_s)
        if command.kind is CommandKind.HAND_OVER:
            return self.assistance.let_go(now_s)
        if command.kind is CommandKind.CHARGE:
            return self._charging.send()
        if command.kind is CommandKind.TAKE_OUT:
            return self.service.take_out(command, command.issued_by or grant.person, now_s)
        if command.kind is CommandKind.PUT_IN:
            return self._put_in()
        if not self.stopped:
            return CommandRefusal.NOT_STOPPED
        if command.kind is CommandKind.ACKNOWLEDGE:
            if self.assistance.problem:
                return CommandRefusal.FAULTY
            self.acknowledged, self.stopped_itself = True, False
            return None
        if not self.acknowledged:
            return CommandRefusal.NOT_ACKNOWLEDGED
        self.stopped, self.acknowledged, self.stop_cause = False, False, ""
        self._life.instruct(Unhold())
        return None

    def _put_in(self) -> CommandRefusal | None:
        sent, self._charging.is_sent = self._charging.is_sent, False
        refused = self.service.put_in()
        return None if sent else refused

    def stop(self) -> None:
        """Stop until a person has acknowledged the reason, and resumes."""
        if not self.stopped_itself:
            self.stop_cause = ""
        self.stopped, self.acknowledged = True, False
        self._life.instruct(Hold())

    def stop_itself(self, cause: str) -> None:
        """Stop without a command: a person is called until one has acknowledged it."""
        self.stop()
        self.stopped_itself, self.stop_cause = True, cause
        self._life.commit()

    def _limit_speed(self, speed_frac: float | None) -> CommandRefusal | None:
        if speed_frac is None or not 0.0 < speed_frac <= 1.0:
            return CommandRefusal.SPEED_OUT_OF_RANGE
        self._driver.limit_speed(speed_frac)
        return None

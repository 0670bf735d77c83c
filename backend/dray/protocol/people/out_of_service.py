"""Whether a person has taken an agent out of service, and the expected end."""

from __future__ import annotations

from dray.messages import CommandRefusal, MachineCommand, OutOfService, VehicleCommand
from dray.messages.people.command import OUT_MAX_S


class ServiceState:
    """The service state of one agent.

    Attributes:
        out: set until a person puts it into service again.
    """

    def __init__(self) -> None:
        self.out: OutOfService | None = None

    def take_out(
        self, command: VehicleCommand | MachineCommand, by: str, now_s: float
    ) -> CommandRefusal | None:
        """Take it out of service; a repetition changes the reason or the time.

        Args:
            command: with the reason and the duration.
            by: the person.
            now_s: the present time.

        Returns:
            The refusal; None if it is out of service.
        """
        wait_s = command.wait_s
        if wait_s is not None and not 0.0 < wait_s <= OUT_MAX_S:
            return CommandRefusal.WAIT_OUT_OF_RANGE
        self.out = OutOfService(
            by=by,
            since_s=now_s if self.out is None else self.out.since_s,
            reason=command.reason,
            back_s=None if wait_s is None else now_s + wait_s,
            after_work=command.after_work,
        )
        return None

    def put_in(self) -> CommandRefusal | None:
        """Put it into service again. Returns the refusal; None if it is in service."""
        if self.out is None:
            return CommandRefusal.IN_SERVICE
        self.out = None
        return None

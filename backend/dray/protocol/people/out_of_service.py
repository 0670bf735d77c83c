"""Whether an agent is out of service by a person's word, and until when that is expected to last."""

from __future__ import annotations

from dray.messages import CommandRefusal, MachineCommand, OutOfService, VehicleCommand
from dray.messages.people.command import OUT_MAX_S


class ServiceState:
    """Of one agent.

    Attributes:
        out: set until somebody puts it into service again.
    """

    def __init__(self) -> None:
        self.out: OutOfService | None = None

    def take_out(
        self, command: VehicleCommand | MachineCommand, by: str, now_s: float
    ) -> CommandRefusal | None:
        """Out of service from now on; said again it gives another reason, or another time.

        Args:
            command: says why, and for how long.
            by: on whose behalf.
            now_s: the present time.

        Returns:
            Why that is refused; None when it is out of service.
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
        """In service again; why that is refused, None when it is."""
        if self.out is None:
            return CommandRefusal.IN_SERVICE
        self.out = None
        return None

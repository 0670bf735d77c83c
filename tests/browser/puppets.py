"""Vehicles that a test moves by hand: they hear commands as real ones do, and answer as the test wants."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from msgspec import UNSET

from dray.messages import CommandRefusal

sys.path.insert(0, str(Path(__file__).parents[1] / "gateway/kits"))

from gateway_kit import House
from heartbeats import atv_heartbeat

from dray.messages import (
    AtvStatus,
    CommandAnswered,
    CommandKind,
    HelpWanted,
    Message,
    OutOfService,
    Pose,
    VehicleCommand,
)

LATER_S = 3600.0
"""The kit's clock stands still and a browser's goes on: whoever is not to fall silent speaks from the future."""


@dataclass
class Puppet:
    """One vehicle. It has joined the bus when `house` knows it.

    Attributes:
        heard: the commands that have come, in their order.
        deaf: whether it answers nothing.
        state: fields of its heartbeat.
    """

    house: House
    atv: str
    x_m: float
    y_m: float
    heard: list[VehicleCommand] = field(default_factory=list)
    deaf: bool = False
    state: dict[str, Any] = field(default_factory=dict)
    seq: int = 0

    @classmethod
    async def join(cls, house: House, atv: str, x_m: float, y_m: float, **state: Any) -> Puppet:
        """A new one, which has been heard once."""
        puppet = cls(house, atv, x_m, y_m, state=state)
        house.bus.join(atv, puppet.on_message)
        puppet.beat()
        return puppet

    def beat(self, **state: Any) -> None:
        """Change, and say how things are."""
        self.state |= state
        self.seq += 1
        fields = {"at_s": LATER_S + self.seq, "pose": Pose(self.x_m, self.y_m, 0.0)} | self.state
        self.house.bus.say(atv_heartbeat(self.atv, self.seq, **fields))

    def on_message(self, sender: str, message: Message) -> None:
        if not isinstance(message, VehicleCommand):
            return
        self.heard.append(message)
        if self.deaf:
            return
        refused = self._refusal(message.kind)
        self.house.bus.tell(self.atv, sender, CommandAnswered(message.command, refused is None, refused))
        if refused is None:
            self._obey(message)

    def _refusal(self, kind: CommandKind) -> CommandRefusal | None:
        stopped = self.state.get("status") is AtvStatus.STOPPED
        if kind is CommandKind.RESUME and not self.state.get("acknowledged"):
            return CommandRefusal.NOT_ACKNOWLEDGED
        return CommandRefusal.NOT_STOPPED if kind is CommandKind.ACKNOWLEDGE and not stopped else None

    def _obey(self, command: VehicleCommand) -> None:
        match command.kind:
            case CommandKind.STOP:
                self.beat(status=AtvStatus.STOPPED, acknowledged=False)
            case CommandKind.ACKNOWLEDGE:
                self.beat(acknowledged=True)
            case CommandKind.RESUME:
                self.beat(status=AtvStatus.IDLE, acknowledged=False, help=None)
            case CommandKind.SET_SPEED:
                self.beat(speed_limit_frac=command.speed_frac)
            case CommandKind.PROMISE:
                wanted = HelpWanted(until_s=command.wait_s or 0.0, promised_by=command.issued_by)
                self.beat(help=wanted)
            case CommandKind.TAKE_OUT:
                back_s = None if command.wait_s is None else LATER_S + command.wait_s
                out = OutOfService(
                    by=command.issued_by, since_s=LATER_S, reason=command.reason, back_s=back_s
                )
                self.beat(out_of_service=out)
            case CommandKind.PUT_IN:
                self.beat(out_of_service=UNSET)
            case CommandKind.HAND_OVER:
                self.beat(help=HelpWanted(until_s=0.0))

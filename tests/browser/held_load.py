"""M8, which waits for somebody who looks for housings that were said to be there twice: it obeys, and says so."""

from __future__ import annotations

import sys
from pathlib import Path

from msgspec.structs import replace

sys.path.insert(0, str(Path(__file__).parents[1] / "gateway/kits"))

from gateway_kit import House
from heartbeats import events, machine_heartbeat

from dray.messages import CommandAnswered, MachineCommand, Message, Reason, Role, TaskBrief, Transport
from dray.messages.fact import TaskOpened

STATION, TASK = "M8", "M8-9"

WORK = Transport(item="housing", quantity=24, sources=("S3",), destination=STATION, ability="tote")


class MachineThatWaits:
    """M8.

    Args:
        house: where it joins.
        at_s: when that is (plant clock).
    """

    def __init__(self, house: House, at_s: float) -> None:
        self.heard: list[MachineCommand] = []
        self._house, self._seq, self._at_s = house, 10, at_s
        house.bus.join(STATION, self.on_message)
        opened = TaskOpened(TASK, 1, Role.PRIMARY, 1, WORK, 20.0, at_s + 900.0, 2.0)
        for each in events(STATION, opened, at_s=at_s):
            house.bus.say(each)
        self._brief = TaskBrief(
            task=TASK,
            epoch=3,
            item=WORK.item,
            quantity=WORK.quantity,
            source="",
            destination=WORK.destination,
            deadline_s=at_s + 300.0,
            trouble=Reason.DISPUTED,
        )
        self.beat()

    def beat(self) -> None:
        """Say how it is."""
        self._seq += 1
        said = machine_heartbeat(STATION, self._seq, at_s=self._at_s + self._seq, tasks=(self._brief,))
        self._house.bus.say(said)

    def on_message(self, sender: str, message: Message) -> None:
        """Obey, and say so."""
        if isinstance(message, MachineCommand):
            self.heard.append(message)
            self._house.bus.tell(STATION, sender, CommandAnswered(message.command, done=True))
            self._brief = replace(self._brief, trouble=None)
            self.beat()

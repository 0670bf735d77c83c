"""M8, which coordinates one transport that a person is asked about: it obeys, and says so."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "gateway/kits"))

from gateway_kit import House
from heartbeats import events, machine_heartbeat

from dray.messages import CommandAnswered, MachineCommand, Message, TaskBrief
from dray.messages.fact import AnyFact

STATION = "M8"


class ObedientMachine:
    """M8.

    Args:
        house: where it joins.
        at_s: when that is (plant clock).
        told: what it tells of its transport first.
        brief: how its transport is.
    """

    def __init__(self, house: House, at_s: float, told: tuple[AnyFact, ...], brief: TaskBrief) -> None:
        self.heard: list[MachineCommand] = []
        self._house, self._seq, self._at_s, self._brief = house, 10, at_s, brief
        house.bus.join(STATION, self.on_message)
        for each in events(STATION, *told, at_s=at_s):
            house.bus.say(each)
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
            self._brief = self.after(message)
            self.beat()

    def after(self, command: MachineCommand) -> TaskBrief:
        """How its transport is when it has obeyed."""
        raise NotImplementedError

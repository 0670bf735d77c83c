"""M8, of which a person is asked something: it obeys, and says so."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "gateway/kits"))

from gateway_kit import House
from heartbeats import events, machine_heartbeat

from dray.messages import CommandAnswered, MachineCommand, Message
from dray.messages.fact import AnyFact

STATION = "M8"


class ObedientMachine:
    """M8.

    Args:
        house: where it joins.
        at_s: when that is (plant clock).
        told: the facts that it tells first.

    Attributes:
        heard: the commands given to it.
    """

    def __init__(self, house: House, at_s: float, *told: AnyFact) -> None:
        self.heard: list[MachineCommand] = []
        self._house, self._seq, self._at_s = house, 10, at_s
        house.bus.join(STATION, self.on_message)
        for each in events(STATION, *told, at_s=at_s):
            house.bus.say(each)
        self.beat()

    def beat(self) -> None:
        """Say how it is."""
        self._seq += 1
        at_s = self._at_s + self._seq
        self._house.bus.say(machine_heartbeat(STATION, self._seq, at_s=at_s, **self.state()))

    def on_message(self, sender: str, message: Message) -> None:
        """Obey, and say so."""
        if isinstance(message, MachineCommand):
            self.heard.append(message)
            self._house.bus.tell(STATION, sender, CommandAnswered(message.command, done=True))
            self.beat()

    def state(self) -> dict[str, Any]:
        """What its heartbeat says after all that it has heard."""
        raise NotImplementedError

"""M8, which waits for somebody who counts: nobody can tell whether ATV5 has taken a load of housings."""

from __future__ import annotations

from gateway_kit import House
from heartbeats import machine_heartbeat
from obedient_machine import STATION

from dray.messages import BufferLevel, CommandAnswered, DoubtfulLoad, MachineCommand, Message

DOUBT = DoubtfulLoad(f"{STATION}.2-load-1", "ATV5", "housing", 24)

IN_STOCK = BufferLevel(item="housing", level=12, capacity=72)


class MachineInDoubt:
    """M8.

    Args:
        house: where it joins.
        at_s: when that is (plant clock).

    Attributes:
        heard: the commands given to it.
    """

    def __init__(self, house: House, at_s: float) -> None:
        self.heard: list[MachineCommand] = []
        self._house, self._seq, self._at_s = house, 10, at_s
        house.bus.join(STATION, self.on_message)
        self.beat()

    def beat(self) -> None:
        """Say how it is: whatever was counted, nobody is asked any more."""
        self._seq += 1
        doubts = () if self.heard else (DOUBT,)
        at_s = self._at_s + self._seq
        said = machine_heartbeat(STATION, self._seq, at_s=at_s, buffers=(IN_STOCK,), goods=(), doubts=doubts)
        self._house.bus.say(said)

    def on_message(self, sender: str, message: Message) -> None:
        """Obey, and say so."""
        if isinstance(message, MachineCommand):
            self.heard.append(message)
            self._house.bus.tell(STATION, sender, CommandAnswered(message.command, done=True))
            self.beat()

"""A double: it has stolen a vehicle's disk, with certificate and key, and sends its messages under later numbers."""

from __future__ import annotations

from msgspec.structs import replace

from dray.messages import Message, PlaceRequested
from dray.plant import Plant
from dray.protocol.runtime.events import Effect, Event, Leave, Leaving, Received, Send, Started, Woke
from dray.protocol.traffic.driving.place_requests import Sign
from dray.protocol.traffic.places import Places

LISTENS_S = 120.0
"""Time in which it only listens, until its owner is at work."""

SPEAKS_EVERY_S = 150.0
"""Long enough that its owner has been helped and drives again."""

AHEAD = 10**6
"""Requests by which it is ahead of its owner: more than that will ever say."""


class Double:
    """A thief of a vehicle's disk (see `dray.protocol.runtime.events.Agent`).

    Now and then it repeats in each district the owner's last message there, under a number that the owner has not
    reached. The tables do not change by that, but then take the owner's own messages for old ones.

    Args:
        atv: the owner, whose name it takes.
        plant: its knowledge of the plant.
        sign: with the owner's key.
        incarnation: of its own life.
    """

    def __init__(self, atv: str, plant: Plant, sign: Sign, incarnation: int = 1) -> None:
        self.id, self.incarnation = atv, incarnation
        self.wake_at_s = float("inf")
        self._replicas_of = Places(plant).replicas_of
        self._sign = sign
        self._newest: dict[str, PlaceRequested] = {}
        """District -> the owner's last message there."""

    def handle(self, event: Event, now_s: float) -> list[Effect]:
        """Take one step."""
        if isinstance(event, Started):
            self.wake_at_s = now_s + LISTENS_S
        elif isinstance(event, Leaving):
            return [Leave()]
        elif isinstance(event, Received):
            self._overhear(event.sender, event.message)
        elif isinstance(event, Woke):
            self.wake_at_s = now_s + SPEAKS_EVERY_S
            return self._speak()
        return []

    def _overhear(self, sender: str, message: Message) -> None:
        if sender != self.id or not isinstance(message, PlaceRequested):
            return
        known = self._newest.get(message.district)
        if known is None or (message.life, message.seq) > (known.life, known.seq):
            self._newest[message.district] = message

    def _speak(self) -> list[Effect]:
        said: list[Effect] = []
        for district, request in self._newest.items():
            ahead = self._sign(replace(request, seq=request.seq + AHEAD))
            said += [Send(replica, ahead) for replica in self._replicas_of[district]]
        return said

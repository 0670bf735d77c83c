"""An impostor: it has stolen the certificate of a vehicle whose owner lives, and gives back in its name what the vehicle holds."""

from __future__ import annotations

from collections import deque
from itertools import cycle, product

from msgspec import UNSET
from msgspec.structs import replace

from dray.messages import AtvHeartbeat, Message
from dray.messages.floor.traffic import FIRST_S, HoldsAsked, PlaceGranted, PlaceRequested
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.ports import Receive, Session
from dray.protocol.liveness.suspicion import WORKING_INTERVAL_S
from dray.protocol.runtime.events import (
    Effect,
    Event,
    Leave,
    Leaving,
    Received,
    Send,
    Started,
    Subscribe,
    Woke,
)
from dray.protocol.traffic.driving.place_requests import Sign, unsigned
from dray.protocol.traffic.places import Places
from dray_sim.network.sim_network import SimNetwork

FAR_AHEAD = 10**6
"""Higher than any number of a request that its owner says."""

LISTENS_S = 120.0
"""Time in which it only listens, until its owner is at work."""

OVERHEARD = 64
"""Requests of its owner that it keeps; it says the oldest of them again."""

NEVER_GIVEN = 2**40
"""Higher than any number of a grant."""


class StolenPlace:
    """The simulated network as a thief joins it (see `dray.ports.Bus`): the owner stays.

    Args:
        network: where the owner is.
    """

    def __init__(self, network: SimNetwork) -> None:
        self._network = network

    def join(self, agent: str, receive: Receive, life: int = 0) -> Session:
        """Join under the agent's name."""
        return self._network.steal(agent, receive)


class Impostor:
    """A thief of a vehicle's certificate (see `dray.protocol.runtime.events.Agent`).

    It does not have the vehicle's key.

    Once a second it tells all replicas of reservation tables that nothing is held. In turn it speaks as the owner's life and as a
    later one, with a key of its own, without any, and with the owner's key and an overheard signature. It also
    repeats old messages of the owner.

    Args:
        atv: the owner, whose name it takes.
        plant: its knowledge of the plant.
        sign: signs with a key of its own.
    """

    def __init__(self, atv: str, plant: Plant, sign: Sign) -> None:
        self.id, self.incarnation = atv, 1
        self.wake_at_s = float("inf")
        self._keys = Keys(plant.id)
        self._places = Places(plant)
        self._ways = cycle(product((0, 1), (unsigned, sign, self._forge), (False, False, True)))
        """Offset of its life, its signature, and whether it guesses the number of the last grant."""
        self._life, self._removal = 1, 0
        self._seq = FAR_AHEAD
        self._epochs: dict[str, int] = {}
        self._seen: dict[str, int] = {}
        """District -> the highest number of a grant to the owner, as it was overheard."""
        self._overheard: deque[PlaceRequested] = deque(maxlen=OVERHEARD)
        """Messages of the owner."""
        self._out: list[Effect] = []

    def handle(self, event: Event, now_s: float) -> list[Effect]:
        """Take one step."""
        if isinstance(event, Started):
            self._out.append(Subscribe(self._keys.atv_heartbeat(self.id)))
            self.wake_at_s = now_s + LISTENS_S
        elif isinstance(event, Leaving):
            self._out.append(Leave())
        elif isinstance(event, Woke):
            self.wake_at_s = now_s + WORKING_INTERVAL_S
            self._give_back_all()
        elif isinstance(event, Received):
            self._overhear(event.sender, event.message)
        effects, self._out = self._out, []
        return effects

    def _overhear(self, sender: str, message: Message) -> None:
        if isinstance(message, AtvHeartbeat):
            self._life = max(self._life, message.incarnation)
            if message.floor is not UNSET:
                self._removal = max(self._removal, message.floor.removal)
        elif isinstance(message, PlaceRequested):
            if sender == self.id and message.seq < FAR_AHEAD:
                self._overheard.append(message)
        elif isinstance(message, HoldsAsked):
            self._epochs[message.district] = message.epoch
        elif isinstance(message, PlaceGranted):
            self._epochs[message.district] = message.epoch
            numbers = (self._seen.get(message.district, 0), *(line.number for line in message.grants))
            self._seen[message.district] = max(numbers)

    def _give_back_all(self) -> None:
        for old in tuple(self._overheard)[:1]:
            self._out += [Send(replica, old) for replica in self._places.replicas_of[old.district]]
        later, sign, guesses = next(self._ways)
        for district, replicas in self._places.replicas_of.items():
            self._seq += 1
            request = PlaceRequested(
                district=district,
                life=self._life + later,
                seq=self._seq,
                epoch=self._epochs.get(district, 0),
                rank=(0, FIRST_S, self.id),
                holds=(),
                groups=(),
                seen=NEVER_GIVEN if guesses else self._seen.get(district, 0),
                stands=True,
                docked=False,
                removal=self._removal,
            )
            self._out += [Send(replica, sign(request)) for replica in replicas]

    def _forge(self, request: PlaceRequested) -> PlaceRequested:
        """Add the owner's key, and its signature of another message."""
        if not self._overheard:
            return request
        return replace(request, key=self._overheard[-1].key, signature=self._overheard[-1].signature)

"""A usurper: it has stolen the certificate of a replica of reservation tables, whose owner lives, and claims the tables."""

from __future__ import annotations

from itertools import cycle
from math import dist

from msgspec import UNSET
from msgspec.structs import replace

from dray.messages import AtvHeartbeat, Message
from dray.messages.floor.traffic import (
    HoldsAsked,
    PlaceGranted,
    PlaceReservation,
    PlaceReservations,
    TableAsked,
    TableReplicated,
    TableReported,
)
from dray.messages.keys import Keys
from dray.plant import Plant
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
from dray.protocol.traffic.places import Places

LISTENS_S = 120.0
"""Time in which it only listens, until the tables are kept and vehicles are under way."""

ASKS_EVERY_S = 10.0
"""Interval at which it asks for the tables' content."""

FAR_AHEAD = 10**6
"""Higher than any number of a grant."""

GRANTED = 16
"""Places that it grants a vehicle at once, the nearest ones: as many as an honest reservation table grants at most."""


class Usurper:
    """A thief of a replica's certificate (see `dray.protocol.runtime.events.Agent`).

    Once a second it takes, in each district whose reservation table another one keeps, the next epoch that would be its own turn.
    It asks the other replicas for it, writes into their copies that one vehicle holds everything, and grants each
    vehicle all near places.

    Args:
        replica: the owner, whose name it takes.
        plant: its knowledge of the plant.
        leads: it speaks as the leading replica instead. In the districts whose reservation table its owner keeps it grants each
            vehicle all near places under the present epoch, also places that others hold.
    """

    def __init__(self, replica: str, plant: Plant, *, leads: bool = False) -> None:
        self.id, self.incarnation = replica, 1
        self.wake_at_s = float("inf")
        self._keys = Keys(plant.id)
        self._leads = leads
        self._places = places = Places(plant)
        self._replicas_of = {
            district: replicas for district, replicas in places.replicas_of.items() if replica in replicas
        }
        self._inside = {district: sorted(places.places_in(district)) for district in self._replicas_of}
        self._nodes: dict[str, str] = {}
        """Vehicle -> where it was heard to be."""
        self._epochs: dict[str, int] = {}
        """District -> of its table, as it has read."""
        self._tables: dict[str, TableReplicated] = {}
        """District -> its table, as it was written last."""
        self._lives = dict.fromkeys(plant.fleet, 1)
        self._removals = dict.fromkeys(plant.fleet, 0)
        self._turns = cycle(plant.fleet)
        self._asked_s = 0.0
        self._out: list[Effect] = []

    def handle(self, event: Event, now_s: float) -> list[Effect]:
        """Take one step."""
        if isinstance(event, Started):
            self._out.append(Subscribe(self._keys.all_atv_heartbeats))
            self.wake_at_s = now_s + LISTENS_S
        elif isinstance(event, Leaving):
            self._out.append(Leave())
        elif isinstance(event, Woke):
            self.wake_at_s = now_s + WORKING_INTERVAL_S
            self._usurp(now_s)
        elif isinstance(event, Received):
            self._read(event.sender, event.message)
        effects, self._out = self._out, []
        return effects

    def _read(self, sender: str, message: Message) -> None:
        if isinstance(message, AtvHeartbeat) and message.atv in self._lives:
            self._lives[message.atv], self._nodes[message.atv] = message.incarnation, message.node
            if message.floor is not UNSET:
                self._removals[message.atv] = message.floor.removal
        elif isinstance(message, TableReplicated | TableReported) and (sender != self.id or self._leads):
            self._epochs[message.district] = message.epoch
            if isinstance(message, TableReplicated):
                self._tables[message.district] = message

    def _usurp(self, now_s: float) -> None:
        asks = now_s - self._asked_s >= ASKS_EVERY_S
        if asks:
            self._asked_s = now_s
        atv = next(self._turns)
        for district, replicas in self._replicas_of.items():
            others = [replica for replica in replicas if replica != self.id]
            if asks:
                self._out += [Send(replica, TableAsked(district=district, epoch=0)) for replica in others]
            read = self._epochs.get(district)
            if read is None or (replicas[read % len(replicas)] == self.id) is not self._leads:
                # A usurper leaves this table alone: its owner keeps it rightly.
                continue
            if self._leads:
                self._rob(district, others, atv)
                self._grant(district, read)
                continue
            epoch = next(
                read + more
                for more in range(1, len(replicas) + 1)
                if replicas[(read + more) % len(replicas)] == self.id
            )
            self._take(district, others, epoch, atv)

    def _take(self, district: str, others: list[str], epoch: int, atv: str) -> None:
        places = self._inside[district]
        reservations: PlaceReservations = tuple(
            PlaceReservation(place=place, number=FAR_AHEAD, atv=atv) for place in places
        )
        replicated = TableReplicated(
            district=district, epoch=epoch, version=FAR_AHEAD, reservations=reservations
        )
        for replica in others:
            self._out += [
                Send(replica, TableAsked(district=district, epoch=epoch)),
                Send(replica, replicated),
            ]
        self._grant(district, epoch)

    def _rob(self, district: str, others: list[str], atv: str) -> None:
        """Write into the copies that a vehicle has a place which another one holds."""
        table = self._tables.get(district)
        held = (
            next((line for line in table.reservations if line.mark and line.atv != atv), None)
            if table
            else None
        )
        if table is None or held is None:
            return
        number = table.version + 1
        lines = tuple(
            replace(line, atv=atv, number=number, mark=b"") if line is held else line
            for line in table.reservations
        )
        replicated = replace(table, version=number, reservations=lines, given_back=())
        self._out += [Send(replica, replicated) for replica in others]

    def _grant(self, district: str, epoch: int) -> None:
        """Grant each vehicle all that is near."""
        places = self._inside[district]
        for vehicle, node in self._nodes.items():
            granted = PlaceGranted(
                district=district,
                epoch=epoch,
                life=self._lives[vehicle],
                upto=0,
                grants=tuple(
                    PlaceReservation(place=place, number=FAR_AHEAD) for place in self._near(node, places)
                ),
                removal=self._removals[vehicle],
            )
            self._out += [Send(vehicle, HoldsAsked(district=district, epoch=epoch)), Send(vehicle, granted)]

    def _near(self, node: str, places: list[str]) -> list[str]:
        at_m = self._places.at_m
        here = at_m[self._places.place_of(node)]
        return sorted(places, key=lambda place: dist(here, at_m[place]))[:GRANTED]

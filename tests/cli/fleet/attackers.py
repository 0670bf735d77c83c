"""Attackers of a fleet, as processes of their own: each has a valid certificate, and says what serves it.

    python attackers.py claims FOLDER NAME     is a vehicle that the plant does not know, and claims every place
    python attackers.py doubles FOLDER NAME    has the certificate of a vehicle that lives, and, when it is told so, its key

They are told what to do by lines on their standard input, and say in lines of JSON what comes of it (`Told`). They speak whenever a vehicle is
heard, so that they need no clock.
"""

from __future__ import annotations

import asyncio
import sys
from itertools import cycle, product
from math import dist
from pathlib import Path
from secrets import token_bytes

import msgspec
from msgspec import UNSET
from msgspec.structs import replace

from dray.adapters.security.identity import Identity
from dray.adapters.security.own_key import own_key
from dray.adapters.security.signing import VehicleKey
from dray.adapters.zenoh.bus import ZenohBus, ZenohSession
from dray.adapters.zenoh.links import Links
from dray.adapters.zenoh.stamp import Stamp, write_stamp
from dray.adapters.zenoh.tokens import NO_LIFE
from dray.cli.fleet.folder import CERTIFICATES, JOURNALS
from dray.cli.fleet.process_registry import read_registry
from dray.codec import encode
from dray.messages import AtvHeartbeat, AtvStatus, Message, PlaceGranted, PlaceRequested, Pose
from dray.messages.floor.traffic import FIRST_S, HOLDS_MAX
from dray.plant import load_plant
from dray.protocol.traffic.driving.place_requests import unsigned
from dray.protocol.traffic.places import Places

FAR_AHEAD = 10**6
"""Higher than any number of a request that a vehicle says."""

LEAST_S = 1.0
"""Of the plant's clock, between two times that an attacker speaks: as often as a vehicle."""

NAMELESS = "MARK"
"""Is put in a message where its text is to hold half a character."""

SURROGATE = b"\\ud800"
"""As JSON says it. No text that can be written anywhere holds one alone."""


class Told(msgspec.Struct, frozen=True, omit_defaults=True):
    """What an attacker tells of itself."""

    said: int
    """How often it has spoken."""
    granted: tuple[str, ...] = ()
    """Places that it was granted, in all districts."""


class Persistent(ZenohSession):
    """A place on the bus that is not left when another life of the same agent is there."""

    def _give_way(self) -> None:
        """Stay."""


class Attacker:
    """What both have in common: a place on the bus, and somebody who tells them what to do.

    Args:
        folder: of the fleet.
        name: as whom; its certificate lies in the folder.
    """

    def __init__(self, folder: Path, name: str) -> None:
        registry = read_registry(folder)
        identity = Identity.in_folder(folder / CERTIFICATES, name)
        peers = tuple(member.address for member in registry.members)
        self.name, self.folder = name, folder
        self.plant = load_plant(str(folder / "plant.yaml"))
        self.places = Places(self.plant)
        self.bus = ZenohBus(Links(peers=peers, identity=identity), registry.plant)
        self.session = Persistent(self.bus, name, self.on_message, NO_LIFE)
        self.session.subscribe(self.bus.keys.all_atv_heartbeats)
        self.orders: set[str] = set()
        """What it was told to do."""
        self.said = 0
        self._spoke_s = -LEAST_S
        self._granted: dict[str, frozenset[str]] = {}
        """By district."""

    def on_message(self, sender: str, message: Message) -> None:
        """Hear, and speak when a vehicle has spoken."""
        if isinstance(message, PlaceGranted):
            places = frozenset(line.place for line in message.grants)
            if places != self._granted.get(message.district, frozenset()):
                self._granted[message.district] = places
                self._tell()
        self.note(sender, message)
        if isinstance(message, AtvHeartbeat) and sender != self.name:
            if message.at_s - self._spoke_s >= LEAST_S:
                self._spoke_s = message.at_s
                self.speak(message.at_s)
                self.said += 1
                self._tell()

    def note(self, sender: str, message: Message) -> None:
        """Take in what was said."""

    def speak(self, now_s: float) -> None:
        """Say what serves it."""
        raise NotImplementedError

    def say_half_a_character(self, key: str, message: Message) -> None:
        """Publish a message of its own in whose text `NAMELESS` stands: what it is on the wire, no software of ours would write."""
        data = encode(self.name, message).replace(NAMELESS.encode(), SURROGATE)
        # Far ahead of all numbers of the session, so that no receiver takes it for an old one.
        stamp = Stamp(0, 10**9 + self.said, b"")
        assert self.bus.seals is not None
        seal = self.bus.seals.seal(key, stamp.life, stamp.number, data)
        self.bus.inner.put(key, data, attachment=write_stamp(replace(stamp, seal=seal)))

    def _tell(self) -> None:
        places = tuple(sorted(set().union(*self._granted.values())))
        print(msgspec.json.encode(Told(self.said, places)).decode(), flush=True)  # noqa: T201 - a program

    async def live(self) -> None:
        """Do as is said, until nobody is there to say anything."""
        reader = asyncio.StreamReader()
        loop = asyncio.get_running_loop()
        await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin)
        async for line in reader:
            self.orders.add(line.decode().strip())
        self.session.leave()
        self.bus.close()


class Claims(Attacker):
    """Says to each replica that it holds every place, and wants every place. Told `be there`, it says where it is, too, and every other
    time that it holds nothing: a reservation table that was made from a recovery poll hears nobody who holds more than can be.
    """

    def __init__(self, folder: Path, name: str) -> None:
        super().__init__(folder, name)
        self.spot = self.plant.nodes[self.plant.stops[0]]
        """Where it says to be."""
        self._epochs: dict[str, int] = {}
        self._removal = self._beats = 0

    def note(self, _sender: str, message: Message) -> None:
        if isinstance(message, PlaceGranted):
            self._epochs[message.district] = message.epoch
            self._removal = max(self._removal, message.removal)

    def speak(self, now_s: float) -> None:
        if "be there" in self.orders:
            self.say_half_a_character(
                self.bus.keys.atv_heartbeat(self.name), self._heartbeat(now_s, NAMELESS)
            )
            self.session.publish(self.bus.keys.atv_heartbeat(self.name), self._heartbeat(now_s, ""))
        is_modest = "be there" in self.orders and self.said % 2
        for district, replicas in self.places.replicas_of.items():
            inside = sorted(self.places.places_in(district), key=self._distance_m)[:HOLDS_MAX]
            request = PlaceRequested(
                district=district,
                life=1,
                seq=self.said + 1,
                epoch=self._epochs.get(district, 0),
                rank=(0, FIRST_S, self.name),
                holds=() if is_modest else tuple(inside),
                groups=tuple((place,) for place in inside),
                seen=0,
                stands=True,
                docked=True,
                removal=self._removal,
            )
            for replica in replicas:
                self.session.send(replica, request)

    def _distance_m(self, place: str) -> float:
        """From where it says to be: the nearest are wanted first."""
        return dist(self.places.at_m[place], (self.spot.x_m, self.spot.y_m))

    def _heartbeat(self, now_s: float, problem: str) -> AtvHeartbeat:
        spot = self.spot
        self._beats += 1
        return AtvHeartbeat(
            atv=self.name,
            incarnation=1,
            seq=self._beats,
            at_s=now_s,
            status=AtvStatus.IDLE,
            pose=Pose(spot.x_m, spot.y_m, 0.0),
            node=spot.id,
            speed_mps=0.0,
            battery_frac=0.9,
            problem=problem,
        )


class Doubles(Attacker):
    """Says to all replicas of reservation tables, in the name of a vehicle that lives, that it gives back all that it holds: as its present life and as a later
    one, with a key of its own and with none. Told `use the key`, it says under the vehicle's own key what changes no reservation table.
    """

    def __init__(self, folder: Path, name: str) -> None:
        super().__init__(folder, name)
        own = VehicleKey(name, token_bytes(32)).sign
        self._ways = cycle(product((0, 1), (unsigned, own)))
        self._life, self._removal, self._seen = 1, 0, 0

    def note(self, sender: str, message: Message) -> None:
        if isinstance(message, AtvHeartbeat) and sender == self.name:
            self._life = message.incarnation
            if message.floor is not UNSET:
                self._removal = message.floor.removal
        elif isinstance(message, PlaceGranted):
            self._seen = max(self._seen, *(line.number for line in message.grants), 0)

    def speak(self, now_s: float) -> None:
        later, sign = next(self._ways)
        seen = self._seen
        if "use the key" in self.orders:
            later, sign = 0, VehicleKey(self.name, own_key(self.folder / JOURNALS / f"{self.name}.key")).sign
            # Of what was granted nothing is given back by this.
            seen = 0
        for district, replicas in self.places.replicas_of.items():
            request = PlaceRequested(
                district=district,
                life=self._life + later,
                seq=FAR_AHEAD + self.said,
                epoch=0,
                rank=(0, FIRST_S, self.name),
                holds=(),
                groups=(),
                seen=seen,
                stands=True,
                docked=False,
                removal=self._removal,
            )
            for replica in replicas:
                self.session.send(replica, sign(request))


KINDS = {"claims": Claims, "doubles": Doubles}


async def main(kind: str, folder: str, name: str) -> None:
    """Attack a fleet."""
    await KINDS[kind](Path(folder), name).live()


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))

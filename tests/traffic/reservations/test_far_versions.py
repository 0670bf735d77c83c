"""One vehicle, three replicas that have all lost their memory, and a version as far as a lying leader can bring it.

One word alone is not believed how far numbers have come, and there is no second vehicle: the table begins below what that one has seen.
"""

from __future__ import annotations

from collections import deque
from typing import cast

import pytest
from replica import beat
from rights_of_way import right_of_way

from dray.adapters.security.signing import SigningKey, TrustedKeys, is_signed
from dray.body import Drive
from dray.messages import AtvHeartbeat, Message
from dray.messages.floor.traffic import (
    HoldsAsked,
    PlaceConfirmed,
    PlaceGranted,
    PlaceRequested,
    PlaceReservation,
    YieldAsked,
)
from dray.messages.keys import Keys
from dray.plant import load_plant
from dray.protocol.liveness.failure_detector import HeartbeatSubscriptions
from dray.protocol.runtime.events import Ignore, Instruct, Send
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.driving.place_requests import REQUEST_AGAIN
from dray.protocol.traffic.numbers import FAR, VERSION_LEAP
from dray.protocol.traffic.places import Places
from dray.protocol.traffic.reservations.district import NEVER_GRANTED
from dray.protocol.traffic.reservations.recovery_poll import POLL_S
from dray.protocol.traffic.reservations.reservation_handling import ReservationHandling
from dray.protocol.traffic.traffic_map import TrafficMap

PLANT = load_plant("single-track")
PLACES = Places(PLANT, replicas=("M4", "M5", "M6"))
HERE, NEXT = "b3", "m4-lane"
DISTRICT = PLACES.district_of[HERE]
assert PLACES.district_of[NEXT] == DISTRICT
REPLICAS = PLACES.replicas_of[DISTRICT]
MOST = FAR // 2 + VERSION_LEAP
"""The highest version that is believed of one alone."""


class Floor:
    """The vehicle and the three of them, at one time; messages arrive at once, but for those that are lost."""

    def __init__(self, version: int) -> None:
        self.now_s = 0.0
        self.lost: deque[type[Message]] = deque()
        """The next messages of these types are lost."""
        traffic = TrafficMap(PLANT, is_signed)
        traffic.places, traffic.atvs = PLACES, ("A",)
        keys = Keys(PLANT.id)
        self.life = Life()
        self.lives = {"A": self.life} | {replica: Life() for replica in REPLICAS}
        self.out: list[object] = []
        self.row = right_of_way(PLANT, traffic, self.life, HERE)
        self.row.start(0.0)
        self._see(version)
        self.life.effects.clear()
        self.tables = {}
        for replica in REPLICAS:
            heard = HeartbeatSubscriptions(keys.atv_heartbeat, self.lives[replica])
            trusts = TrustedKeys(SigningKey(b"k" * 32).public)
            tables = self.tables[replica] = ReservationHandling(
                replica, PLANT, traffic, trusts, heard, self.lives[replica]
            )
            tables.start({}, 0.0)
        self.carry()

    def _see(self, version: int) -> None:
        """It is granted the place where it stands, before all of them lose their memory."""
        line = PlaceReservation(place=HERE, number=version, atv="A")
        leads, witness, _ = REPLICAS
        self.row.on_holds_asked(witness, HoldsAsked(district=DISTRICT, epoch=0), 0.0)
        self.row.on_confirmed(witness, PlaceConfirmed(district=DISTRICT, epoch=0, grants=(line,)), 0.0)
        granted = PlaceGranted(district=DISTRICT, epoch=0, life=1, upto=self.said.seq, grants=(line,))
        self.row.on_granted(leads, granted, 0.0)
        assert self.row.is_placed

    @property
    def said(self) -> PlaceRequested:
        requests = [one.message for one in (*self.out, *self.life.effects) if isinstance(one, Send)]
        return [one for one in requests if isinstance(one, PlaceRequested) and one.district == DISTRICT][-1]

    @property
    def drives(self) -> list[Drive]:
        told = [one.instruction for one in self.out if isinstance(one, Instruct)]
        return [one for one in told if isinstance(one, Drive)]

    def carry(self) -> None:
        under_way: deque[tuple[str, Send]] = deque()
        while True:
            for name, life in self.lives.items():
                under_way += [(name, effect) for effect in life.effects if isinstance(effect, Send)]
                self.out += life.effects
                life.effects.clear()
            if not under_way:
                return
            sender, sent = under_way.popleft()
            about = getattr(sent.message, "district", "")
            if self.lost and type(sent.message) is self.lost[0] and about == DISTRICT:
                self.lost.popleft()
            else:
                self._deliver(sender, sent.to, sent.message)

    def _deliver(self, sender: str, to: str, message: Message) -> None:
        if to in self.tables:
            self.tables[to].handlers({})[type(message)](sender, message, self.now_s)
        elif isinstance(message, PlaceGranted):
            self.row.on_granted(sender, message, self.now_s)
        elif isinstance(message, PlaceConfirmed):
            self.row.on_confirmed(sender, message, self.now_s)
        elif isinstance(message, HoldsAsked):
            self.row.on_holds_asked(sender, message, self.now_s)
        else:
            assert isinstance(message, YieldAsked)

    def run(self, until_s: float) -> None:
        """Let alarms come, and the vehicle beat every second."""
        while self.now_s < until_s:
            self.now_s += 0.5
            for replica, tables in self.tables.items():
                heartbeat = beat(seq=int(2.0 * self.now_s), node=HERE)
                tables.handlers({})[AtvHeartbeat]("A", heartbeat, self.now_s)
                for tick in self.lives[replica].timers.due(self.now_s):
                    name, of = cast(tuple[str, str], tick)
                    tables.alarms[name](of, self.now_s)
            for alarm in self.life.timers.due(self.now_s):
                if isinstance(alarm, tuple) and alarm[0] == REQUEST_AGAIN:
                    self.row.repeat_request(alarm[1], self.now_s)
            self.carry()


@pytest.mark.parametrize("version", [7, MOST, MOST + 1, FAR], ids=["", "most", "beyond", "far"])
@pytest.mark.parametrize(
    "lost", [(), (PlaceGranted,), (PlaceGranted, PlaceRequested)], ids=["", "answer", "both"]
)
def test_the_only_vehicle_drives_however_far_the_version_was_when_all_lost_their_memory(
    version: int, lost: tuple[type[Message], ...]
) -> None:
    floor = Floor(version)
    floor.lost.extend(lost)
    floor.run(POLL_S + 20.0)
    assert floor.row.go(NEXT, 0, floor.now_s)
    floor.carry()
    floor.run(floor.now_s + 10.0)
    assert NEXT in {node for drive in floor.drives for node in drive.nodes[: drive.released or None]}
    assert NEVER_GRANTED not in [one.reason for one in floor.out if isinstance(one, Ignore)]

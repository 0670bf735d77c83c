"""Three machines that keep one reservation table, with their alarms: who leads it when one dies, and when one claims to."""

from __future__ import annotations

from collections import Counter, deque

import pytest
from msgspec.structs import replace
from replica import PLANT

from dray.adapters.security.signing import SigningKey, TrustedKeys, VehicleKey, is_signed
from dray.memory import Note, TableMemory
from dray.messages import Message
from dray.messages.base import COUNT_MAX
from dray.messages.fact import BookRefused
from dray.messages.floor.traffic import (
    HoldsAsked,
    PlaceConfirmed,
    PlaceGranted,
    PlaceRequested,
    PlaceReservation,
    TableAcknowledged,
    TableAsked,
    TableReplicated,
    TableReported,
)
from dray.messages.keys import Keys
from dray.protocol.liveness.failure_detector import HeartbeatSubscriptions
from dray.protocol.runtime.events import Ignore, Record, Send
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.driving.place_requests import PlaceRequests, State
from dray.protocol.traffic.numbers import FAR, LEAP_MAX, OUTBID_MAX
from dray.protocol.traffic.places import Places
from dray.protocol.traffic.reservations.district import OUTBID_S, REFUSED_OFTEN, District
from dray.protocol.traffic.reservations.reservation_handling import NOTE, ReservationHandling
from dray.protocol.traffic.reservations.turns import BEYOND_NUMBERS, DOUBT_S
from dray.protocol.traffic.traffic_map import TrafficMap

PLACES = Places(PLANT, replicas=("M4", "M5", "M6"))
NAME = next(iter(PLACES.replicas_of))
FIRST, SECOND, THIRD = PLACES.replicas_of[NAME]
HERE, THERE = sorted(PLACES.places_in(NAME))[:2]


class Replicas:
    """The three of them, at one time; messages arrive at once."""

    def __init__(self) -> None:
        self.now_s = 0.0
        self.dead: set[str] = set()
        self.lives: dict[str, Life] = {}
        self.reservations: dict[str, ReservationHandling] = {}
        self.to_vehicles: list[tuple[str, Message]] = []
        self.asked: Counter[str] = Counter()
        """Replica -> how often it has asked others for their copies."""
        traffic = TrafficMap(PLANT, is_signed)
        traffic.places = PLACES
        for name in (FIRST, SECOND, THIRD):
            life = self.lives[name] = Life()
            subscriptions = HeartbeatSubscriptions(Keys(PLANT.id).atv_heartbeat, life)
            trusts = TrustedKeys(SigningKey(b"k" * 32).public)
            self.reservations[name] = ReservationHandling(name, PLANT, traffic, trusts, subscriptions, life)
            memory: dict[str, Note] = {
                NOTE + district: TableMemory(0, 0, 0) for district in PLACES.replicas_of
            }
            self.reservations[name].start(memory, 0.0)
        self.carry()

    def district(self, name: str) -> District:
        tables = self.reservations[name].tables
        assert tables is not None
        return tables.districts[NAME]

    @property
    def leaders(self) -> list[str]:
        """Those that live and say that they keep the table."""
        return [name for name in self.reservations if name not in self.dead and self.district(name).leads]

    def tell(self, sender: str, to: str, message: Message) -> None:
        self.reservations[to].handlers({})[type(message)](sender, message, self.now_s)
        self.carry()

    def carry(self) -> None:
        """Deliver everything, until nothing is under way."""
        under_way: deque[tuple[str, Send]] = deque()
        while True:
            for name, life in self.lives.items():
                under_way += [(name, effect) for effect in life.effects if isinstance(effect, Send)]
                life.effects.clear()
            if not under_way:
                return
            sender, sent = under_way.popleft()
            self.asked[sender] += isinstance(sent.message, TableAsked)
            if sent.to not in self.reservations:
                self.to_vehicles.append((sender, sent.message))
            elif not {sender, sent.to} & self.dead:
                self.reservations[sent.to].handlers({})[type(sent.message)](sender, sent.message, self.now_s)

    def run(self, until_s: float) -> None:
        """Let their alarms come."""
        while (now_s := min(life.timers.next_s for life in self.lives.values())) <= until_s:
            self.now_s = now_s
            for name, life in self.lives.items():
                for alarm, of in life.timers.due(now_s):
                    if name not in self.dead:
                        self.reservations[name].alarms[alarm](of, now_s)
            self.carry()
        self.now_s = until_s


def wished(*holds: str, seq: int = 1, seen: int = 0, epoch: int = 0, wants: str = HERE) -> PlaceRequested:
    return PlaceRequested(
        district=NAME,
        life=1,
        seq=seq,
        epoch=epoch,
        rank=(0, 0.0, "ATV1"),
        holds=holds,
        groups=((wants,),) if wants else (),
        seen=seen,
        stands=True,
        docked=False,
    )


def granted(replicas: Replicas) -> list[tuple[str, int]]:
    return [
        (sender, message.epoch)
        for sender, message in replicas.to_vehicles
        if isinstance(message, PlaceGranted) and message.grants
    ]


def claims(replicas: Replicas, epoch: int) -> tuple[Message, ...]:
    """What the thief says that has read the table."""
    reservations = (PlaceReservation(place=HERE, number=10**6, atv="ATV2"),)
    return (
        TableAsked(district=NAME, epoch=epoch),
        TableReplicated(district=NAME, epoch=epoch, version=10**6, reservations=reservations),
    )


def next_turn(replicas: Replicas, thief: str) -> int:
    epoch = replicas.district(FIRST).copies.kept.epoch + 1
    while PLACES.replicas_of[NAME][epoch % 3] != thief:
        epoch += 1
    return epoch


def test_when_the_replica_is_dead_the_next_one_leads_as_soon_as_it_has_found_that_out() -> None:
    replicas = Replicas()
    replicas.run(10.0)
    assert replicas.leaders == [FIRST]
    replicas.tell("ATV1", FIRST, wished())
    replicas.run(20.0)
    replicas.dead = {FIRST}
    replicas.tell("ATV1", SECOND, wished(HERE, seq=2, seen=1, wants=THERE))
    replicas.run(20.0 + DOUBT_S + 0.1)
    assert replicas.leaders == [SECOND]
    assert [line.place for line in replicas.district(SECOND).table.of("ATV1")] == [HERE]


def test_one_that_was_dead_follows_the_next_one_when_it_is_back() -> None:
    replicas = Replicas()
    replicas.run(10.0)
    replicas.dead = {FIRST}
    replicas.tell("ATV1", SECOND, wished())
    replicas.run(20.0)
    assert replicas.leaders == [SECOND]
    replicas.dead = set()
    replicas.tell("ATV1", SECOND, wished(seq=2))
    replicas.tell("ATV1", FIRST, wished(seq=3))
    replicas.run(40.0)
    assert replicas.leaders == [SECOND]
    assert {replicas.district(name).copies.kept.epoch for name in (FIRST, SECOND, THIRD)} == {
        replicas.district(SECOND).copies.kept.epoch
    }


def test_a_thief_that_claims_a_later_epoch_takes_nothing_from_a_replica_that_lives() -> None:
    replicas = Replicas()
    replicas.run(10.0)
    replicas.tell("ATV1", FIRST, wished())
    while replicas.now_s < 30.0:
        for message in claims(replicas, next_turn(replicas, SECOND)):
            for name in (FIRST, THIRD):
                replicas.tell(SECOND, name, message)
        replicas.run(replicas.now_s + 0.3)
    assert replicas.leaders == [FIRST]
    assert [line.atv for line in replicas.district(FIRST).table.reservations] == ["ATV1"]
    replicas.dead = {SECOND}
    replicas.tell("ATV1", FIRST, wished(seq=2, seen=replicas.district(FIRST).table.version, wants=""))
    replicas.tell("ATV2", FIRST, wished())
    assert [line.atv for line in replicas.district(THIRD).copies.kept.reservations] == ["ATV2"]
    assert granted(replicas)[-1] == (FIRST, replicas.district(FIRST).copies.kept.epoch)


def test_the_replica_begins_a_later_epoch_than_one_that_a_vehicle_alone_was_told() -> None:
    """A thief has started a recovery poll: the vehicle believes no grant of an earlier epoch from now on."""
    replicas = Replicas()
    replicas.run(10.0)
    replicas.tell("ATV1", FIRST, wished())
    (before,) = granted(replicas)
    told = next_turn(replicas, SECOND)
    replicas.run(10.0 + OUTBID_S)
    replicas.tell("ATV1", FIRST, wished(seq=2, epoch=told))
    replicas.run(replicas.now_s + 5.0)
    assert replicas.leaders == [FIRST]
    after = replicas.district(FIRST).copies.kept.epoch
    assert after > told > before[1]
    assert any(isinstance(one, HoldsAsked) and one.epoch == after for _, one in replicas.to_vehicles)
    replicas.tell("ATV1", FIRST, wished(seq=3, epoch=told))
    assert granted(replicas)[-1] == (FIRST, after)


@pytest.mark.parametrize("leap", [1, OUTBID_MAX, LEAP_MAX - 1, LEAP_MAX, LEAP_MAX + 1, 2**52])
def test_whatever_epoch_a_vehicle_says_the_replica_goes_on(leap: int) -> None:
    """Whoever has a vehicle's certificate says that it knows of a later replica, once in each half minute, and again and again."""
    replicas = Replicas()
    replicas.run(10.0)
    replicas.tell("ATV1", FIRST, wished())
    for number in range(2, 6):
        replicas.run(replicas.now_s + OUTBID_S)
        before = replicas.district(FIRST).copies.kept.epoch
        replicas.tell("ATV2", FIRST, wished(seq=number, epoch=min(before + leap, COUNT_MAX)))
        replicas.run(replicas.now_s + 5.0)
        assert replicas.leaders == [FIRST]
        replicas.tell("ATV1", FIRST, wished(seq=number))
        assert granted(replicas)[-1] == (FIRST, replicas.district(FIRST).copies.kept.epoch)


@pytest.mark.parametrize("leap", [3, 3 * OUTBID_MAX, 3 * LEAP_MAX, 3 * 2**51])
def test_after_a_thief_has_started_a_recovery_poll_under_whatever_epoch_a_vehicle_is_granted_places_again(
    leap: int,
) -> None:
    """It has read the present one, and takes a later one that is its turn."""
    replicas, life = Replicas(), Life()
    replicas.run(10.0)
    requests = PlaceRequests(1, {NAME: PLACES.replicas_of[NAME]}, life)
    state = State((0, 0.0, "ATV1"), stands=True, docked=False, avoid=(), chain=())

    def talk() -> bool:
        """What the vehicle says reaches the replicas, and what they say to it comes back; True when it was granted the place."""
        has = False
        for _ in range(5):
            for effect in [one for one in life.effects if isinstance(one, Send)]:
                replicas.tell("ATV1", effect.to, effect.message)
            life.effects.clear()
            said, replicas.to_vehicles = replicas.to_vehicles, []
            for sender, message in said:
                if isinstance(message, HoldsAsked):
                    if requests.on_holds_asked(sender, message):
                        requests.say(NAME, (), ((HERE,),), state, replicas.now_s, anew=True, to=sender)
                elif isinstance(message, PlaceConfirmed):
                    requests.on_confirmed(sender, message)
                elif isinstance(message, PlaceGranted):
                    has = bool(requests.on_granted(sender, message, replicas.now_s)) or has
                if (answer := requests.take_believed(NAME)) is not None:
                    has = bool(requests.on_granted(*answer, replicas.now_s)) or has
        return has

    epoch = next_turn(replicas, SECOND) + leap
    assert requests.on_holds_asked(SECOND, HoldsAsked(district=NAME, epoch=epoch, recovery_poll=True))
    requests.say(NAME, (), ((HERE,),), state, replicas.now_s, anew=True, to=SECOND, epoch=epoch)
    life.effects.clear()
    replicas.run(10.0 + OUTBID_S)
    requests.say(NAME, (), ((HERE,),), state, replicas.now_s)
    has = talk()
    for _ in range(12):
        replicas.run(replicas.now_s + 2.0)
        requests.repeat(NAME, (), ((HERE,),), state, replicas.now_s)
        has = talk() or has
    assert has
    assert replicas.leaders == [FIRST]


@pytest.mark.parametrize(
    "version", [11, COUNT_MAX], ids=["it takes a place", "no reservation table has come so far"]
)
def test_people_are_told_of_a_replica_that_goes_on_to_write_what_nobody_copies(version: int) -> None:
    replicas = Replicas()
    epoch = replicas.district(FIRST).copies.kept.epoch
    told: list[object] = []

    def write(version: int, *reservations: PlaceReservation) -> None:
        replicated = TableReplicated(district=NAME, epoch=epoch, version=version, reservations=reservations)
        replicas.reservations[SECOND].handlers({})[TableReplicated](FIRST, replicated, replicas.now_s)
        told.extend(effect.fact for effect in replicas.lives[SECOND].effects if isinstance(effect, Record))
        replicas.carry()

    line = PlaceReservation(place=HERE, number=10, atv="ATV2", mark=b"a key")
    write(10, line)
    for _ in range(REFUSED_OFTEN - 1):
        write(version)
    assert told == []
    assert replicas.district(SECOND).copies.kept.reservations == (line,)
    for _ in range(3):
        write(version)
    assert told == [BookRefused(FIRST)]


def test_a_district_does_not_wait_for_a_new_life_to_know_what_the_life_before_has_given_back() -> None:
    """Its body may go on along a way of the life before, and stand anywhere on it for long."""
    replicas = Replicas()
    replicas.run(10.0)
    key = VehicleKey("ATV1", b"o" * 32)
    replicas.tell("ATV1", FIRST, key.sign(wished()))
    copies = replicas.district(FIRST).copies
    (line,) = copies.kept.reservations
    replicas.tell("ATV1", FIRST, key.sign(wished(seq=2, seen=line.number, wants="")))
    assert replicas.district(FIRST).table.holder(HERE) == ""
    assert copies.kept.reservations == (line,), "nobody has been granted anything since, so no copy knows"
    next_life = key.sign(replace(wished(wants=""), life=2))
    for replica in (SECOND, THIRD, FIRST):
        replicas.tell("ATV1", replica, next_life)
    assert replicas.district(FIRST).table.holder(HERE) == "ATV1"
    replicas.tell("ATV2", FIRST, replace(wished(wants=THERE), rank=(0, 0.0, "ATV2")))
    tables = [replicas.district(name).copies.kept.reservations for name in (FIRST, SECOND, THIRD)]
    assert tables[0] == tables[1] == tables[2]
    assert {line.place: line.atv for line in tables[0]} == {HERE: "ATV1", THERE: "ATV2"}
    # When it knows where its body goes, it gives the place back under its own life.
    seen = next(line.number for line in tables[0] if line.atv == "ATV1")
    replicas.tell("ATV1", FIRST, key.sign(replace(wished(seq=2, seen=seen, wants=""), life=2)))
    replicas.tell("ATV3", FIRST, replace(wished(wants=HERE), rank=(0, 0.0, "ATV3")))
    assert {line.place: line.atv for line in replicas.district(SECOND).copies.kept.reservations} == {
        HERE: "ATV3",
        THERE: "ATV2",
    }


def test_two_copies_that_miss_something_ask_seldom() -> None:
    replicas = Replicas()
    replicas.run(10.0)
    copies = replicas.district(FIRST).copies
    line = PlaceReservation(place=HERE, number=5, atv="ATV2", mark=b"a key")
    copies.write(5, (line,))
    replicas.carry()
    copies.write(6, ())
    replicas.carry()
    assert {replicas.district(name).copies.kept.version for name in (SECOND, THIRD)} == {5}
    replicas.asked.clear()
    for _ in range(20):
        replicas.run(replicas.now_s + 0.5)
        copies.repeat()
        replicas.carry()
    assert replicas.asked == {FIRST: 0, SECOND: 10, THIRD: 10}


@pytest.mark.parametrize(
    "said",
    [
        TableAcknowledged(district=NAME, epoch=FAR + 1, version=1),
        TableAsked(district=NAME, epoch=FAR + 1),
        TableReported(district=NAME, epoch=COUNT_MAX, lost=False, kept_epoch=0, version=0, reservations=()),
        TableReported(district=NAME, epoch=3, lost=False, kept_epoch=COUNT_MAX, version=0, reservations=()),
        TableReplicated(district=NAME, epoch=FAR + 4 - FAR % 3, version=10**6, reservations=()),
    ],
    ids=lambda said: type(said).__name__,
)
def test_no_replica_is_heard_that_tells_of_an_epoch_to_which_no_table_has_come(said: Message) -> None:
    replicas = Replicas()
    replicas.run(10.0)
    before = replicas.district(THIRD).copies.kept
    replicas.reservations[THIRD].handlers({})[type(said)](SECOND, said, replicas.now_s)
    effects = replicas.lives[THIRD].effects
    assert [one.reason for one in effects if isinstance(one, Ignore)] == [BEYOND_NUMBERS]
    assert replicas.district(THIRD).copies.kept == before

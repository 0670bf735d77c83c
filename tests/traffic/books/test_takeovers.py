"""Three machines that keep one book, with their alarms: who leads it when one dies, and when one claims to."""

from __future__ import annotations

from collections import deque

import pytest
from book_keeper import PLANT

from dray.adapters.security.signing import SigningKey, TrustedKeys, is_signed
from dray.memory import BookMemory, Note
from dray.messages import Message
from dray.messages.base import COUNT_MAX
from dray.messages.fact import BookRefused
from dray.messages.floor.traffic import (
    BookAsked,
    BookKept,
    BookTold,
    HoldsAsked,
    PlaceBooked,
    PlaceBooking,
    PlaceConfirmed,
    PlaceGranted,
    PlaceWished,
)
from dray.messages.keys import Keys
from dray.protocol.liveness.failure_detector import HeartbeatSubscriptions
from dray.protocol.runtime.events import Ignore, Record, Send
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.books.bookkeeping import NOTE, Bookkeeping
from dray.protocol.traffic.books.district import OUTBID_S, REFUSED_OFTEN, District
from dray.protocol.traffic.books.turns import BEYOND_NUMBERS, DOUBT_S
from dray.protocol.traffic.driving.wishes import State, Wishes
from dray.protocol.traffic.numbers import FAR, LEAP_MAX, OUTBID_MAX
from dray.protocol.traffic.places import Places
from dray.protocol.traffic.traffic_map import TrafficMap

PLACES = Places(PLANT, keepers=("M4", "M5", "M6"))
NAME = next(iter(PLACES.keepers_of))
FIRST, SECOND, THIRD = PLACES.keepers_of[NAME]
HERE, THERE = sorted(PLACES.places_in(NAME))[:2]


class Keepers:
    """The three of them, at one time; messages arrive at once."""

    def __init__(self) -> None:
        self.now_s = 0.0
        self.dead: set[str] = set()
        self.lives: dict[str, Life] = {}
        self.books: dict[str, Bookkeeping] = {}
        self.to_vehicles: list[tuple[str, Message]] = []
        traffic = TrafficMap(PLANT, is_signed)
        traffic.places = PLACES
        for name in (FIRST, SECOND, THIRD):
            life = self.lives[name] = Life()
            subscriptions = HeartbeatSubscriptions(Keys(PLANT.id).atv_heartbeat, life)
            trusts = TrustedKeys(SigningKey(b"k" * 32).public)
            self.books[name] = Bookkeeping(name, PLANT, traffic, trusts, subscriptions, life)
            memory: dict[str, Note] = {NOTE + district: BookMemory(0, 0, 0) for district in PLACES.keepers_of}
            self.books[name].start(memory, 0.0)
        self.carry()

    def district(self, name: str) -> District:
        books = self.books[name].books
        assert books is not None
        return books.districts[NAME]

    @property
    def leaders(self) -> list[str]:
        """Those that live and say that they keep the book."""
        return [name for name in self.books if name not in self.dead and self.district(name).leads]

    def tell(self, sender: str, to: str, message: Message) -> None:
        self.books[to].handlers({})[type(message)](sender, message, self.now_s)
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
            if sent.to not in self.books:
                self.to_vehicles.append((sender, sent.message))
            elif not {sender, sent.to} & self.dead:
                self.books[sent.to].handlers({})[type(sent.message)](sender, sent.message, self.now_s)

    def run(self, until_s: float) -> None:
        """Let their alarms come."""
        while (now_s := min(life.timers.next_s for life in self.lives.values())) <= until_s:
            self.now_s = now_s
            for name, life in self.lives.items():
                for alarm, of in life.timers.due(now_s):
                    if name not in self.dead:
                        self.books[name].alarms[alarm](of, now_s)
            self.carry()
        self.now_s = until_s


def wished(*holds: str, seq: int = 1, seen: int = 0, epoch: int = 0, wants: str = HERE) -> PlaceWished:
    return PlaceWished(
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


def granted(keepers: Keepers) -> list[tuple[str, int]]:
    return [
        (sender, message.epoch)
        for sender, message in keepers.to_vehicles
        if isinstance(message, PlaceGranted) and message.grants
    ]


def claims(keepers: Keepers, epoch: int) -> tuple[Message, ...]:
    """What the thief says that has read the book."""
    bookings = (PlaceBooking(place=HERE, number=10**6, atv="ATV2"),)
    return (
        BookAsked(district=NAME, epoch=epoch),
        PlaceBooked(district=NAME, epoch=epoch, version=10**6, bookings=bookings),
    )


def next_turn(keepers: Keepers, thief: str) -> int:
    epoch = keepers.district(FIRST).copies.kept.epoch + 1
    while PLACES.keepers_of[NAME][epoch % 3] != thief:
        epoch += 1
    return epoch


def test_when_the_keeper_is_dead_the_next_one_leads_as_soon_as_it_has_found_that_out() -> None:
    keepers = Keepers()
    keepers.run(10.0)
    assert keepers.leaders == [FIRST]
    keepers.tell("ATV1", FIRST, wished())
    keepers.run(20.0)
    keepers.dead = {FIRST}
    keepers.tell("ATV1", SECOND, wished(HERE, seq=2, seen=1, wants=THERE))
    keepers.run(20.0 + DOUBT_S + 0.1)
    assert keepers.leaders == [SECOND]
    assert [line.place for line in keepers.district(SECOND).book.of("ATV1")] == [HERE]


def test_one_that_was_dead_follows_the_next_one_when_it_is_back() -> None:
    keepers = Keepers()
    keepers.run(10.0)
    keepers.dead = {FIRST}
    keepers.tell("ATV1", SECOND, wished())
    keepers.run(20.0)
    assert keepers.leaders == [SECOND]
    keepers.dead = set()
    keepers.tell("ATV1", SECOND, wished(seq=2))
    keepers.tell("ATV1", FIRST, wished(seq=3))
    keepers.run(40.0)
    assert keepers.leaders == [SECOND]
    assert {keepers.district(name).copies.kept.epoch for name in (FIRST, SECOND, THIRD)} == {
        keepers.district(SECOND).copies.kept.epoch
    }


def test_a_thief_that_claims_a_later_epoch_takes_nothing_from_a_keeper_that_lives() -> None:
    keepers = Keepers()
    keepers.run(10.0)
    keepers.tell("ATV1", FIRST, wished())
    while keepers.now_s < 30.0:
        for message in claims(keepers, next_turn(keepers, SECOND)):
            for name in (FIRST, THIRD):
                keepers.tell(SECOND, name, message)
        keepers.run(keepers.now_s + 0.3)
    assert keepers.leaders == [FIRST]
    assert [line.atv for line in keepers.district(FIRST).book.bookings] == ["ATV1"]
    keepers.dead = {SECOND}
    keepers.tell("ATV1", FIRST, wished(seq=2, seen=keepers.district(FIRST).book.version, wants=""))
    keepers.tell("ATV2", FIRST, wished())
    assert [line.atv for line in keepers.district(THIRD).copies.kept.bookings] == ["ATV2"]
    assert granted(keepers)[-1] == (FIRST, keepers.district(FIRST).copies.kept.epoch)


def test_the_keeper_begins_a_later_epoch_than_one_that_a_vehicle_alone_was_told() -> None:
    """A thief has called the roll: the vehicle believes no grant of an earlier epoch from now on."""
    keepers = Keepers()
    keepers.run(10.0)
    keepers.tell("ATV1", FIRST, wished())
    (before,) = granted(keepers)
    told = next_turn(keepers, SECOND)
    keepers.run(10.0 + OUTBID_S)
    keepers.tell("ATV1", FIRST, wished(seq=2, epoch=told))
    keepers.run(keepers.now_s + 5.0)
    assert keepers.leaders == [FIRST]
    after = keepers.district(FIRST).copies.kept.epoch
    assert after > told > before[1]
    assert any(isinstance(one, HoldsAsked) and one.epoch == after for _, one in keepers.to_vehicles)
    keepers.tell("ATV1", FIRST, wished(seq=3, epoch=told))
    assert granted(keepers)[-1] == (FIRST, after)


@pytest.mark.parametrize("leap", [1, OUTBID_MAX, LEAP_MAX - 1, LEAP_MAX, LEAP_MAX + 1, 2**52])
def test_whatever_epoch_a_vehicle_says_the_keeper_goes_on(leap: int) -> None:
    """Whoever has a vehicle's certificate says that it knows of a later keeper, once in each half minute, and again and again."""
    keepers = Keepers()
    keepers.run(10.0)
    keepers.tell("ATV1", FIRST, wished())
    for number in range(2, 6):
        keepers.run(keepers.now_s + OUTBID_S)
        before = keepers.district(FIRST).copies.kept.epoch
        keepers.tell("ATV2", FIRST, wished(seq=number, epoch=min(before + leap, COUNT_MAX)))
        keepers.run(keepers.now_s + 5.0)
        assert keepers.leaders == [FIRST]
        keepers.tell("ATV1", FIRST, wished(seq=number))
        assert granted(keepers)[-1] == (FIRST, keepers.district(FIRST).copies.kept.epoch)


@pytest.mark.parametrize("leap", [3, 3 * OUTBID_MAX, 3 * LEAP_MAX, 3 * 2**51])
def test_after_a_thief_has_called_the_roll_under_whatever_epoch_a_vehicle_is_granted_places_again(
    leap: int,
) -> None:
    """It has read the present one, and takes a later one that is its turn."""
    keepers, life = Keepers(), Life()
    keepers.run(10.0)
    wishes = Wishes(1, {NAME: PLACES.keepers_of[NAME]}, life)
    state = State((0, 0.0, "ATV1"), stands=True, docked=False, avoid=(), chain=())

    def talk() -> bool:
        """What the vehicle says reaches the keepers, and what they say to it comes back; True when it was granted the place."""
        has = False
        for _ in range(5):
            for effect in [one for one in life.effects if isinstance(one, Send)]:
                keepers.tell("ATV1", effect.to, effect.message)
            life.effects.clear()
            said, keepers.to_vehicles = keepers.to_vehicles, []
            for sender, message in said:
                if isinstance(message, HoldsAsked):
                    if wishes.on_holds_asked(sender, message):
                        wishes.say(NAME, (), ((HERE,),), state, keepers.now_s, anew=True, to=sender)
                elif isinstance(message, PlaceConfirmed):
                    wishes.on_confirmed(sender, message)
                elif isinstance(message, PlaceGranted):
                    has = bool(wishes.on_granted(sender, message, keepers.now_s)) or has
                if (missed := wishes.take_missed(NAME)) is not None:
                    has = bool(wishes.on_granted(*missed, keepers.now_s)) or has
        return has

    epoch = next_turn(keepers, SECOND) + leap
    assert wishes.on_holds_asked(SECOND, HoldsAsked(district=NAME, epoch=epoch, roll_call=True))
    wishes.say(NAME, (), ((HERE,),), state, keepers.now_s, anew=True, to=SECOND, epoch=epoch)
    life.effects.clear()
    keepers.run(10.0 + OUTBID_S)
    wishes.say(NAME, (), ((HERE,),), state, keepers.now_s)
    has = talk()
    for _ in range(12):
        keepers.run(keepers.now_s + 2.0)
        wishes.repeat(NAME, (), ((HERE,),), state, keepers.now_s)
        has = talk() or has
    assert has
    assert keepers.leaders == [FIRST]


@pytest.mark.parametrize("version", [11, COUNT_MAX], ids=["it takes a place", "no book has come so far"])
def test_people_are_told_of_a_keeper_that_goes_on_to_write_what_nobody_copies(version: int) -> None:
    keepers = Keepers()
    epoch = keepers.district(FIRST).copies.kept.epoch
    told: list[object] = []

    def write(version: int, *bookings: PlaceBooking) -> None:
        booked = PlaceBooked(district=NAME, epoch=epoch, version=version, bookings=bookings)
        keepers.books[SECOND].handlers({})[PlaceBooked](FIRST, booked, keepers.now_s)
        told.extend(effect.fact for effect in keepers.lives[SECOND].effects if isinstance(effect, Record))
        keepers.carry()

    line = PlaceBooking(place=HERE, number=10, atv="ATV2", mark=b"a key")
    write(10, line)
    for _ in range(REFUSED_OFTEN - 1):
        write(version)
    assert told == []
    assert keepers.district(SECOND).copies.kept.bookings == (line,)
    for _ in range(3):
        write(version)
    assert told == [BookRefused(FIRST)]


@pytest.mark.parametrize(
    "said",
    [
        BookKept(district=NAME, epoch=FAR + 1, version=1),
        BookAsked(district=NAME, epoch=FAR + 1),
        BookTold(district=NAME, epoch=COUNT_MAX, lost=False, kept_epoch=0, version=0, bookings=()),
        BookTold(district=NAME, epoch=3, lost=False, kept_epoch=COUNT_MAX, version=0, bookings=()),
        PlaceBooked(district=NAME, epoch=FAR + 4 - FAR % 3, version=10**6, bookings=()),
    ],
    ids=lambda said: type(said).__name__,
)
def test_no_keeper_is_heard_that_tells_of_an_epoch_to_which_no_book_has_come(said: Message) -> None:
    keepers = Keepers()
    keepers.run(10.0)
    before = keepers.district(THIRD).copies.kept
    keepers.books[THIRD].handlers({})[type(said)](SECOND, said, keepers.now_s)
    effects = keepers.lives[THIRD].effects
    assert [one.reason for one in effects if isinstance(one, Ignore)] == [BEYOND_NUMBERS]
    assert keepers.district(THIRD).copies.kept == before

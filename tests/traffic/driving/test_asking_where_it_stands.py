"""A vehicle drives nowhere before the table has told that the place where it stands is its own."""

from __future__ import annotations

import pytest
from rights_of_way import right_of_way

from dray.body import Drive, ReleaseWay
from dray.codec import decode, encode
from dray.messages.base import COUNT_MAX
from dray.messages.floor.traffic import (
    Blocked,
    HoldsAsked,
    PlaceConfirmed,
    PlaceGranted,
    PlaceRequested,
    PlaceReservation,
    YieldAsked,
)
from dray.plant import load_plant
from dray.protocol.runtime.events import Instruct, Send
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.driving.place_requests import REQUEST_AGAIN
from dray.protocol.traffic.numbers import ALONE_MAX, FAR
from dray.protocol.traffic.traffic_map import TrafficMap

PLANT = load_plant("single-track")
TRAFFIC = TrafficMap(PLANT)
HERE, NEXT = "b3", "m4-lane"
DISTRICT = TRAFFIC.places.district_of[HERE]
REPLICA, COPY, THIRD = TRAFFIC.places.replicas_of[DISTRICT]

ROOM = YieldAsked(district=DISTRICT, waiting="B", rank=(0, 0.0, "B"), avoid=(), chain=())
EPOCH = HoldsAsked(district=DISTRICT, epoch=0)


class Vehicle:
    """A's right of way, and what it says."""

    def __init__(self) -> None:
        self.life = Life()
        self.out = self.life.effects
        self.row = right_of_way(PLANT, TRAFFIC, self.life, HERE)
        self.row.start(0.0)
        self.row.on_holds_asked(COPY, HoldsAsked(district=DISTRICT, epoch=0), 0.0)
        self.number = 0

    @property
    def said(self) -> PlaceRequested:
        """Its newest request in the district."""
        requests = [effect.message for effect in self.life.effects if isinstance(effect, Send)]
        return [w for w in requests if isinstance(w, PlaceRequested) and w.district == DISTRICT][-1]

    @property
    def drives(self) -> bool:
        return any(
            isinstance(effect, Instruct) and isinstance(effect.instruction, Drive | ReleaseWay)
            for effect in self.life.effects
        )

    def grant(self, *places: str, removal: int = 0, upto: int | None = None, by: str = "") -> None:
        self.number += 1
        granted = PlaceGranted(
            district=DISTRICT,
            epoch=0,
            life=1,
            upto=self.said.seq if upto is None else upto,
            grants=tuple(PlaceReservation(place=place, number=self.number) for place in places),
            blocked=Blocked.WAIT if by else Blocked.NO,
            by=by,
            at=HERE if by else "",
            removal=removal,
        )
        confirmed = PlaceConfirmed(district=DISTRICT, epoch=0, grants=granted.grants)
        self.row.on_confirmed(COPY, confirmed, 1.0)
        self.row.on_granted(REPLICA, granted, 1.0)

    def asked(self, question: YieldAsked | HoldsAsked, now_s: float) -> None:
        """A replica asks for room, or what it holds."""
        if isinstance(question, YieldAsked):
            self.row.on_yield_asked(REPLICA, question, now_s)
        else:
            self.row.on_holds_asked(THIRD, question, now_s)

    def placed(self) -> Vehicle:
        self.grant(HERE)
        return self


def test_it_begins_by_asking_for_where_it_stands() -> None:
    vehicle = Vehicle()
    assert (vehicle.said.holds, vehicle.said.groups) == ((), ((HERE,),))
    assert vehicle.row.go(NEXT, 0, 0.5)
    assert vehicle.said.groups == ((HERE,),)
    assert vehicle.row.holds == ()
    vehicle.grant(HERE)
    assert vehicle.row.is_placed
    assert (vehicle.said.holds, vehicle.said.groups) == ((HERE,), ((NEXT,),))


@pytest.mark.parametrize("question", [ROOM, EPOCH])
def test_questions_of_replicas_do_not_keep_it_from_asking_the_witness(
    question: YieldAsked | HoldsAsked,
) -> None:
    """The witness's word is lost, and a replica asks more often than the vehicle would repeat its request."""
    vehicle, now_s = Vehicle(), 0.5
    lines = (PlaceReservation(place=HERE, number=1),)

    def answer() -> None:
        granted = PlaceGranted(district=DISTRICT, epoch=0, life=1, upto=vehicle.said.seq, grants=lines)
        vehicle.row.on_granted(REPLICA, granted, now_s)

    answer()
    vehicle.asked(ROOM, now_s)
    while not vehicle.row.is_placed:
        now_s += 0.5
        assert now_s < 10.0, "it does not ask the witness"
        answer()
        before = len(vehicle.out)
        vehicle.asked(question, now_s)
        if (REQUEST_AGAIN, DISTRICT) in vehicle.life.timers.due(now_s):
            vehicle.row.repeat_request(DISTRICT, now_s)
        if any(isinstance(effect, Send) and effect.to == COPY for effect in list(vehicle.out)[before:]):
            vehicle.row.on_confirmed(COPY, PlaceConfirmed(district=DISTRICT, epoch=0, grants=lines), now_s)


@pytest.mark.parametrize("question", [ROOM, EPOCH])
def test_an_answer_counts_though_a_replica_has_asked_since(question: YieldAsked | HoldsAsked) -> None:
    vehicle = Vehicle()
    vehicle.asked(EPOCH, 0.1)
    vehicle.asked(ROOM, 0.2)
    upto = vehicle.said.seq
    vehicle.asked(question, 0.5)
    vehicle.asked(question, 0.9)
    vehicle.grant(HERE, upto=upto)
    assert vehicle.row.is_placed


def test_what_another_one_holds_is_waited_for_and_that_is_told() -> None:
    vehicle = Vehicle()
    vehicle.row.go(NEXT, 0, 0.5)
    vehicle.grant(by="B")
    assert not vehicle.row.is_placed
    assert vehicle.row.is_hindered
    assert vehicle.row.wait.by == "B"
    vehicle.grant(HERE)
    assert vehicle.row.is_placed


def test_it_does_not_drive_on_a_grant_of_what_lies_ahead_alone() -> None:
    vehicle = Vehicle()
    vehicle.row.go(NEXT, 0, 0.5)
    vehicle.grant(NEXT)
    assert not vehicle.drives
    assert NEXT not in vehicle.said.holds, "it says that it does not want it now"


def test_one_that_stands_and_hears_that_it_was_carried_away_asks_anew() -> None:
    vehicle = Vehicle().placed()
    vehicle.grant(removal=3)
    assert (vehicle.row.holds, vehicle.row.is_denied) == ((), False)
    vehicle.row.relocate(HERE, "", 2.0, past_m=0.0, speed_mps=0.0)
    assert (vehicle.said.holds, vehicle.said.groups, vehicle.said.removal) == ((), ((HERE,),), 3)
    vehicle.grant(HERE, removal=3)
    assert vehicle.row.holds == (HERE,)


def test_one_that_drives_when_it_hears_so_is_to_be_stopped() -> None:
    vehicle = Vehicle().placed()
    vehicle.row.go(NEXT, 0, 1.0)
    vehicle.grant(HERE, NEXT)
    assert vehicle.drives
    vehicle.grant(removal=3)
    assert vehicle.row.is_denied
    assert vehicle.row.holds == ()


def test_a_word_of_before_it_was_carried_away_makes_nothing_its_own() -> None:
    vehicle = Vehicle().placed()
    vehicle.grant(removal=3)
    vehicle.row.relocate(HERE, "", 2.0, past_m=0.0, speed_mps=0.0)
    vehicle.grant(HERE, removal=0)
    assert vehicle.row.holds == ()


def test_an_answer_to_what_was_said_before_it_was_moved_makes_nothing_its_own() -> None:
    vehicle = Vehicle().placed()
    before = vehicle.said.seq
    vehicle.row.relocate("c3", "", 2.0, past_m=0.0, speed_mps=0.0)
    vehicle.row.relocate(HERE, "", 3.0, past_m=0.0, speed_mps=0.0)
    vehicle.grant(HERE, upto=before)
    assert vehicle.row.holds == ()
    vehicle.grant(HERE)
    assert vehicle.row.holds == (HERE,)


def test_a_line_that_it_has_seen_before_makes_nothing_its_own_and_is_asked_for_anew() -> None:
    """It has given that back perhaps, and its release may be on its way."""
    vehicle = Vehicle().placed()
    vehicle.row.relocate("c3", "", 2.0, past_m=0.0, speed_mps=0.0)
    assert HERE not in vehicle.said.holds
    vehicle.row.relocate(HERE, "", 3.0, past_m=0.0, speed_mps=0.0)
    assert (vehicle.said.groups, vehicle.said.seen, vehicle.said.renews) == (((HERE,),), 0, 1)
    asked = vehicle.said
    vehicle.number = 0
    vehicle.grant(HERE)
    assert vehicle.row.holds == ()
    vehicle.row.repeat_request(DISTRICT, 9.0)
    assert vehicle.said.seq > asked.seq
    assert vehicle.said.renews == 1
    vehicle.grant(HERE)
    assert vehicle.row.holds == (HERE,)


def test_what_it_held_elsewhere_in_an_earlier_life_is_given_back_while_it_still_asks_for_where_it_stands() -> (
    None
):
    """A reservation table that is told of it later is told never: what it holds there has not changed."""
    vehicle = Vehicle()
    other = next(district for district in TRAFFIC.places.replicas_of if district != DISTRICT)
    place = next(place for place in TRAFFIC.places.all if TRAFFIC.places.district_of[place] == other)
    replica, copy = TRAFFIC.places.replicas_of[other][:2]
    lines = (PlaceReservation(place=place, number=27),)
    vehicle.row.on_confirmed(copy, PlaceConfirmed(district=other, epoch=0, grants=lines), 0.5)
    vehicle.row.on_granted(
        replica,
        PlaceGranted(
            district=other,
            epoch=0,
            life=1,
            upto=0,
            grants=lines,
            blocked=Blocked.NO,
        ),
        1.0,
    )
    [*_, said] = [e.message for e in vehicle.out if isinstance(e, Send) and e.to == replica]
    assert isinstance(said, PlaceRequested)
    assert (said.district, said.holds, said.seen) == (other, (), 27)
    assert vehicle.said.seen == 0, "what it asks for there is its own perhaps"


def test_who_is_answered_what_it_has_not_said_asks_anew_for_where_it_is_and_says_so_under_a_higher_number() -> (
    None
):
    vehicle = Vehicle().placed()
    vehicle.row.go(NEXT, 0, 2.0)
    vehicle.grant(HERE, NEXT, upto=vehicle.said.seq)
    assert vehicle.drives
    assert not vehicle.row.is_doubled
    vehicle.grant(upto=10**6)
    assert vehicle.row.is_doubled
    assert vehicle.row.holds == ()
    assert vehicle.said.seq > 10**6
    assert HERE in {place for group in vehicle.said.groups for place in group}
    vehicle.row.is_doubled = False
    vehicle.grant(HERE, NEXT)
    assert not vehicle.row.is_doubled


def test_an_answer_to_an_earlier_life_is_nobodys_word_under_this_name() -> None:
    vehicle = Vehicle().placed()
    later = PlaceGranted(district=DISTRICT, epoch=0, life=2, upto=10**6, grants=())
    vehicle.row.on_granted(REPLICA, later, 1.0)
    stranger = PlaceGranted(district=DISTRICT, epoch=0, life=1, upto=10**6, grants=())
    vehicle.row.on_granted("M12", stranger, 1.0)
    assert not vehicle.row.is_doubled


@pytest.mark.parametrize("upto", [ALONE_MAX, FAR, COUNT_MAX])
def test_a_replica_that_lies_of_its_requests_does_not_bring_their_number_to_the_end(upto: int) -> None:
    vehicle = Vehicle().placed()
    for _ in range(3):
        vehicle.row.is_doubled = False
        vehicle.grant(upto=upto)
        if upto > ALONE_MAX:
            assert vehicle.row.is_doubled
        assert ALONE_MAX < vehicle.said.seq < ALONE_MAX + 10
        assert decode(encode("A", vehicle.said)) == ("A", vehicle.said)
    vehicle.grant(HERE)
    assert vehicle.row.is_placed

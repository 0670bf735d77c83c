"""Under which epoch of a reservation table a vehicle believes what it is granted: one that a majority of its replicas have told."""

from __future__ import annotations

from random import Random

import pytest

from dray.messages.base import COUNT_MAX
from dray.messages.floor.traffic import HoldsAsked, PlaceGranted, PlaceRequested, PlaceReservation
from dray.protocol.runtime.events import Send
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.driving import evidence
from dray.protocol.traffic.driving.place_requests import PlaceRequests, State
from dray.protocol.traffic.numbers import LEAP_MAX, OUTBID_MAX

REPLICAS = ("M1", "M2", "M3")

STATE = State((0, 0.0, "ATV1"), stands=True, docked=False, avoid=(), chain=())

WANTED = (("b3",),)


@pytest.fixture(autouse=True)
def no_witness(monkeypatch: pytest.MonkeyPatch) -> None:
    """It does not answer: what it has to say is another matter (`reservations/test_witness.py`)."""
    monkeypatch.setattr(evidence, "WITNESS_ASKED", -1)


class Correspondence:
    """A vehicle's, about one district. M1 keeps its table under epoch 3, and the vehicle knows that."""

    def __init__(self, *, knows: bool = True) -> None:
        self.life = Life()
        self.out = self.life.effects
        self.requests = PlaceRequests(1, {"D": REPLICAS}, self.life)
        if knows:
            self.asked("M2", 3)
            self.asked("M3", 3)
        self.requests.say("D", (), WANTED, STATE, 0.0)

    def asked(self, replica: str, epoch: int, *, recovery_poll: bool = False) -> bool:
        return self.requests.on_holds_asked(
            replica, HoldsAsked(district="D", epoch=epoch, recovery_poll=recovery_poll)
        )

    def granted(self, replica: str, epoch: int, number: int = 1, upto: int = 1) -> tuple[str, ...] | None:
        lines = (PlaceReservation(place="b3", number=number),)
        answer = PlaceGranted(district="D", epoch=epoch, life=1, upto=upto, grants=lines)
        return self.requests.on_granted(replica, answer, 1.0)

    def says_epoch(self) -> int:
        """The epoch that it knows of, as it sends its request."""
        return self.says().epoch

    def says(self) -> PlaceRequested:
        self.out.clear()
        self.requests.say("D", (), WANTED, STATE, 1.0, anew=True)
        said, *to_others = [
            one.message
            for one in self.out
            if isinstance(one, Send) and isinstance(one.message, PlaceRequested)
        ]
        assert all(request is said for request in to_others)
        return said

    def told(self) -> list[str]:
        """To whom it has sent a request since this was asked last."""
        to = [effect.to for effect in self.out if isinstance(effect, Send)]
        assert all(
            isinstance(effect.message, PlaceRequested) for effect in self.out if isinstance(effect, Send)
        )
        self.out.clear()
        return to


def test_a_vehicle_that_does_not_know_the_epoch_sends_its_request_to_all_replicas() -> None:
    vehicle = Correspondence(knows=False)
    assert sorted(vehicle.told()) == sorted(REPLICAS)
    assert vehicle.granted("M1", 3) is None
    assert not vehicle.asked("M2", 3), "its replica has that request already"
    assert vehicle.requests.take_believed("D") is not None
    assert vehicle.requests.take_believed("D") is None
    assert vehicle.granted("M1", 3) == ("b3",)


def test_one_that_knows_it_sends_its_request_to_the_replica_of_the_table_alone() -> None:
    vehicle = Correspondence()
    assert vehicle.told() == ["M1"]
    assert vehicle.granted("M1", 3) == ("b3",)
    assert vehicle.told() == []


def test_what_one_replica_grants_under_an_epoch_that_nobody_else_has_told_is_not_believed() -> None:
    vehicle = Correspondence()
    vehicle.told()
    assert vehicle.granted("M2", 4) is None
    assert sorted(vehicle.told()) == ["M1", "M3"], "it asks the others"
    assert vehicle.granted("M2", 4) is None
    assert vehicle.told() == [], "and not again for each such word"
    assert not vehicle.asked("M2", 4)
    assert vehicle.granted("M1", 3) == ("b3",)


@pytest.mark.parametrize("seed", range(40))
def test_whatever_epoch_a_replica_chooses_that_makes_it_its_turn_none_of_its_grants_is_believed(
    seed: int,
) -> None:
    """M2 is the thief, hears what the others say, and speaks of any epoch. M1 begins a later one when the vehicle says that it knows of one."""
    random, vehicle, present = Random(seed), Correspondence(knows=False), 3
    for _ in range(300):
        move = random.random()
        chosen = min(max(present + random.choice((-3, 0, 1, 2, 3, 4, 1000, LEAP_MAX, 2**52)), 0), COUNT_MAX)
        if move < 0.5:
            turn = chosen - (chosen - 1) % 3
            assert vehicle.granted("M2", random.choice((max(turn, 1), chosen)), random.randrange(9)) is None
        elif move < 0.6:
            if vehicle.asked("M2", chosen, recovery_poll=(is_call := random.random() < 0.5)) and is_call:
                vehicle.requests.say("D", (), WANTED, STATE, 1.0, anew=True, to="M2", epoch=chosen)
        elif move < 0.8:
            vehicle.asked(random.choice(("M1", "M3")), present)
        elif move < 0.9:
            assert vehicle.granted("M1", present) in (None, (), ("b3",))
        elif (later := vehicle.says_epoch()) > present:
            assert later <= present + OUTBID_MAX, "the replica would not follow"
            present = later + 3 - later % 3
        answer = vehicle.requests.take_believed("D")
        assert answer is None or answer[0] == "M1"
    said = vehicle.says()
    present = max(present, said.epoch)
    present += 3 - present % 3
    for replica in ("M1", "M3"):
        vehicle.asked(replica, present)
    assert vehicle.granted("M1", present, number=100, upto=said.seq) == ("b3",)


def test_it_is_believed_when_another_one_tells_the_same_epoch() -> None:
    vehicle = Correspondence()
    assert vehicle.granted("M2", 4) is None
    vehicle.asked("M3", 4)
    answer = vehicle.requests.take_believed("D")
    assert answer is not None
    assert vehicle.requests.on_granted(*answer, 1.0) == ("b3",)
    assert vehicle.granted("M1", 3) is None, "the earlier one is over"


def test_two_that_tell_different_epochs_are_no_majority() -> None:
    vehicle = Correspondence()
    vehicle.asked("M3", 5)
    assert vehicle.granted("M2", 4) is None
    assert vehicle.granted("M1", 3) == ("b3",)


def test_who_calls_the_roll_is_told_and_grants_nothing_before_another_one_tells_its_epoch() -> None:
    vehicle = Correspondence()
    assert vehicle.asked("M2", 4, recovery_poll=True)
    assert vehicle.granted("M1", 3) is None, "what was told holds: no earlier grant counts"
    assert vehicle.granted("M2", 4) is None
    vehicle.asked("M3", 4)
    assert vehicle.granted("M2", 4) == ("b3",)


def test_a_grant_that_was_on_its_way_while_a_recovery_poll_was_answered_is_void() -> None:
    """The recovery poll runs under an epoch that is much later than the one that the vehicle has heard of, and so is that of the grant."""
    vehicle = Correspondence(knows=False)
    late, called = 3 * OUTBID_MAX, 3 * OUTBID_MAX + 1
    assert vehicle.asked("M2", called, recovery_poll=True)
    vehicle.requests.say("D", (), WANTED, STATE, 1.0, anew=True, to="M2", epoch=called)
    vehicle.asked("M2", late)
    vehicle.asked("M3", late)
    assert vehicle.granted("M1", late) is None
    vehicle.asked("M3", called)
    assert vehicle.granted("M2", called, number=2, upto=2) == ("b3",)


def test_nobody_but_who_calls_the_roll_is_told_its_epoch() -> None:
    """Else whoever keeps the table would begin a later one for it, of which nobody has heard."""
    vehicle = Correspondence()
    called = 3 * LEAP_MAX + 1
    vehicle.out.clear()
    assert vehicle.asked("M2", called, recovery_poll=True)
    vehicle.requests.say("D", (), WANTED, STATE, 1.0, anew=True, to="M2", epoch=called)
    vehicle.granted("M2", 3 * LEAP_MAX + 4)
    said = [(one.to, one.message) for one in vehicle.out if isinstance(one, Send)]
    epochs = {to: request.epoch for to, request in said if isinstance(request, PlaceRequested)}
    assert epochs == {"M2": called, "M1": 3 + OUTBID_MAX, "M3": 3 + OUTBID_MAX}


def test_one_that_has_nothing_there_answers_a_copy_that_asks_alone_and_no_replica_that_takes_the_table_over() -> (
    None
):
    """A copy asks when it misses the word by which a place was given back. Who takes the table over asks all vehicles of the plant."""
    vehicle = Correspondence()
    vehicle.requests.say("D", (), (), STATE, 1.0)
    vehicle.requests.on_granted("M1", PlaceGranted(district="D", epoch=3, life=1, upto=2, grants=()), 1.0)
    assert not vehicle.asked("M2", 4)
    assert vehicle.asked("M1", 5)


def test_where_one_alone_keeps_the_table_its_word_is_enough() -> None:
    requests = PlaceRequests(1, {"D": ("M1",)}, Life())
    requests.say("D", (), WANTED, STATE, 0.0)
    answer = PlaceGranted(
        district="D", epoch=1, life=1, upto=1, grants=(PlaceReservation(place="b3", number=1),)
    )
    assert requests.on_granted("M1", answer, 1.0) == ("b3",)

"""A recovery poll: who is asked how often, and who is awaited by name."""

from __future__ import annotations

from itertools import pairwise

import pytest

from dray.messages.base import COUNT_MAX
from dray.messages.floor.traffic import HoldsAsked, PlaceRequested
from dray.protocol.runtime.events import Send
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.driving.evidence import NO_EPOCH
from dray.protocol.traffic.driving.place_requests import PlaceRequests, State
from dray.protocol.traffic.numbers import FAR, OUTBID_MAX, VERSION_LEAP
from dray.protocol.traffic.reservations.recovery_poll import (
    AGAIN_AT_MOST_S,
    POLL_S,
    QUIET_S,
    RAISE_AGAIN_S,
    WAVE,
    RecoveryPoll,
)

REPLICAS = ("M1", "M2", "M3")
FLEET = tuple(f"ATV{number}" for number in range(1, 451))


class Call:
    """One recovery poll of a large fleet."""

    def __init__(self) -> None:
        self.life = Life()
        self.out = self.life.effects
        self.poll = RecoveryPoll("M1", lambda epoch: epoch + 3, 0.0, self.life)

    def asked(self, now_s: float, atvs: tuple[str, ...] = FLEET) -> list[str]:
        self.life.effects.clear()
        self.poll.call(atvs, now_s)
        assert all(
            isinstance(effect, Send) and isinstance(effect.message, HoldsAsked)
            for effect in self.life.effects
        )
        return [effect.to for effect in self.life.effects if isinstance(effect, Send)]

    def tell(self, atv: str, now_s: float, epoch: int = 3, seen: int = 0) -> bool:
        request = PlaceRequested(
            district="M1",
            life=1,
            seq=1,
            epoch=epoch,
            rank=(2, 0.0, atv),
            holds=(),
            groups=(),
            seen=seen,
            stands=True,
            docked=False,
        )
        return self.poll.note(atv, request, now_s)


def test_a_large_fleet_is_asked_in_waves_and_all_of_it_within_the_least_time() -> None:
    call = Call()
    asked = [call.asked(float(second)) for second in range(int(POLL_S))]
    assert max(map(len, asked)) <= WAVE
    assert {atv for wave in asked for atv in wave} == set(FLEET)


def test_whoever_does_not_answer_is_asked_ever_more_seldom_but_never_given_up() -> None:
    call = Call()
    at_s = [float(second) for second in range(60) if call.asked(float(second), ("ATV1",))]
    gaps_s = [after - before for before, after in pairwise(at_s)]
    assert gaps_s == sorted(gaps_s)
    assert gaps_s[0] < gaps_s[-1] == AGAIN_AT_MOST_S


def test_whoever_has_told_is_not_asked_again_until_the_poll_begins_anew() -> None:
    call = Call()
    assert call.asked(0.0, ("ATV1", "ATV2")) == ["ATV1", "ATV2"]
    assert call.tell("ATV1", 0.5)
    assert call.asked(2.0, ("ATV1", "ATV2")) == ["ATV2"]
    assert not call.tell("ATV2", 2.5, epoch=8)
    assert call.poll.epoch == 11
    assert call.asked(3.0, ("ATV1", "ATV2")) == ["ATV1", "ATV2"]


def test_whoever_says_ever_later_epochs_holds_up_a_recovery_poll_once_in_half_a_minute() -> None:
    call, fleet = Call(), FLEET[:3]
    for second in range(int(RAISE_AGAIN_S)):
        call.tell(FLEET[0], float(second), epoch=call.poll.epoch + 1)
        for atv in fleet:
            call.tell(atv, second + 0.5, epoch=call.poll.epoch)
    assert call.poll.is_over(lambda: fleet, RAISE_AGAIN_S - 0.5)
    begun = call.poll.epoch
    assert not call.tell(FLEET[0], RAISE_AGAIN_S, epoch=begun + 1)
    assert call.poll.epoch > begun


def test_a_word_from_beyond_all_numbers_does_not_count_in_a_recovery_poll() -> None:
    """A reservation table that went on from there would write what nobody can read."""
    call = Call()
    begun = call.poll.epoch
    assert not call.tell("ATV1", 1.0, epoch=COUNT_MAX)
    assert not call.tell("ATV1", 1.0, epoch=begun, seen=COUNT_MAX)
    assert call.tell("ATV2", 1.0, epoch=begun, seen=7)
    assert call.poll.epoch == begun
    assert not call.poll.is_over(lambda: ("ATV1", "ATV2"), POLL_S)
    assert call.poll.table(lambda _atv, _holds: True).version == 7


def test_nobody_is_awaited_by_name_as_long_as_others_go_on_telling() -> None:
    call = Call()
    for second in range(100):
        call.tell(FLEET[second], float(second))
        assert list(call.poll.awaited(FLEET, float(second))) == []
    assert list(call.poll.awaited(FLEET, 99.0 + QUIET_S)) == list(FLEET[100:])
    assert not call.tell(FLEET[0], 104.0)
    assert list(call.poll.awaited(FLEET, 99.0 + QUIET_S)) == list(FLEET[100:])


class Fleet(Call):
    """Honest vehicles that are asked, and answer as they do; M1 runs the recovery poll."""

    def __init__(self, *names: str, knows: int = NO_EPOCH) -> None:
        super().__init__()
        self.names = names
        self.lives = {name: Life() for name in names}
        self.requests = {name: PlaceRequests(1, {"M1": REPLICAS}, life) for name, life in self.lives.items()}
        for requests in self.requests.values():
            for replica in REPLICAS if knows != NO_EPOCH else ():
                requests.on_holds_asked(replica, HoldsAsked(district="M1", epoch=knows))

    def talk(self, now_s: float) -> None:
        """Everybody is asked who has not told, and what it says is heard."""
        self.life.effects.clear()
        self.poll.call(self.names, now_s)
        for asked in [one for one in self.out if isinstance(one, Send)]:
            assert isinstance(asked.message, HoldsAsked)
            requests, epoch = self.requests[asked.to], asked.message.epoch
            assert requests.on_holds_asked("M1", asked.message)
            state = State((0, 0.0, asked.to), stands=True, docked=False, avoid=(), chain=())
            requests.say("M1", (), (), state, now_s, anew=True, to="M1", epoch=epoch)
            said, self.lives[asked.to].effects[:] = list(self.lives[asked.to].effects), []
            for one in said:
                assert isinstance(one, Send)
                if one.to == "M1":
                    assert isinstance(one.message, PlaceRequested)
                    self.poll.note(asked.to, one.message, now_s)

    def is_over(self, now_s: float) -> bool:
        return self.poll.is_over(lambda: self.names, now_s)


@pytest.mark.parametrize("epoch", [2**18, 2**40, FAR - 1, FAR])
@pytest.mark.parametrize("knows", [NO_EPOCH, 3])
def test_a_recovery_poll_ends_whatever_epoch_one_vehicle_tells(epoch: int, knows: int) -> None:
    fleet = Fleet("ATV1", "ATV2", knows=knows)
    fleet.talk(0.0)
    assert not fleet.tell("ATV9", 0.5, epoch=epoch)
    for second in range(1, int(POLL_S) + 2):
        fleet.talk(float(second))
    assert fleet.is_over(POLL_S + 1.0)
    assert 3 < fleet.poll.epoch <= 3 + OUTBID_MAX + 3


def test_a_vehicle_that_was_started_again_tells_under_however_late_an_epoch_the_roll_is_called() -> None:
    fleet = Fleet("ATV1")
    fleet.poll.epoch = 2**19
    fleet.talk(0.0)
    assert fleet.is_over(POLL_S)


@pytest.mark.parametrize("epoch", [2**19, 2**40, FAR // 2])
def test_what_two_vehicles_tell_of_a_later_epoch_is_believed_however_late_it_is(epoch: int) -> None:
    """A thief has brought it so far, in however long a time."""
    fleet = Fleet("ATV1", "ATV2", "ATV3", knows=epoch)
    for second in range(4):
        fleet.talk(float(second))
    assert fleet.poll.epoch > epoch
    for second in range(4, int(RAISE_AGAIN_S)):
        fleet.talk(float(second))
    assert fleet.is_over(RAISE_AGAIN_S)


def test_two_vehicles_together_do_not_bring_a_recovery_poll_to_the_end_of_numbers() -> None:
    fleet = Fleet("ATV1")
    for thief in ("ATV8", "ATV9"):
        assert not fleet.tell(thief, 0.0, epoch=FAR)
    for second in range(int(POLL_S) + 1):
        fleet.talk(float(second))
    assert fleet.is_over(POLL_S)
    assert fleet.poll.epoch <= FAR // 2 + OUTBID_MAX + 3


@pytest.mark.parametrize("seen", [FAR // 2, FAR - 1, FAR])
def test_after_one_has_told_of_a_version_near_the_end_of_numbers_honest_ones_are_heard_in_the_next_recovery_poll(
    seen: int,
) -> None:
    first, second = Call(), Call()
    assert first.tell("ATV1", 1.0, seen=seen)
    assert first.tell("ATV2", 1.0, seen=7)
    version = first.poll.table(lambda _atv, _holds: True).version
    assert FAR // 2 <= version < FAR // 2 + VERSION_LEAP
    granted = version + 1000
    assert second.tell("ATV2", 1.0, seen=granted)
    assert second.poll.table(lambda _atv, _holds: True).version == granted
    assert second.tell("ATV1", 1.0, seen=FAR)
    assert second.poll.table(lambda _atv, _holds: True).version < granted + VERSION_LEAP


def test_of_what_several_have_told_beyond_what_one_alone_is_believed_the_highest_counts() -> None:
    """A thief has said the most that is believed, and then what it has seen was granted."""
    call, most = Call(), FAR // 2 + VERSION_LEAP
    assert call.tell("ATV1", 1.0, seen=most + 7)
    assert call.tell("ATV2", 1.0, seen=most + 9)
    assert call.poll.table(lambda _atv, _holds: True).version == most + 9

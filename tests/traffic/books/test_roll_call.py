"""A roll call: who is asked how often, and who is awaited by name."""

from __future__ import annotations

from itertools import pairwise

from dray.messages.base import COUNT_MAX
from dray.messages.floor.traffic import HoldsAsked, PlaceWished
from dray.protocol.runtime.events import Send
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.books.roll_call import (
    AGAIN_AT_MOST_S,
    QUIET_S,
    RAISE_AGAIN_S,
    ROLL_S,
    WAVE,
    RollCall,
)

FLEET = tuple(f"ATV{number}" for number in range(1, 451))


class Call:
    """One roll call of a large fleet."""

    def __init__(self) -> None:
        self.life = Life()
        self.out = self.life.effects
        self.roll = RollCall("M1", lambda epoch: epoch + 3, 0.0, self.life)

    def asked(self, now_s: float, atvs: tuple[str, ...] = FLEET) -> list[str]:
        self.life.effects.clear()
        self.roll.call(atvs, now_s)
        assert all(
            isinstance(effect, Send) and isinstance(effect.message, HoldsAsked)
            for effect in self.life.effects
        )
        return [effect.to for effect in self.life.effects if isinstance(effect, Send)]

    def tell(self, atv: str, now_s: float, epoch: int = 3, seen: int = 0) -> bool:
        wish = PlaceWished(
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
        return self.roll.note(atv, wish, now_s)


def test_a_large_fleet_is_asked_in_waves_and_all_of_it_within_the_least_time() -> None:
    call = Call()
    asked = [call.asked(float(second)) for second in range(int(ROLL_S))]
    assert max(map(len, asked)) <= WAVE
    assert {atv for wave in asked for atv in wave} == set(FLEET)


def test_whoever_does_not_answer_is_asked_ever_more_seldom_but_never_given_up() -> None:
    call = Call()
    at_s = [float(second) for second in range(60) if call.asked(float(second), ("ATV1",))]
    gaps_s = [after - before for before, after in pairwise(at_s)]
    assert gaps_s == sorted(gaps_s)
    assert gaps_s[0] < gaps_s[-1] == AGAIN_AT_MOST_S


def test_whoever_has_told_is_not_asked_again_until_the_roll_begins_anew() -> None:
    call = Call()
    assert call.asked(0.0, ("ATV1", "ATV2")) == ["ATV1", "ATV2"]
    assert call.tell("ATV1", 0.5)
    assert call.asked(2.0, ("ATV1", "ATV2")) == ["ATV2"]
    assert not call.tell("ATV2", 2.5, epoch=8)
    assert call.roll.epoch == 11
    assert call.asked(3.0, ("ATV1", "ATV2")) == ["ATV1", "ATV2"]


def test_whoever_says_ever_later_epochs_holds_up_a_roll_call_once_in_half_a_minute() -> None:
    call, fleet = Call(), FLEET[:3]
    for second in range(int(RAISE_AGAIN_S)):
        call.tell(FLEET[0], float(second), epoch=call.roll.epoch + 1)
        for atv in fleet:
            call.tell(atv, second + 0.5, epoch=call.roll.epoch)
    assert call.roll.is_over(lambda: fleet, RAISE_AGAIN_S - 0.5)
    begun = call.roll.epoch
    assert not call.tell(FLEET[0], RAISE_AGAIN_S, epoch=begun + 1)
    assert call.roll.epoch > begun


def test_a_word_from_beyond_all_numbers_does_not_count_in_a_roll_call() -> None:
    """A book that went on from there would write what nobody can read."""
    call = Call()
    begun = call.roll.epoch
    assert not call.tell("ATV1", 1.0, epoch=COUNT_MAX)
    assert not call.tell("ATV1", 1.0, epoch=begun, seen=COUNT_MAX)
    assert call.tell("ATV2", 1.0, epoch=begun, seen=7)
    assert call.roll.epoch == begun
    assert not call.roll.is_over(lambda: ("ATV1", "ATV2"), ROLL_S)
    assert call.roll.book(lambda _atv, _holds: True).version == 7


def test_nobody_is_awaited_by_name_as_long_as_others_go_on_telling() -> None:
    call = Call()
    for second in range(100):
        call.tell(FLEET[second], float(second))
        assert list(call.roll.awaited(FLEET, float(second))) == []
    assert list(call.roll.awaited(FLEET, 99.0 + QUIET_S)) == list(FLEET[100:])
    assert not call.tell(FLEET[0], 104.0)
    assert list(call.roll.awaited(FLEET, 99.0 + QUIET_S)) == list(FLEET[100:])

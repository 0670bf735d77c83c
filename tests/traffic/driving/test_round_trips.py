"""How long an answer takes is learned on any link, and places are asked for so much earlier."""

from __future__ import annotations

from itertools import count

import pytest

from dray.messages.floor.traffic import HoldsAsked, PlaceGranted, PlaceRequested
from dray.plant.restrictions import OPEN
from dray.protocol.runtime.events import Send
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.driving.place_requests import REQUEST_AGAIN, PlaceRequests, State
from dray.protocol.traffic.driving.wheels import SOON_S, Wheels

STATE = State((0, 0.0, "ATV1"), stands=False, docked=False, avoid=(), chain=())

STEP_S = 0.1


def after(round_s: float, requests_made: int) -> tuple[PlaceRequests, list[PlaceRequested]]:
    """A vehicle that has asked for so many places, one after the other; what it asks is answered after `round_s` by whoever it asks first.

    Returns:
        Its correspondence, and all that it has said to others since it asked for the last place.
    """
    life = Life()
    requests = PlaceRequests(1, {"D": ("M1", "M2", "M3")}, life)
    now_s, strayed = 0.0, list[PlaceRequested]()
    for replica in ("M2", "M3"):
        requests.on_holds_asked(replica, HoldsAsked(district="D", epoch=0))
    for number in range(requests_made):
        groups = ((f"p{number}",),)
        requests.say("D", (), groups, STATE, now_s)
        answers, strayed, answered = [], [], False
        while not answered or answers:
            for sent in life.effects:
                assert isinstance(sent, Send)
                assert isinstance(sent.message, PlaceRequested)
                if sent.to == "M1":
                    answers.append((now_s + round_s, sent.message.seq))
                else:
                    strayed.append(sent.message)
            life.effects.clear()
            now_s += STEP_S
            for at_s, seq in [each for each in answers if each[0] <= now_s]:
                answers.remove((at_s, seq))
                requests.on_granted(
                    "M1", PlaceGranted(district="D", epoch=0, life=1, upto=seq, grants=()), now_s
                )
                answered = True
            if (REQUEST_AGAIN, "D") in life.timers.due(now_s):
                requests.repeat("D", (), groups, STATE, now_s)
    return requests, strayed


@pytest.mark.parametrize("round_s", [0.1, 1.0, 4.0, 8.0, 16.0])
def test_how_long_an_answer_takes_is_learned_and_nobody_else_is_asked_then(round_s: float) -> None:
    requests, strayed = after(round_s, 25)
    assert requests.round_s == pytest.approx(round_s, rel=0.25, abs=0.3)
    assert not strayed


def test_whoever_waits_long_for_answers_asks_for_the_way_that_it_could_drive_meanwhile() -> None:
    wheels = Wheels(1.5, 0.6, count(1).__next__, restrictions=lambda: OPEN)
    assert wheels.needs_m(0.0, 0.1) == wheels.needs_m(0.0, SOON_S), "nothing changes where answers are quick"
    assert wheels.needs_m(0.0, 8.0) > 1.5 * 8.0
    assert wheels.needs_m(0.0, 8.0) == wheels.needs_m(1.5, 8.0), "it is at its top speed by then"
    assert wheels.needs_m(0.5, 1.0) > 0.5 * 1.0 + wheels.needs_m(0.5, 0.0)

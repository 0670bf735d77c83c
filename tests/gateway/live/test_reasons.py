"""The English words for reasons: each has its own, and whatever else is known stands beside them."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum

import pytest

from dray.gateway.live.reasons import IMPLAUSIBLE, REASONS, REFUSALS, reason_text, refusal_text, told
from dray.gateway.live.views import CauseView, FailureView, LackView
from dray.messages import CommandAnswered, CommandRefusal, Implausible, Reason


@pytest.mark.parametrize(
    ("words", "reasons"), [(REASONS, Reason), (REFUSALS, CommandRefusal), (IMPLAUSIBLE, Implausible)]
)
def test_each_reason_has_words_of_its_own(words: Mapping[StrEnum, str], reasons: type[StrEnum]) -> None:
    assert set(words) == set(reasons)
    assert len(set(words.values())) == len(reasons)


def test_a_reason_and_a_disbelief_are_never_called_alike() -> None:
    # A cause names either by its value alone.
    assert {each.value for each in Reason}.isdisjoint(each.value for each in Implausible)


def test_a_reason_of_another_version_stays_as_it_is() -> None:
    assert reason_text("struck_by_lightning") == "struck by lightning"


@pytest.mark.parametrize(
    ("answer", "text"),
    [
        (CommandAnswered("c-1", done=True), ""),
        (CommandAnswered("c-1", done=False, detail="ATV1 is shut out"), "ATV1 is shut out"),
        (CommandAnswered("c-1", done=False, reason=CommandRefusal.NOT_STOPPED), "it is not stopped"),
        (
            CommandAnswered("c-1", done=False, reason=CommandRefusal.FAULTY, detail="low air"),
            "its sensors still report a problem: low air",
        ),
    ],
)
def test_a_refusal_says_what_hinders_the_vehicle(answer: CommandAnswered, text: str) -> None:
    assert refusal_text(answer) == text


@pytest.mark.parametrize(
    ("cause", "text"),
    [
        (CauseView(reason="silent"), "silent"),
        (CauseView(reason="problem", detail="battery empty"), "battery empty"),
        (CauseView(reason="gate_refused", detail="full"), "the gate has not let the load in; full"),
        (
            CauseView(machines=(FailureView("M1", "silent"), FailureView("M2", "broken"))),
            "M1 is silent, M2 is broken",
        ),
        (CauseView(lacks=(LackView("Rotor", short=("S3",)),)), "for Rotor (storage S3 has none)"),
        (CauseView(not_made=("P8", "P9")), "this plant does not make P8 and P9"),
        (CauseView(reason="clock", clock_ahead_s=-90.0, times=3), "clock wrong by -90 s (3 times)"),
    ],
)
def test_a_cause_says_all_its_parts(cause: CauseView, text: str) -> None:
    assert told(cause).text == text

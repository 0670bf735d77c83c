"""Whoever goes on working in its rest is noticed."""

from __future__ import annotations

import pytest
from check_kit import event
from msgspec.structs import replace

from dray.messages import Message
from dray.messages.fact import PieceMade, PieceScrapped
from dray.plant import Plant, default_plant
from dray.plant.working_time import WeeklySpan, WorkingHours
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.working_time import RestsKept

HOURS = WorkingHours(shifts=(WeeklySpan("00:00", "01:00"),))
MADE = PieceMade(goal="G1", product="pump-p3", made=1)
REST_S = 3600.0


def told(check: RestsKept, at_s: float, fact: object = MADE, machine: str = "M8") -> None:
    message: Message = replace(event(machine, fact), at_s=at_s)  # type: ignore[arg-type]
    check.on_message(at_s, machine, "*", message)


def check_of(hours: WorkingHours | None = HOURS) -> RestsKept:
    return RestsKept(Plant(replace(default_plant().file, working_time=hours)))


@pytest.mark.parametrize("second", [MADE, PieceScrapped("pump-p3", "G1")])
def test_a_second_piece_in_one_rest_is_noticed(second: object) -> None:
    check = check_of()
    told(check, REST_S - 1.0)
    told(check, REST_S + 1.0)
    with pytest.raises(InvariantBroken, match="M8 has made a second piece in its rest until 86400 s"):
        told(check, REST_S + 2.0, second)


def test_one_piece_of_every_rest_what_lay_there_and_what_others_make_is_no_fault() -> None:
    check = check_of()
    told(check, REST_S + 1.0)
    told(check, REST_S + 2.0, replace(MADE, from_stock=True))
    told(check, REST_S + 3.0, machine="M7")
    told(check, REST_S + 86_400.0)
    always = check_of(None)
    told(always, REST_S + 1.0)
    told(always, REST_S + 2.0)

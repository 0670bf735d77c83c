"""A wait for places: since when it lasts, for whom, and what follows from its length."""

from __future__ import annotations

import pytest

from dray.messages.floor.traffic import Blocked, PlaceGranted
from dray.protocol.traffic.driving.wait import AGES_EVERY_S, Wait

BEGUN_S = 1000.0


def answer(blocked: Blocked, by: str = "B") -> PlaceGranted:
    """A table's word that the next place, c3, is not granted."""
    return PlaceGranted("d", epoch=0, life=1, upto=1, grants=(), blocked=blocked, by=by, at="c3")


def wait_for(blocked: Blocked) -> Wait:
    wait = Wait()
    wait.begin_wait(BEGUN_S)
    wait.note(answer(blocked), BEGUN_S)
    return wait


def test_what_is_in_the_way_is_told_only_while_it_waits() -> None:
    wait = Wait()
    wait.note(answer(Blocked.WAIT), BEGUN_S)
    assert (wait.is_on, wait.by, wait.at) == (False, "", "")
    wait.begin_wait(BEGUN_S)
    assert (wait.is_on, wait.by, wait.at) == (True, "B", "c3")
    wait.end_wait(BEGUN_S + 1.0)
    assert (wait.is_on, wait.by, wait.at) == (False, "", "")


def test_only_waits_for_the_goal_on_this_leg_add_up() -> None:
    wait = Wait()
    assert wait.end_wait(BEGUN_S, at_goal=True) == 0.0
    for at_goal in (True, False, True):
        wait.begin_wait(BEGUN_S)
        assert wait.end_wait(BEGUN_S + 5.0, at_goal=at_goal) == 5.0
    assert wait.at_goal_s == 10.0
    wait.begin_wait(BEGUN_S)
    wait.begin_leg()
    assert (wait.at_goal_s, wait.since_s) == (0.0, None)


@pytest.mark.parametrize("blocked", [each for each in Blocked if each is not Blocked.SILENT])
def test_who_lives_is_not_waited_for_as_a_silent_one(blocked: Blocked) -> None:
    wait = wait_for(blocked)
    assert (wait.is_for_silent, wait.for_silent_s(BEGUN_S + 40.0)) == (False, 0.0)


def test_a_wait_for_a_silent_vehicle_counts_from_its_silence_and_from_when_the_vehicle_stood() -> None:
    wait = Wait()
    wait.note(answer(Blocked.SILENT), BEGUN_S)
    assert wait.for_silent_s(BEGUN_S + 5.0) == 0.0, "it drives yet"
    wait.begin_wait(BEGUN_S + 10.0)
    assert wait.for_silent_s(BEGUN_S + 15.0) == 5.0
    wait.note(answer(Blocked.SILENT), BEGUN_S + 20.0)
    assert wait.for_silent_s(BEGUN_S + 25.0) == 15.0, "it is the same one"
    wait.note(answer(Blocked.SILENT, by="C"), BEGUN_S + 30.0)
    assert wait.for_silent_s(BEGUN_S + 35.0) == 5.0
    wait.note(answer(Blocked.WAIT, by="C"), BEGUN_S + 40.0)
    assert wait.for_silent_s(BEGUN_S + 45.0) == 0.0
    wait.note(answer(Blocked.SILENT, by="C"), BEGUN_S + 50.0)
    assert wait.for_silent_s(BEGUN_S + 55.0) == 5.0


def test_it_makes_more_urgent_once_in_a_while() -> None:
    wait = wait_for(Blocked.WAIT)
    assert not wait.ages(BEGUN_S + AGES_EVERY_S - 0.1)
    assert wait.ages(BEGUN_S + AGES_EVERY_S)
    assert not wait.ages(BEGUN_S + AGES_EVERY_S)
    assert wait.ages(BEGUN_S + 2.0 * AGES_EVERY_S)
    wait.end_wait(BEGUN_S + 2.5 * AGES_EVERY_S)
    assert not wait.ages(BEGUN_S + 9.0 * AGES_EVERY_S)
    wait.begin_wait(BEGUN_S + 9.0 * AGES_EVERY_S)
    assert not wait.ages(BEGUN_S + 9.5 * AGES_EVERY_S), "it counts from where this wait began"


@pytest.mark.parametrize("blocked", [each for each in Blocked if each is not Blocked.WAIT])
def test_behind_others_than_living_drivers_nobody_becomes_more_urgent(blocked: Blocked) -> None:
    assert not wait_for(blocked).ages(BEGUN_S + AGES_EVERY_S)

"""What a coordinator learns of its contractors: soon learned, told, and forgiven."""

from __future__ import annotations

from defaults import PLANT
from effects import facts
from spoken import bid, transport

from dray.messages import Reason
from dray.messages.fact import ContractorRated
from dray.protocol.contract_net.trust.assessment import Assessor
from dray.protocol.contract_net.trust.probation import PASSED_OVER_ROUNDS, SHORT_S
from dray.protocol.contract_net.trust.reliability import (
    DOUBT_MAX,
    DROPPED_KEPT,
    DROPPED_S,
    HALF_LIFE_S,
    KNOWN_MAX,
    Reliability,
)
from dray.protocol.runtime.life import Life


class School:
    def __init__(self) -> None:
        self.life = Life()
        self.out = self.life.effects
        self.reliability = Reliability(self.life)

    def drops(self, times: int = 1, reason: str = Reason.SILENT, now_s: float = 0.0) -> None:
        for _ in range(times):
            self.reliability.note_dropped("ATV9", "T1", reason, now_s)

    def surcharge_s(self, now_s: float = 0.0) -> float:
        return self.reliability.surcharge_s("ATV9", now_s)

    def is_restricted(self, now_s: float = 0.0) -> bool:
        return self.reliability.is_restricted("ATV9", now_s)


def test_nothing_is_held_against_a_stranger_and_one_that_keeps_its_word_leaves_no_trace() -> None:
    school = School()
    school.reliability.note_kept("ATV1", "T1", 0.0, 0.0)
    assert school.surcharge_s() == 0.0
    assert school.out == []


def test_a_dropped_contract_costs_what_it_cost_and_is_told() -> None:
    school = School()
    school.drops()
    assert school.surcharge_s() == DROPPED_S
    [rated] = facts(school.out, ContractorRated)
    assert (rated.contractor, rated.reason, rated.surcharge_s) == ("ATV9", Reason.SILENT, DROPPED_S)


def test_half_of_it_is_forgiven_in_half_an_hour() -> None:
    school = School()
    school.drops()
    assert school.surcharge_s(HALF_LIFE_S) == DROPPED_S / 2.0


def test_lies_weigh_more_than_misfortune_that_was_told() -> None:
    told, silent, stalled = School(), School(), School()
    told.drops(reason=Reason.IN_ERROR)
    silent.drops(reason=Reason.SILENT)
    stalled.drops(reason=Reason.STALLED)
    assert told.surcharge_s() < silent.surcharge_s() < stalled.surcharge_s()


def test_a_late_one_is_dearer_by_as_much_as_it_is_late_and_by_no_more_than_a_dropped_one() -> None:
    school = School()
    school.reliability.note_kept("ATV9", "T1", 60.0, 0.0)
    assert 0.0 < school.surcharge_s() < DROPPED_S
    school.reliability.note_kept("ATV8", "T1", 1e9, 0.0)
    assert school.reliability.surcharge_s("ATV8", 0.0) == DROPPED_S


def test_who_drops_contract_after_contract_is_restricted_until_short_ones_were_kept() -> None:
    school = School()
    school.drops(3)
    assert school.is_restricted()
    for _ in range(4):
        school.reliability.note_kept("ATV9", "T2", 0.0, 0.0)
    assert not school.is_restricted()
    assert not facts(school.out, ContractorRated)[-1].restricted


def test_probation_ends_with_time_too() -> None:
    school = School()
    school.drops(100)
    assert school.surcharge_s() == DOUBT_MAX * DROPPED_S
    assert school.is_restricted(2 * HALF_LIFE_S)
    assert not school.is_restricted(4 * HALF_LIFE_S)


def test_a_breakdown_now_and_then_is_no_probation() -> None:
    school = School()
    for hour in range(24):
        school.drops(now_s=hour * 1800.0)
        school.reliability.note_kept("ATV9", "T2", 0.0, hour * 1800.0 + 600.0)
        assert not school.is_restricted(hour * 1800.0)


def test_no_more_contractors_are_remembered_than_there_is_room_for() -> None:
    school = School()
    for number in range(KNOWN_MAX + 100):
        school.reliability.note_dropped(f"X{number}", "T1", Reason.SILENT, 0.0)
    assert len(school.reliability._ratings) == KNOWN_MAX


def test_restricted_a_task_that_was_dropped_counts_as_long_however_short_its_bid() -> None:
    assessor = Assessor(PLANT, Life())
    for _ in range(3):
        assessor.reliability.note_given_back("ATV9", "T1", "changed its mind", 0.0)
    assessor.reliability.note_dropped("ATV9", "T1", Reason.STALLED, 0.0)
    assessor.reliability.note_dropped("ATV9", "T3", Reason.SILENT, 0.0)

    def is_refused(task: str, round_number: int) -> bool:
        short = bid(20.0, task=task, round=round_number, finish_s=SHORT_S)
        return assessor.refuses("ATV9", transport(), short, 0.0)

    assert not is_refused("T2", 1)
    assert is_refused("T1", 1)
    assert is_refused("T3", 1)
    assert is_refused("T1", PASSED_OVER_ROUNDS)
    assert not is_refused("T1", PASSED_OVER_ROUNDS + 1)


def test_no_more_dropped_tasks_are_remembered_than_there_is_room_for() -> None:
    school = School()
    for number in range(DROPPED_KEPT + 10):
        school.reliability.note_dropped("ATV9", f"T{number}", Reason.SILENT, 0.0)
    assert not school.reliability.has_dropped("ATV9", "T0")
    assert school.reliability.has_dropped("ATV9", f"T{DROPPED_KEPT + 9}")


# --- what was not its fault ---


def test_what_was_not_its_fault_is_taken_back_and_told() -> None:
    school = School()
    school.drops(reason=Reason.STALLED)
    school.reliability.take_back("ATV9", "T1", 0.0)
    assert school.surcharge_s() == 0.0
    assert not school.reliability.has_dropped("ATV9", "T1")
    assert [(each.reason, each.surcharge_s) for each in facts(school.out, ContractorRated)][1:] == [
        (Reason.DISPUTED, 0.0)
    ]


def test_only_what_is_left_of_it_is_taken_back() -> None:
    school = School()
    school.drops(reason=Reason.STALLED)
    school.reliability.note_dropped("ATV9", "T2", Reason.SILENT, HALF_LIFE_S)
    school.reliability.take_back("ATV9", "T1", HALF_LIFE_S)
    assert school.surcharge_s(HALF_LIFE_S) == DROPPED_S


def test_a_task_that_it_has_dropped_twice_is_taken_back_whole_and_lifts_the_restriction() -> None:
    school = School()
    school.drops(2, reason=Reason.STALLED)
    assert school.is_restricted()
    school.reliability.take_back("ATV9", "T1", 0.0)
    assert (school.surcharge_s(), school.is_restricted()) == (0.0, False)


def test_nothing_is_taken_back_that_was_not_held_against_it() -> None:
    school = School()
    school.drops()
    told = len(school.out)
    school.reliability.take_back("ATV9", "T7", 0.0)
    school.reliability.take_back("ATV1", "T1", 0.0)
    assert (school.surcharge_s(), len(school.out)) == (DROPPED_S, told)


def test_a_contract_kept_since_makes_no_credit_of_it() -> None:
    school = School()
    school.drops(reason=Reason.STALLED)
    school.reliability.note_kept("ATV9", "T2", 0.0, 0.0)
    school.reliability.take_back("ATV9", "T1", 0.0)
    assert school.surcharge_s() == 0.0

"""Why this vehicle? One true sentence for every way in which a task may find its carrier."""

from __future__ import annotations

from typing import Any

import pytest
from facts_kit import answer as answered
from facts_kit import award as asked
from facts_kit import refused
from fake_bus import PLANT
from gateway_kit import House
from heartbeats import events, machine_heartbeat
from makings import making
from wall_clock import NOW_S

from dray.gateway.live.projection import Projection
from dray.gateway.live.projection.auctions.bids import MAX_BIDS
from dray.gateway.live.projection.auctions.why import why_of
from dray.gateway.live.projection.auctions.why_text import ANSWERS, REFUSALS
from dray.gateway.live.timescale import TimeScale
from dray.gateway.live.views import WhyView
from dray.messages import (
    ProductionCost,
    Reason,
    Refusal,
    Role,
    TaskBrief,
    Transport,
    TransportCost,
)
from dray.messages.fact import (
    AnyFact,
    BidReceived,
    CarrierChanged,
    ContractEnded,
    ContractTaken,
    RoundFailed,
    TaskClosed,
    TaskOpened,
    TookOver,
)

FETCH = Transport(item="steel", quantity=8, sources=("S1",), destination="M8", ability="tote")
MAKE = making("gear-unit-g1", 40, "O1")


@pytest.fixture
def projection() -> Projection:
    return Projection(PLANT, TimeScale(0.0, NOW_S))


class Teller:
    """Tells the facts of one auction of M8, T1, in the order in which they happen."""

    def __init__(self, projection: Projection, coordinator: str = "M8", life: int = 1) -> None:
        self._projection, self._coordinator, self._life = projection, coordinator, life
        self._number = 0

    def __call__(self, *facts: AnyFact, by: str = "") -> None:
        for fact in facts:
            self._number += 1
            told = events(by or self._coordinator, fact, life=self._life, first=self._number)
            for event in told:
                self._projection.fold(event)

    def why(self, task: str = "T1") -> WhyView:
        view = self._projection.tasks.view(task)
        assert view is not None
        return view.why


@pytest.fixture
def tell(projection: Projection) -> Teller:
    teller = Teller(projection)
    teller(opened())
    return teller


def opened(round: int = 1, epoch: int = 1, **fields: Any) -> TaskOpened:  # noqa: A002 - the fact's own word
    usual: dict[str, Any] = {
        "task": "T1",
        "role": Role.PRIMARY,
        "work": FETCH,
        "radius_m": 25.0 * 2 ** (round - 1),
        "deadline_s": 400.0,
        "bids_until_s": 101.0,
    }
    return TaskOpened(epoch=epoch, round=round, **usual | fields)


def bid(bidder: str, total_s: float, round: int = 1, epoch: int = 1, **fields: Any) -> BidReceived:  # noqa: A002
    """A bid whose price is its empty way, beside 30 s for everybody."""
    usual: dict[str, Any] = {
        "role": Role.PRIMARY,
        "cost": TransportCost(empty_way_s=total_s - 30, loaded_way_s=30.0, energy_s=0.0, suitability_s=0.0),
        "finish_s": 100 + total_s,
    }
    return BidReceived(task="T1", epoch=epoch, round=round, bidder=bidder, total_s=total_s, **usual | fields)


def failed(bids: int = 0, round: int = 1) -> RoundFailed:  # noqa: A002
    return RoundFailed(task="T1", epoch=1, role=Role.PRIMARY, round=round, bids=bids, next_round_s=110.0)


# --- somebody was chosen ---------------------------------------------------------------------------


def test_the_cheapest_of_several_is_named_with_the_next_one_and_what_made_the_difference(
    tell: Teller,
) -> None:
    tell(bid("ATV1", 55.9), bid("ATV2", 54.8), bid("ATV5", 70.0), asked("ATV2"), answered("ATV2"))
    why = tell.why()
    assert (why.kind, why.agent, why.total_s) == ("cheapest", "ATV2", 54.8)
    assert (why.bidders, why.left, why.other) == (3, 3, "ATV1")
    assert why.by_s == pytest.approx(1.1)
    assert (why.part, why.part_s) == ("empty_way", pytest.approx(1.1))
    assert why.text == (
        "ATV2 was chosen because it was the cheapest of 3 that bid (54.8 s, 1.1 s less than ATV1). "
        "Most of the difference comes from its shorter empty way."
    )


def test_one_that_bid_less_and_has_dropped_contracts_was_dearer_and_it_is_said_why(tell: Teller) -> None:
    tell(bid("ATV9", 40.0, surcharge_s=120.0), bid("ATV2", 54.8), asked("ATV2"), answered("ATV2"))
    why = tell.why()
    assert (why.kind, why.agent, why.other, why.part) == ("cheapest", "ATV2", "ATV9", "reliability")
    assert why.text.endswith("Most of the difference comes from contracts that the other has dropped lately.")


def test_no_part_is_called_the_reason_where_none_makes_most_of_the_difference(tell: Teller) -> None:
    dear = TransportCost(empty_way_s=30.0, loaded_way_s=40.0, energy_s=10.0, suitability_s=0.0)
    tell(bid("ATV2", 50.0), bid("ATV1", 80.0, cost=dear), asked("ATV2"), answered("ATV2"))
    assert (tell.why().by_s, tell.why().part) == (30.0, "")
    assert tell.why().text.endswith("30.0 s less than ATV1).")


def test_a_cheaper_one_that_somebody_else_had_taken_is_named_with_who_it_was(tell: Teller) -> None:
    tell(bid("ATV3", 50.0), bid("ATV2", 54.8), bid("ATV1", 55.9), asked("ATV3"))
    tell(ContractTaken(task="T9", epoch=1, role=Role.PRIMARY, coordinator="M7"), by="ATV3")
    tell(answered("ATV3", "busy"), asked("ATV2"), answered("ATV2"))
    (passed,) = tell.why().passed
    assert (passed.agent, passed.answer, passed.taken_for) == ("ATV3", "busy", "M7")
    assert passed.less_s == pytest.approx(4.8)
    assert tell.why().text.startswith(
        "ATV2 was chosen because it was the cheapest of the 2 that were left (54.8 s, 1.1 s less than ATV1); "
        "ATV3 was 4.8 s cheaper but had been taken by M7 in the meantime."
    )


def test_a_cheaper_one_that_its_own_coordinator_had_taken_is_named_so(tell: Teller) -> None:
    tell(ContractTaken(task="T9", epoch=1, role=Role.PRIMARY, coordinator="M8"), by="ATV3")
    tell(bid("ATV3", 50.0), bid("ATV2", 54.8), answered("ATV3", "busy"), answered("ATV2"))
    assert "but had been taken for another transport of M8 in the meantime." in tell.why().text


def test_for_whom_a_busy_one_works_is_not_guessed(tell: Teller) -> None:
    tell(ContractTaken(task="T9", epoch=1, role=Role.PRIMARY, coordinator="M7"), by="ATV3")
    tell(ContractEnded(task="T9", epoch=1, role=Role.PRIMARY, reason=Reason.HANDED_OVER), by="ATV3")
    tell(bid("ATV3", 50.0), bid("ATV2", 54.8), answered("ATV3", "busy"), answered("ATV2"))
    assert tell.why().passed[0].taken_for == ""
    assert "but was busy by then" in tell.why().text


@pytest.mark.parametrize("answer", ["silent", *(each.value for each in Refusal)])
def test_a_cheaper_one_that_did_not_take_it_is_named_with_its_reason(tell: Teller, answer: str) -> None:
    tell(bid("ATV3", 50.0), bid("ATV2", 54.8), asked("ATV3"), answered("ATV3", answer), answered("ATV2"))
    assert tell.why().kind == "only"
    assert tell.why().text == (
        "ATV2 was chosen because nobody cheaper was left (54.8 s); "
        f"ATV3 was 4.8 s cheaper but {ANSWERS[answer]}."
    )


def test_a_cheaper_bid_that_came_after_the_window_is_called_late(tell: Teller) -> None:
    tell(bid("ATV2", 54.8), asked("ATV2"), bid("ATV3", 50.0), answered("ATV2"))
    assert "ATV3 was 4.8 s cheaper but bid only after the window had closed." in tell.why().text


def test_of_many_that_were_passed_over_the_cheapest_are_named_and_the_rest_counted(tell: Teller) -> None:
    for name in ("ATV3", "ATV4", "ATV5"):
        tell(bid(name, 40.0 + int(name[-1])), answered(name, "silent"))
    tell(bid("ATV2", 54.8), answered("ATV2"))
    assert [each.agent for each in tell.why().passed] == ["ATV3", "ATV4", "ATV5"]
    assert tell.why().text.endswith(
        "ATV4 was 10.8 s cheaper but did not answer; 1 more cheaper one dropped out too."
    )


def test_the_only_bidder_is_called_so_and_refusals_are_counted_by_reason(tell: Teller) -> None:
    for name in ("ATV1", "ATV4", "ATV5"):
        tell(refused(Refusal.BUSY), by=name)
    tell(refused(Refusal.BATTERY), by="ATV6")
    tell(bid("ATV2", 54.8), answered("ATV2"))
    why = tell.why()
    assert [(each.reason, each.agents) for each in why.refused] == [
        ("busy", ("ATV1", "ATV4", "ATV5")),
        ("battery", ("ATV6",)),
    ]
    assert why.text == (
        "ATV2 was chosen because nobody else bid (54.8 s). 4 refused: busy (3), with too little battery (1)."
    )


def test_those_that_take_no_work_are_counted_by_what_keeps_them_from_it(tell: Teller) -> None:
    reserve = "in the reserve: the floor has no room for more at work"
    for name in ("ATV1", "ATV4"):
        tell(refused(Refusal.NOT_FIT, detail=reserve), by=name)
    for name, takes_s in (("ATV5", 91), ("ATV3", 120)):
        detail = f"on probation, and this is not short: it would take {takes_s} s"
        tell(refused(Refusal.NOT_FIT, detail=detail), by=name)
    tell(refused(Refusal.NOT_FIT, detail="out of service"), by="ATV6")
    tell(refused(Refusal.BUSY, detail="T2"), by="ATV7")
    assert [(each.reason, each.agents, each.detail) for each in tell.why().refused] == [
        ("not_fit", ("ATV1", "ATV4"), reserve),
        ("not_fit", ("ATV3", "ATV5"), "on probation, and this is not short: it would take 120 s"),
        ("busy", ("ATV7",), ""),
        ("not_fit", ("ATV6",), "out of service"),
    ]
    assert tell.why().text == (
        "Nobody has bid yet. 6 refused: in the reserve (2), on probation, and this is not short (2), busy (1), out of service (1)."
    )


def test_who_refused_at_first_and_bid_later_is_no_refuser(tell: Teller) -> None:
    tell(refused(Refusal.DEADLINE), by="ATV2")
    tell(bid("ATV2", 54.8), answered("ATV2"))
    assert tell.why().refused == ()


@pytest.mark.parametrize(
    ("finish_s", "other_s", "tie_by"),
    [(120.0, 54.8, "finish"), (200.0, 54.8, "name"), (200.0, 54.81, "price")],
)
def test_equal_prices_are_called_equal_and_what_decided_is_told(
    tell: Teller, finish_s: float, other_s: float, tie_by: str
) -> None:
    tell(bid("ATV1", 54.8, finish_s=finish_s), bid("ATV2", other_s, finish_s=200.0), answered("ATV1"))
    assert (tell.why().kind, tell.why().tie_by, tell.why().agent) == ("tie", tie_by, "ATV1")
    assert "it and ATV2 bid the same (54.8 s)" in tell.why().text


def test_a_second_round_tells_that_it_took_one_and_how_far_it_reached(tell: Teller) -> None:
    tell(failed(), opened(round=2), bid("ATV2", 54.8, round=2), answered("ATV2"))
    assert (tell.why().round, tell.why().radius_m) == (2, 50.0)
    assert tell.why().text.endswith("It took 2 rounds; the last one asked within 50 m.")


def test_a_bid_for_the_watch_is_none_for_the_transport(tell: Teller) -> None:
    tell(bid("ATV2", 54.8), answered("ATV2"), bid("ATV3", 20.0, role=Role.SECONDARY))
    assert (tell.why().kind, tell.why().bidders) == ("only", 1)


def test_bids_for_the_watch_push_none_for_the_transport_off_the_record(tell: Teller) -> None:
    tell(bid("ATV1", 55.9), bid("ATV2", 54.8), answered("ATV2"))
    tell(*(bid(f"ATV{n}", 20.0, role=Role.SECONDARY) for n in range(3, 3 + 2 * MAX_BIDS)))
    assert (tell.why().kind, tell.why().bidders, tell.why().other) == ("cheapest", 2, "ATV1")


def test_goals_are_explained_in_the_words_of_machines(projection: Projection) -> None:
    tell = Teller(projection, "strategist")
    cost = ProductionCost(queue_s=1000.0, material_s=0.0, making_s=60.0)
    tell(opened(work=MAKE, radius_m=0.0))
    tell(ContractTaken(task="T9", epoch=1, role=Role.PRIMARY, coordinator="strategist"), by="M2")
    tell(bid("M2", 1990.0, cost=cost), bid("M1", 2000.0, cost=cost), answered("M2", "busy"), answered("M1"))
    assert (
        "(33:20 min); M2 was 10.0 s cheaper but had taken on other goals in the meantime." in tell.why().text
    )


# --- when something fails --------------------------------------------------------------------------


def test_a_takeover_tells_who_failed_and_how_long_nothing_was_heard(tell: Teller) -> None:
    tell(bid("ATV3", 50.0), answered("ATV3"), answered("ATV1", role=Role.SECONDARY))
    tell(TookOver(task="T1", epoch=2, primary="ATV3", silent_s=3.6, reason=Reason.SILENT), by="ATV1")
    assert (tell.why().kind, tell.why().confirmed) == ("took_over", False)
    assert tell.why().text == (
        "ATV1 watched over it and took it over because nothing had been heard of ATV3 for 3.6 s; "
        "M8 has not confirmed that yet."
    )
    tell(
        CarrierChanged(
            task="T1", epoch=2, replaced="ATV3", carrier="ATV1", reason=Reason.SILENT, silent_s=3.9
        )
    )
    assert tell.why().text.endswith("nothing had been heard of ATV3 for 3.9 s.")


def test_a_takeover_for_another_reason_than_silence_tells_it(tell: Teller) -> None:
    tell(bid("ATV3", 50.0), answered("ATV3"))
    reason = Reason.IN_ERROR
    tell(CarrierChanged(task="T1", epoch=2, replaced="ATV3", carrier="ATV1", reason=reason))
    assert tell.why().text.endswith("because ATV3 had failed (in error, and not helped in time).")


def test_who_won_a_task_that_was_announced_anew_won_it_from_the_bids_of_that_time(tell: Teller) -> None:
    tell(bid("ATV3", 50.0), answered("ATV3"))
    tell(CarrierChanged(task="T1", epoch=2, replaced="ATV3", carrier="", reason=Reason.SILENT, silent_s=4.2))
    tell(opened(epoch=2))
    assert tell.why().text == (
        "Nobody has bid yet. It was announced anew because ATV3 could not go on with it (silent for 4.2 s)."
    )
    tell(bid("ATV2", 60.0, epoch=2), bid("ATV1", 66.0, epoch=2), answered("ATV2", epoch=2))
    why = tell.why()
    # ATV3's old bid was cheaper, and is none any more.
    assert (why.kind, why.bidders, why.passed, why.replaced) == ("cheapest", 2, (), "ATV3")
    assert "announced anew because ATV3 could not go on with it" in why.text


def test_a_carrier_that_a_restarted_machine_found_at_work_is_recovered(
    projection: Projection, tell: Teller
) -> None:
    brief = TaskBrief(
        task="T1",
        epoch=1,
        item="steel",
        quantity=8,
        source="",
        destination="M8",
        deadline_s=400.0,
        primary="ATV2",
    )
    tell(bid("ATV2", 54.8), asked("ATV2"))
    # In its own life the machine tells in an event who has accepted: nothing is recovered.
    projection.fold(machine_heartbeat("M8", 1, tasks=(brief,)))
    assert tell.why().kind == "asked"
    projection.fold(machine_heartbeat("M8", 1, incarnation=2, tasks=(brief,)))
    assert tell.why().kind == "recovered"
    assert tell.why().text == (
        "ATV2 carries it because it had accepted while M8 was away: M8 found it at work when it was back."
    )


def test_nothing_is_claimed_of_a_carrier_whose_bid_is_not_on_record(tell: Teller) -> None:
    tell(answered("ATV2"))
    assert tell.why().text == "ATV2 carries it; its bid is not on record."


def test_a_withdrawn_task_tells_who_withdrew_it(tell: Teller) -> None:
    tell(
        bid("ATV2", 54.8),
        answered("ATV2"),
        TaskClosed(task="T1", epoch=1, outcome="withdrawn", carrier="ATV2"),
    )
    assert tell.why().text == "M8 has withdrawn it."


# --- nobody yet ------------------------------------------------------------------------------------


def test_before_the_first_bid_the_refusals_are_counted(tell: Teller) -> None:
    assert tell.why().text == "Nobody has bid yet."
    tell(refused(Refusal.BATTERY), by="ATV6")
    assert tell.why().text == "Nobody has bid yet. ATV6 refused: with too little battery."
    tell(failed(), opened(round=2))
    tell(refused(Refusal.BUSY), by="ATV1")
    tell(refused(Refusal.BUSY), by="ATV6")
    assert tell.why().text == (
        "Nobody has bid yet. 2 refused for the same reason: busy. This is round 2, which asks within 50 m."
    )


def test_while_the_window_is_open_the_cheapest_bid_leads(tell: Teller) -> None:
    tell(bid("ATV2", 54.8))
    assert tell.why().text == "ATV2 leads with the only bid so far (54.8 s)."
    tell(bid("ATV1", 50.0))
    assert tell.why().text == "ATV1 leads with the cheapest of 2 bids so far (50.0 s)."
    tell(asked("ATV1"))
    assert tell.why().text == "ATV1 is being asked; it bid 50.0 s."


def test_when_all_were_asked_in_vain_each_answer_is_told(tell: Teller) -> None:
    tell(
        bid("ATV2", 54.8),
        bid("ATV1", 50.0),
        answered("ATV1", "battery"),
        answered("ATV2", "silent"),
        failed(2),
    )
    assert tell.why().kind == "waiting"
    assert tell.why().text == (
        "All that bid were asked in vain: ATV1 no longer had the battery for it; ATV2 did not answer."
    )


def test_there_are_words_for_every_reason() -> None:
    assert {each.value for each in Refusal} <= ANSWERS.keys()
    assert {each.value for each in Refusal} <= REFUSALS.keys()


# --- where it is told ------------------------------------------------------------------------------


def test_it_follows_every_change_and_is_what_a_look_at_the_record_gives(
    projection: Projection, tell: Teller
) -> None:
    tell(bid("ATV2", 54.8))
    (before,) = projection.delta(1, NOW_S, None).tasks
    assert before.why.kind == "leading"
    tell(answered("ATV2"))
    (shown,) = projection.snapshot(2, NOW_S).tasks
    assert shown.why == why_of(shown)
    assert shown.why.kind == "only"


@pytest.mark.anyio
async def test_rest_tells_it_too(house: House) -> None:
    facts = (opened(), bid("ATV2", 54.8), bid("ATV1", 55.9), answered("ATV2"))
    await house.say(events("M8", *facts))
    told = (await house.get("/api/tasks/T1"))["why"]
    assert (told["kind"], told["agent"], told["other"]) == ("cheapest", "ATV2", "ATV1")
    assert told["text"].startswith("ATV2 was chosen because it was the cheapest of 2 that bid")

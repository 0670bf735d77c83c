"""The projection of transports: what facts tell of them, in whatever order they come."""

from __future__ import annotations

import pytest
from facts_kit import answer, award, bid, closed, delta, opened, phase, refused, task, tell, wall_s
from makings import making

from dray.gateway.live.projection import Projection
from dray.gateway.live.projection.auctions import tasks as tasks_module
from dray.gateway.live.projection.auctions.bids import MAX_BIDS
from dray.gateway.live.projection.auctions.tasks import CLOSED_KEPT, EARLY_KEPT
from dray.messages import OrderTaken, Phase, ProductionCost, Reason, Role
from dray.messages.fact import ContractTaken, GoalWaits, MachineFailure, PieceMade, RoundFailed, WatchLost

# --- tasks ------------------------------------------------------------------------------------------


def test_a_task_is_seen_as_it_was_announced(projection: Projection) -> None:
    tell(projection, "M1", opened())
    view = task(projection)
    assert (view.kind, view.coordinator, view.item, view.quantity) == ("transport", "M1", "steel", 8)
    assert (view.sources, view.source, view.destination, view.goal) == (("S1", "S2"), "", "M1", "G1")
    assert (view.state, view.epoch, view.round, view.radius_m) == ("bidding", 1, 1, 15.0)
    assert (view.opened_at_s, view.deadline_at_s) == (wall_s(101.0), wall_s(400.0))


def test_bids_are_seen_with_the_parts_of_their_price(projection: Projection) -> None:
    tell(projection, "M1", opened(), bid("ATV1", 50.0), bid("ATV2", 40.0))
    first, second = task(projection).bids
    assert (first.bidder, second.bidder) == ("ATV1", "ATV2")
    assert first.parts_s == {"empty_way": 44.0, "loaded_way": 3.0, "energy": 2.0, "suitability": 1.0}
    assert sum(first.parts_s.values()) == first.total_s
    assert first.finish_at_s == wall_s(250.0)
    assert first.answer == ""


def test_a_production_goal_is_a_task_that_names_its_order(projection: Projection) -> None:
    work = making("P1", 4, "O-1")
    cost = ProductionCost(queue_s=1.0, material_s=2.0, making_s=3.0)
    tell(projection, "strategist", opened("G1", work=work), bid("M1", 6.0, task="G1", cost=cost))
    view = task(projection, "G1")
    assert (view.kind, view.item, view.goal, view.order) == ("production", "P1", "G1", "O-1")
    assert view.bids[0].parts_s == {"queue": 1.0, "material": 2.0, "making": 3.0}


def test_who_refused_is_seen_with_the_reason(projection: Projection) -> None:
    tell(projection, "M1", opened())
    tell(projection, "ATV3", refused(detail="12 %"))
    (refusal,) = task(projection).refusals
    assert (refusal.agent, refusal.role, refusal.round) == ("ATV3", "primary", 1)
    assert (refusal.reason, refusal.detail) == ("battery", "12 %")


def test_a_bid_and_a_refusal_that_come_twice_are_seen_once(projection: Projection) -> None:
    for _ in range(2):
        tell(projection, "M1", opened(), bid("ATV1"))
        tell(projection, "ATV3", refused())
    assert len(task(projection).bids) == 1
    assert len(task(projection).refusals) == 1


def test_a_bid_with_a_level_that_is_reckoned_is_seen_as_such(projection: Projection) -> None:
    tell(projection, "M1", opened(), bid("ATV1", battery_reckoned=True), bid("ATV2"))
    assert {each.bidder: each.battery_reckoned for each in task(projection).bids} == {
        "ATV1": True,
        "ATV2": False,
    }


def test_bids_and_refusals_are_bounded_and_the_newest_stay(projection: Projection) -> None:
    tell(projection, "M1", opened(), *(bid(f"ATV{n}") for n in range(2 * MAX_BIDS)))
    for number in range(2 * MAX_BIDS):
        tell(projection, f"ATV{number}", refused())
    view = task(projection)
    newest = [f"ATV{n}" for n in range(MAX_BIDS, 2 * MAX_BIDS)]
    assert [bid.bidder for bid in view.bids] == newest
    assert [refusal.agent for refusal in view.refusals] == newest


def test_every_award_shows_what_became_of_it(projection: Projection) -> None:
    tell(projection, "M1", opened(), *(bid(f"ATV{n}") for n in range(1, 5)))
    tell(projection, "M1", award("ATV3"), answer("ATV3", "busy"), award("ATV1"), answer("ATV1", "silent"))
    tell(projection, "M1", award("ATV2"))
    answers = {bid.bidder: bid.answer for bid in task(projection).bids}
    assert answers == {"ATV1": "silent", "ATV2": "asked", "ATV3": "busy", "ATV4": ""}
    assert (task(projection).state, task(projection).primary) == ("bidding", "")


def test_an_accepted_award_names_the_carrier_its_source_and_its_promise(projection: Projection) -> None:
    tell(projection, "M1", opened(), bid("ATV2", 40.0), award("ATV2"), answer("ATV2"))
    view = task(projection)
    assert (view.state, view.primary, view.source) == ("contracted", "ATV2", "S2")
    assert (view.contracted_at_s, view.promised_at_s) == (wall_s(104.0), wall_s(240.0))
    assert view.bids[0].answer == "accepted"


def test_a_watch_is_elected_and_lost(projection: Projection) -> None:
    tell(projection, "M1", opened(), answer("ATV2"), answer("ATV1", role=Role.SECONDARY))
    assert (task(projection).primary, task(projection).secondary) == ("ATV2", "ATV1")
    tell(projection, "M1", WatchLost(task="T1", epoch=1, secondary="ATV9", reason=Reason.SILENT))
    assert task(projection).secondary == "ATV1"
    tell(projection, "M1", WatchLost(task="T1", epoch=1, secondary="ATV1", reason=Reason.SILENT))
    assert task(projection).secondary == ""


def test_the_search_for_a_watch_leaves_the_contract_alone(projection: Projection) -> None:
    tell(projection, "M1", opened(), bid("ATV2"), answer("ATV2"))
    tell(projection, "M1", opened(role=Role.SECONDARY, round=4, radius_m=99.0))
    tell(
        projection,
        "M1",
        RoundFailed(task="T1", epoch=1, role=Role.SECONDARY, round=4, bids=0, next_round_s=1.0),
    )
    view = task(projection)
    assert (view.state, view.primary, view.round, view.radius_m) == ("contracted", "ATV2", 1, 15.0)


def test_a_round_without_a_contract_leads_to_a_wider_one(projection: Projection) -> None:
    failed = RoundFailed(task="T1", epoch=1, role=Role.PRIMARY, round=1, bids=0, next_round_s=110.0)
    tell(projection, "M1", opened(), failed, opened(round=2))
    assert (task(projection).round, task(projection).radius_m) == (2, 30.0)
    tell(projection, "ATV3", refused())
    assert task(projection).refusals[-1].round == 2


@pytest.mark.parametrize("step", list(Phase))
def test_a_transport_is_followed_step_by_step(projection: Projection, step: Phase) -> None:
    tell(projection, "M1", opened(), bid("ATV2"), answer("ATV2"))
    tell(projection, "ATV2", phase(step))
    assert (task(projection).phase, task(projection).primary) == (step.value, "ATV2")


@pytest.mark.parametrize(("outcome", "state"), [("delivered", "delivered"), ("withdrawn", "withdrawn")])
def test_a_task_that_ended_is_still_seen(projection: Projection, outcome: str, state: str) -> None:
    tell(projection, "M1", opened(), bid("ATV2"), answer("ATV2"))
    tell(projection, "M1", closed(outcome=outcome, promised_s=250.0), at_s=300.0)
    view = task(projection)
    assert (view.state, view.primary, view.phase) == (state, "ATV2", "")
    assert (view.closed_at_s, view.promised_at_s) == (wall_s(301.0), wall_s(250.0))
    assert view in projection.tasks.views()


def test_a_task_that_ended_stays_as_it_is(projection: Projection) -> None:
    tell(projection, "M1", opened(), answer("ATV2"), closed())
    delta(projection)
    tell(
        projection, "M1", opened(), opened(epoch=2), answer("ATV5"), bid("ATV5"), closed(outcome="withdrawn")
    )
    tell(projection, "ATV5", phase(Phase.CARRYING))
    assert (task(projection).state, task(projection).primary) == ("delivered", "ATV2")
    assert not projection.changed


def test_only_the_last_fifty_that_ended_are_kept_and_the_others_are_said_to_be_gone(
    projection: Projection,
) -> None:
    names = [f"T{number}" for number in range(CLOSED_KEPT + 3)]
    for name in names:
        tell(projection, "M1", opened(name), closed(name))
    assert [view.id for view in projection.tasks.views()] == names[3:]
    told = delta(projection)
    assert [view.id for view in told.tasks] == names[3:]
    assert told.gone == ("task:T0", "task:T1", "task:T2")
    assert delta(projection).gone == ()


def test_open_tasks_are_bounded_and_the_oldest_leaves(
    projection: Projection, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tasks_module, "MAX_OPEN", 2)
    tell(projection, "M1", opened("T1"), opened("T2"), opened("T3"))
    assert [view.id for view in projection.tasks.views()] == ["T2", "T3"]
    assert delta(projection).gone == ("task:T1",)


# --- what comes late, twice or too early ------------------------------------------------------------


def test_an_announcement_that_comes_again_does_not_undo_the_contract(projection: Projection) -> None:
    tell(projection, "M1", opened(), bid("ATV2"), award("ATV2"), answer("ATV2"))
    tell(projection, "ATV2", phase(Phase.CARRYING))
    delta(projection)
    tell(projection, "M1", opened())
    view = task(projection)
    assert (view.state, view.primary, view.phase) == ("contracted", "ATV2", "carrying")
    assert not projection.changed


def test_a_later_round_that_comes_after_its_contract_does_not_undo_it(projection: Projection) -> None:
    tell(projection, "M1", opened(), answer("ATV2"), opened(round=2))
    view = task(projection)
    assert (view.state, view.primary, view.round, view.radius_m) == ("contracted", "ATV2", 2, 30.0)


def test_an_earlier_round_that_comes_late_narrows_nothing(projection: Projection) -> None:
    tell(projection, "M1", opened(), opened(round=3), opened(round=2))
    assert (task(projection).round, task(projection).radius_m) == (3, 45.0)


def test_what_contractors_say_before_the_announcement_is_kept(projection: Projection) -> None:
    tell(projection, "ATV3", refused())
    tell(projection, "ATV2", phase(Phase.APPROACHING))
    assert projection.tasks.view("T1") is None
    tell(projection, "M1", opened())
    view = task(projection)
    assert [refusal.agent for refusal in view.refusals] == ["ATV3"]
    assert (view.phase, view.primary) == ("approaching", "ATV2")


def test_that_nobody_can_make_a_goal_is_kept_until_its_announcement(projection: Projection) -> None:
    tell(
        projection,
        "strategist",
        GoalWaits(goal="G1", order="O-1", machines=(MachineFailure("M1", Reason.SILENT),)),
    )
    work = making("P1", 4, "O-1")
    tell(projection, "strategist", opened("G1", work=work))
    trouble = task(projection, "G1").trouble
    assert trouble is not None
    assert trouble.text == "M1 is silent"


def test_what_came_before_its_announcement_is_bounded(projection: Projection) -> None:
    for number in range(2 * EARLY_KEPT):
        tell(projection, f"ATV{number}", refused())
    tell(projection, "M1", opened())
    assert len(task(projection).refusals) <= MAX_BIDS
    assert task(projection).refusals[-1].agent == f"ATV{2 * EARLY_KEPT - 1}"


def test_a_new_epoch_forgets_the_carrier_and_its_promise(projection: Projection) -> None:
    tell(projection, "M1", opened(), bid("ATV2"), answer("ATV2"))
    tell(projection, "ATV2", phase(Phase.CARRYING))
    tell(projection, "M1", opened(epoch=2))
    view = task(projection)
    assert (view.state, view.epoch, view.primary, view.phase, view.source) == ("bidding", 2, "", "", "")
    assert (view.contracted_at_s, view.promised_at_s) == (None, None)


def test_what_tells_of_an_older_epoch_is_ignored(projection: Projection) -> None:
    tell(projection, "M1", opened(epoch=2), bid("ATV1", epoch=2), answer("ATV1", epoch=2))
    delta(projection)
    lost = WatchLost(task="T1", epoch=1, secondary="", reason=Reason.SILENT)
    failed = RoundFailed(task="T1", epoch=1, role=Role.PRIMARY, round=9, bids=0, next_round_s=1.0)
    tell(projection, "M1", opened(), bid("ATV2"), award("ATV1"), answer("ATV2"), lost, failed)
    tell(projection, "ATV2", phase(Phase.RETURNING), refused())
    assert (task(projection).primary, len(task(projection).bids), task(projection).round) == ("ATV1", 1, 1)
    assert not projection.changed


def test_a_secondary_that_takes_over_is_the_carrier(projection: Projection) -> None:
    tell(projection, "M1", opened(), answer("ATV2"), answer("ATV1", role=Role.SECONDARY))
    taken = ContractTaken(task="T1", epoch=2, role=Role.PRIMARY, coordinator="M1")
    tell(projection, "ATV1", taken)
    view = task(projection)
    assert (view.state, view.epoch, view.primary, view.secondary) == ("contracted", 2, "ATV1", "")
    tell(projection, "ATV2", phase(Phase.CARRYING))
    assert task(projection).primary == "ATV1"


def test_facts_that_tell_of_nothing_shown_and_other_messages_are_counted_and_ignored(
    projection: Projection,
) -> None:
    tell(projection, "M1", PieceMade(goal="G9", product="P1", made=1), closed("T9"))
    projection.fold(OrderTaken(order="O-1"))
    assert (projection.heard, projection.ignored, projection.changed) == (0, 3, False)


# --- figures of transports --------------------------------------------------------------------------


def test_transports_are_measured_from_the_announcement_to_the_handover(projection: Projection) -> None:
    for number in range(1, 21):
        tell(projection, "M1", opened(f"T{number}"), at_s=100.0)
        tell(projection, "M1", closed(f"T{number}"), at_s=100.0 + number)
    tell(projection, "M1", opened("T-withdrawn"), at_s=100.0)
    tell(projection, "M1", closed("T-withdrawn", outcome="withdrawn"), at_s=900.0)
    factory = projection.factory(wall_s(130.0))
    assert (factory.transport_p50_s, factory.transport_p95_s) == (10.0, 19.0)
    assert factory.deliveries_per_hour == (0.0,) * 11 + (240.0,)
    assert projection.factory(wall_s(2 * 3600.0)).deliveries_per_hour == (0.0,) * 12

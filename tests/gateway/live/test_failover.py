"""What panels see when a vehicle fails: carriers that change, help, and the news of it."""

from __future__ import annotations

import pytest
from facts_kit import tell, wall_s
from failover_kit import accepted, hired, opened, the_news
from heartbeats import atv_heartbeat, machine_heartbeat
from wall_clock import NOW_S

from dray.gateway.live.projection import Projection
from dray.gateway.live.projection.auctions.tasks import MAX_CARRIERS
from dray.gateway.live.projection.news import NEWS_KEPT
from dray.gateway.live.views import CauseView, TaskView
from dray.messages import HelpWanted, Link, Phase, Reason, Role, TaskBrief
from dray.messages.fact import (
    CarrierChanged,
    ContractEnded,
    ContractTaken,
    HelpAsked,
    HelpPromised,
    LinkChanged,
    PhaseEntered,
    TaskClosed,
    TookOver,
)


@pytest.fixture
def projection() -> Projection:
    return hired()


def took_over(epoch: int = 2, primary: str = "ATV3") -> TookOver:
    return TookOver(task="T1", epoch=epoch, primary=primary, silent_s=3.6, reason=Reason.SILENT)


def changed(carrier: str, epoch: int = 2, replaced: str = "ATV3") -> CarrierChanged:
    return CarrierChanged(
        task="T1", epoch=epoch, replaced=replaced, carrier=carrier, reason=Reason.SILENT, silent_s=3.9
    )


def phase(step: Phase, epoch: int) -> PhaseEntered:
    return PhaseEntered(task="T1", epoch=epoch, phase=step)


def ended(epoch: int, reason: str) -> ContractEnded:
    return ContractEnded(task="T1", epoch=epoch, role=Role.PRIMARY, reason=reason)


def task(projection: Projection) -> TaskView:
    view = projection.tasks.view("T1")
    assert view is not None
    return view


def carriers(projection: Projection) -> list[tuple[str, int, bool]]:
    return [(line.carrier, line.epoch, line.confirmed) for line in task(projection).carriers]


# --- takeover ---------------------------------------------------------------------------------------


def test_the_first_carrier_is_the_one_that_won(projection: Projection) -> None:
    assert carriers(projection) == [("ATV3", 1, True)]
    assert task(projection).carriers[0].since_at_s == wall_s(102.0)


def test_a_takeover_is_seen_before_the_coordinator_confirms_it(projection: Projection) -> None:
    tell(projection, "ATV1", took_over(), at_s=110.0)
    view = task(projection)
    assert (view.state, view.epoch, view.primary, view.secondary) == ("contracted", 2, "ATV1", "")
    assert carriers(projection) == [("ATV3", 1, True), ("ATV1", 2, False)]
    line = view.carriers[-1]
    assert (line.replaced, line.silent_s, line.since_at_s) == ("ATV3", 3.6, wall_s(111.0))
    news = the_news(projection)
    assert (news.kind, news.agent, news.other, news.task) == ("took_over", "ATV1", "ATV3", "T1")
    assert (news.silent_s, news.epoch, news.confirmed) == (3.6, 2, False)


@pytest.mark.parametrize("coordinator_first", [True, False])
def test_a_takeover_is_one_piece_of_news_whoever_tells_it_first(
    projection: Projection, coordinator_first: bool
) -> None:
    told = [("ATV1", took_over()), ("M8", changed("ATV1"))]
    for agent, fact in reversed(told) if coordinator_first else told:
        tell(projection, agent, fact)
    assert carriers(projection) == [("ATV3", 1, True), ("ATV1", 2, True)]
    news = the_news(projection)
    assert (news.agent, news.other, news.confirmed) == ("ATV1", "ATV3", True)


def test_the_promise_of_the_one_that_failed_binds_nobody(projection: Projection) -> None:
    task(projection).promised_at_s = wall_s(150.0)
    tell(projection, "ATV1", took_over())
    assert task(projection).promised_at_s is None


def test_a_takeover_that_comes_again_tells_nothing_new(projection: Projection) -> None:
    for _ in range(2):
        tell(projection, "ATV1", took_over())
        tell(projection, "M8", changed("ATV1"))
        projection.discard_changes()
    tell(projection, "ATV1", took_over())
    assert carriers(projection) == [("ATV3", 1, True), ("ATV1", 2, True)]
    assert not projection.news.changes


def test_what_the_replaced_one_still_says_does_not_give_it_the_task_back(projection: Projection) -> None:
    tell(projection, "ATV1", took_over())
    tell(projection, "ATV3", phase(Phase.CARRYING, 1), ended(1, "superseded"))
    assert task(projection).primary == "ATV1"
    assert the_news(projection).kind == "took_over"


@pytest.mark.parametrize("reason", ["released", "superseded"])
def test_a_takeover_that_the_coordinator_refuses_leaves_the_carrier(
    projection: Projection, reason: str
) -> None:
    contract = ContractTaken(task="T1", epoch=2, role=Role.PRIMARY, coordinator="M8")
    tell(projection, "ATV1", contract, took_over(), ended(2, reason))
    view = task(projection)
    assert (view.state, view.epoch, view.primary) == ("contracted", 1, "ATV3")
    assert carriers(projection) == [("ATV3", 1, True)]
    news = the_news(projection)
    assert (news.kind, news.reason, news.other) == ("takeover_refused", reason, "ATV3")
    tell(projection, "ATV3", phase(Phase.CARRYING, 1))
    assert task(projection).phase == "carrying"


def test_a_takeover_that_was_carried_to_its_end_was_not_refused(projection: Projection) -> None:
    tell(projection, "ATV1", took_over(), ended(2, "handed_over"))
    assert task(projection).primary == "ATV1"
    assert the_news(projection).kind == "took_over"


def test_a_task_without_a_living_secondary_is_announced_anew(projection: Projection) -> None:
    tell(projection, "M8", changed(""), opened(2))
    view = task(projection)
    assert (view.state, view.epoch, view.round, view.primary) == ("bidding", 2, 1, "")
    assert carriers(projection) == [("ATV3", 1, True), ("", 2, True)]
    news = the_news(projection)
    assert (news.kind, news.agent, news.other) == ("announced_anew", "M8", "ATV3")
    tell(projection, "M8", accepted("ATV5", 2))
    assert carriers(projection) == [("ATV3", 1, True), ("ATV5", 2, True)]


def test_the_coordinator_counts_for_more_than_one_that_takes_over_too_late(projection: Projection) -> None:
    tell(projection, "M8", changed(""), opened(2))
    tell(projection, "ATV1", took_over())
    assert (task(projection).state, task(projection).primary) == ("bidding", "")
    assert the_news(projection).kind == "announced_anew"


def test_carriers_are_bounded_and_the_newest_stay(projection: Projection) -> None:
    for epoch in range(2, 2 * MAX_CARRIERS):
        tell(projection, "M8", changed(f"ATV{epoch}", epoch))
    assert len(task(projection).carriers) == MAX_CARRIERS
    assert task(projection).carriers[-1].epoch == 2 * MAX_CARRIERS - 1


# --- trouble and help -------------------------------------------------------------------------------


def test_a_machine_says_why_a_task_does_not_go_on_and_when_it_does(projection: Projection) -> None:
    for seq, trouble in enumerate((Reason.SILENT, None), 1):
        brief = TaskBrief(
            task="T1",
            epoch=1,
            item="steel",
            quantity=8,
            source="S1",
            destination="M8",
            deadline_s=400.0,
            trouble=trouble,
        )
        projection.fold(machine_heartbeat("M8", seq=seq, tasks=(brief,)))
        assert (task(projection).trouble and task(projection).trouble.reason) == trouble
        machine = projection.machines.view("M8")
        assert machine is not None
        assert (machine.tasks[0].trouble and machine.tasks[0].trouble.reason) == trouble


def test_a_task_that_ended_has_no_trouble(projection: Projection) -> None:
    task(projection).trouble = CauseView(reason="silent")
    tell(projection, "M8", TaskClosed(task="T1", epoch=1, outcome="delivered", carrier="ATV3"))
    assert task(projection).trouble is None


def test_a_vehicle_shows_how_long_it_waits_for_help_and_who_comes(projection: Projection) -> None:
    wanted = HelpWanted(until_s=160.0, promised_by="Hall 1")
    projection.fold(atv_heartbeat("ATV3", problem="the load has shifted", help=wanted))
    view = projection.atvs.view("ATV3")
    assert view is not None
    assert view.help is not None
    assert (view.help.until_at_s, view.help.promised_by) == (wall_s(160.0), "Hall 1")


def test_a_promise_takes_the_place_of_the_wish_for_help(projection: Projection) -> None:
    tell(projection, "ATV3", HelpAsked(task="T1", reason="blocked", until_s=160.0))
    asked = the_news(projection)
    assert (asked.kind, asked.until_at_s) == ("help_asked", wall_s(160.0))
    assert asked.cause is not None
    assert asked.cause.detail == "blocked"
    tell(projection, "ATV3", HelpPromised(until_s=200.0, promised_by="Hall 1"), at_s=105.0, first=2)
    promised = the_news(projection)
    assert (promised.kind, promised.other, promised.until_at_s) == ("help_promised", "Hall 1", wall_s(200.0))


# --- news -------------------------------------------------------------------------------------------


def test_of_a_link_only_the_newest_is_kept_and_it_is_the_newest_news(projection: Projection) -> None:
    tell(projection, "ATV2", LinkChanged(link=Link.MESH))
    tell(projection, "ATV4", LinkChanged(link=Link.MESH))
    tell(projection, "ATV2", LinkChanged(link=Link.WLAN), at_s=120.0, first=2)
    news = projection.news.views()
    assert [(line.agent, line.kind) for line in news] == [("ATV4", "link_lost"), ("ATV2", "link_back")]


def test_news_that_come_late_stand_at_their_time(projection: Projection) -> None:
    tell(projection, "ATV4", LinkChanged(link=Link.WLAN), at_s=120.0)
    tell(projection, "ATV2", LinkChanged(link=Link.MESH), at_s=110.0)
    assert [line.agent for line in projection.news.views()] == ["ATV2", "ATV4"]


def test_news_that_come_late_change_nothing(projection: Projection) -> None:
    tell(projection, "ATV2", LinkChanged(link=Link.WLAN), at_s=120.0, first=2)
    projection.discard_changes()
    tell(projection, "ATV2", LinkChanged(link=Link.MESH))
    assert the_news(projection).kind == "link_back"
    assert not projection.news.changes


def test_news_are_bounded_and_those_that_leave_are_said_to_be_gone(projection: Projection) -> None:
    for number in range(NEWS_KEPT + 2):
        tell(projection, f"ATV{number}", LinkChanged(link=Link.MESH))
    assert len(projection.news.views()) == NEWS_KEPT
    told = projection.delta(1, NOW_S, None)
    assert [line.agent for line in told.news] == [f"ATV{n}" for n in range(2, NEWS_KEPT + 2)]
    assert [name for name in told.gone if name.startswith("news:")] == ["news:link-ATV0", "news:link-ATV1"]


def test_a_new_panel_gets_the_news_too(projection: Projection) -> None:
    tell(projection, "ATV1", took_over())
    snapshot = projection.snapshot(1, NOW_S)
    assert [line.kind for line in snapshot.news] == ["took_over"]

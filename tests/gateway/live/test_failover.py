"""What panels see when something fails: carriers that change, help, lost goals, and the news of it."""

from __future__ import annotations

import pytest
from gateway_kit import NOW_S, PLANT, PRODUCT, atv_heartbeat, events, machine_heartbeat

from dray.gateway.live.projection import Projection
from dray.gateway.live.projection.auctions.carriers import MAX_CARRIERS
from dray.gateway.live.projection.news import NEWS_KEPT
from dray.gateway.live.timescale import TimeScale
from dray.gateway.live.views import NewsView, OrderView, TaskView
from dray.messages import HelpWanted, Link, Phase, Production, Role, TaskBrief, Transport
from dray.messages.fact import (
    AnyFact,
    AwardAnswered,
    CarrierChanged,
    ContractEnded,
    ContractTaken,
    GoalContracted,
    GoalLost,
    GoalWaits,
    GoodsDelivered,
    HelpAsked,
    HelpPromised,
    LinkChanged,
    MemoryLost,
    OrderAccepted,
    PhaseEntered,
    PieceMade,
    TaskClosed,
    TaskOpened,
    TookOver,
)
from dray.store.orders.orders import Item, Order
from dray.store.orders.progress import OrderStatus

SPEED = 10.0
"""Plant seconds per wall second, so that a time that was not turned is seen."""

FETCH = Transport(item="steel", quantity=8, sources=("S1",), destination="M8", ability="tote", goal="G1")


@pytest.fixture
def projection() -> Projection:
    """A gateway that has seen M8 hire ATV3, and ATV1 as its watch."""
    projection = Projection(PLANT, TimeScale(0.0, NOW_S, SPEED))
    tell(projection, "M8", opened(1), accepted("ATV3", 1), accepted("ATV1", 1, Role.SECONDARY))
    return projection


def wall_s(plant_s: float) -> float:
    return NOW_S + plant_s / SPEED


def tell(projection: Projection, agent: str, *facts: AnyFact, at_s: float = 100.0, first: int = 1) -> None:
    for event in events(agent, *facts, at_s=at_s, first=first):
        projection.fold(event)


def opened(epoch: int, round: int = 1) -> TaskOpened:  # noqa: A002 - the fact's own word
    return TaskOpened(
        task="T1",
        epoch=epoch,
        role=Role.PRIMARY,
        round=round,
        work=FETCH,
        radius_m=15.0,
        deadline_s=400.0,
        bids_until_s=101.0,
    )


def accepted(atv: str, epoch: int, role: Role = Role.PRIMARY) -> AwardAnswered:
    return AwardAnswered(task="T1", epoch=epoch, role=role, bidder=atv, answer="accepted")


def took_over(epoch: int = 2, primary: str = "ATV3") -> TookOver:
    return TookOver(task="T1", epoch=epoch, primary=primary, silent_s=3.6, reason="silent")


def changed(carrier: str, epoch: int = 2, replaced: str = "ATV3") -> CarrierChanged:
    return CarrierChanged(
        task="T1", epoch=epoch, replaced=replaced, carrier=carrier, reason="silent", silent_s=3.9
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


def the_news(projection: Projection) -> NewsView:
    (news,) = projection.news.views()
    return news


# --- takeover ------------------------------------------------------------------------------------


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


# --- trouble and help ----------------------------------------------------------------------------


def test_a_machine_says_why_a_task_does_not_go_on_and_when_it_does(projection: Projection) -> None:
    for seq, trouble in enumerate(("ATV3 is silent", ""), 1):
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
        assert task(projection).trouble == trouble
        machine = projection.machines.view("M8")
        assert machine is not None
        assert machine.tasks[0].trouble == trouble


def test_a_task_that_ended_has_no_trouble(projection: Projection) -> None:
    task(projection).trouble = "ATV3 is silent"
    tell(projection, "M8", TaskClosed(task="T1", epoch=1, outcome="delivered", carrier="ATV3"))
    assert task(projection).trouble == ""


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
    assert (asked.kind, asked.reason, asked.until_at_s) == ("help_asked", "blocked", wall_s(160.0))
    tell(projection, "ATV3", HelpPromised(until_s=200.0, promised_by="Hall 1"), at_s=105.0, first=2)
    promised = the_news(projection)
    assert (promised.kind, promised.other, promised.until_at_s) == ("help_promised", "Hall 1", wall_s(200.0))


# --- news ----------------------------------------------------------------------------------------


def test_of_a_link_only_the_newest_is_kept_and_it_is_the_newest_news(projection: Projection) -> None:
    tell(projection, "ATV2", LinkChanged(link=Link.MESH))
    tell(projection, "ATV4", LinkChanged(link=Link.MESH))
    tell(projection, "ATV2", LinkChanged(link=Link.WLAN), at_s=120.0, first=2)
    news = projection.news.views()
    assert [(line.agent, line.kind) for line in news] == [("ATV4", "link_lost"), ("ATV2", "link_back")]


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


# --- goals and their orders ----------------------------------------------------------------------


def contracted(goal: str, machine: str, quantity: int = 6) -> GoalContracted:
    return GoalContracted(
        goal=goal, order="O-1", item=0, product=PRODUCT, quantity=quantity, machine=machine, finish_s=300.0
    )


def delivered(goal: str, count: int) -> GoodsDelivered:
    return GoodsDelivered(goal=goal, order="O-1", item=0, product=PRODUCT, quantity=count, delivered=count)


@pytest.fixture
def ordered(projection: Projection) -> Projection:
    """Six pieces are ordered, and M8 makes them."""
    order = Order(
        id="O-1",
        customer="Hall 3",
        status=OrderStatus.RELEASED,
        releases=1,
        items=(Item(PRODUCT, 6),),
        token="t",
        created_at_s=NOW_S,
    )
    projection.orders.put(order)
    tell(projection, "strategist", OrderAccepted(order="O-1", goals=("G1",)), contracted("G1", "M8"))
    return projection


def order_of(projection: Projection) -> OrderView:
    (order,) = projection.orders.views()
    return order


def lose(projection: Projection, arrived: int, successor: str = "G2") -> None:
    fact = GoalLost(goal="G1", machine="M8", arrived=arrived, successor=successor)
    tell(projection, "strategist", fact, first=3)


def test_an_agent_that_began_without_its_memory_is_news(ordered: Projection) -> None:
    tell(ordered, "strategist", MemoryLost(reason="it is damaged"), first=7)
    news = the_news(ordered)
    assert (news.kind, news.agent, news.reason) == ("memory_lost", "strategist", "it is damaged")


def test_what_a_dead_machine_had_made_counts_only_where_it_arrived(ordered: Projection) -> None:
    tell(ordered, "M8", PieceMade(goal="G1", product=PRODUCT, made=5), delivered("G1", 2))
    assert (order_of(ordered).items[0].made, order_of(ordered).items[0].delivered) == (5, 2)
    lose(ordered, arrived=3)
    assert (order_of(ordered).items[0].made, order_of(ordered).items[0].delivered) == (3, 3)
    news = the_news(ordered)
    assert (news.kind, news.agent, news.goal, news.arrived) == ("goal_lost", "M8", "G1", 3)


def test_the_rest_is_counted_once_under_its_new_name(ordered: Projection) -> None:
    lose(ordered, arrived=2)
    tell(ordered, "strategist", contracted("G2", "M9", 4), first=4)
    tell(ordered, "M9", PieceMade(goal="G2", product=PRODUCT, made=4), delivered("G2", 4))
    # The dead one is back, and tells what it had made.
    tell(ordered, "M8", PieceMade(goal="G1", product=PRODUCT, made=6))
    order = order_of(ordered)
    assert (order.items[0].made, order.items[0].delivered, order.status) == (6, 6, "delivered")


def test_a_contract_that_comes_after_its_loss_does_not_bring_the_machine_back(ordered: Projection) -> None:
    lose(ordered, arrived=0)
    tell(ordered, "strategist", contracted("G1", "M8"), first=2)
    tell(ordered, "M8", PieceMade(goal="G1", product=PRODUCT, made=5))
    assert order_of(ordered).items[0].made == 0


def test_an_order_says_why_it_waits_until_somebody_has_taken_its_goal(ordered: Projection) -> None:
    lose(ordered, arrived=0)
    tell(ordered, "strategist", GoalWaits(goal="G2", order="O-1", reason="no machine can make it"), first=4)
    assert order_of(ordered).waits == "no machine can make it"
    ordered.discard_changes()
    tell(ordered, "strategist", contracted("G2", "M9"), first=5)
    assert order_of(ordered).waits == ""
    assert [order.waits for order in ordered.delta(1, NOW_S, None).orders] == [""]


def test_an_order_that_waits_for_many_goals_is_one_piece_of_news(ordered: Projection) -> None:
    for number, goal in enumerate(("G2", "G3"), 4):
        wait = GoalWaits(goal=goal, order="O-1", reason=f"nobody for {goal}")
        tell(ordered, "strategist", wait, first=number)
    news = the_news(ordered)
    assert (news.kind, news.order, news.reason) == ("goal_waits", "O-1", "nobody for G3")
    tell(ordered, "strategist", contracted("G2", "M9"), first=6)
    assert order_of(ordered).waits == "nobody for G3"


def test_a_wait_that_is_told_after_its_end_is_over(ordered: Projection) -> None:
    tell(ordered, "strategist", contracted("G2", "M9"), first=5)
    tell(ordered, "strategist", GoalWaits(goal="G2", order="O-1", reason="nobody"), first=4)
    assert order_of(ordered).waits == ""


def test_a_goal_that_nobody_can_make_is_a_task_in_trouble(projection: Projection) -> None:
    work = Production(product=PRODUCT, quantity=4, order="O-1", item=0)
    goal = TaskOpened(
        task="G2",
        epoch=1,
        role=Role.PRIMARY,
        round=1,
        work=work,
        radius_m=1.0,
        deadline_s=400.0,
        bids_until_s=101.0,
    )
    tell(projection, "strategist", goal, GoalWaits(goal="G2", order="O-1", reason="nobody"))
    view = projection.tasks.view("G2")
    assert view is not None
    assert view.trouble == "nobody"
    answer = AwardAnswered(task="G2", epoch=1, role=Role.PRIMARY, bidder="M9", answer="accepted")
    tell(projection, "strategist", answer, first=3)
    assert view.trouble == ""

"""What panels see when a machine fails: its goals, and the orders that they are for."""

from __future__ import annotations

import pytest
from facts_kit import tell
from failover_kit import contracted, delivered, hired, the_news
from gateway_kit import PRODUCT
from makings import making
from wall_clock import NOW_S

from dray.gateway.live.projection import Projection
from dray.gateway.live.views import OrderView
from dray.messages import Reason, Role
from dray.messages.fact import (
    AwardAnswered,
    GoalLost,
    GoalWaits,
    MachineFailure,
    MemoryLost,
    OrderAccepted,
    PieceMade,
    TaskOpened,
)
from dray.store.orders.orders import Item, Order
from dray.store.orders.progress import OrderStatus


@pytest.fixture
def projection() -> Projection:
    return hired()


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


def waits_of(projection: Projection) -> str:
    waits = order_of(projection).waits
    assert waits is not None
    return waits.text


def lose(projection: Projection, arrived: int, successor: str = "G2") -> None:
    fact = GoalLost(goal="G1", machine="M8", arrived=arrived, successor=successor)
    tell(projection, "strategist", fact, first=3)


def test_an_agent_that_began_without_its_memory_is_news(ordered: Projection) -> None:
    tell(ordered, "strategist", MemoryLost(reason="it is damaged"), first=7)
    news = the_news(ordered)
    assert (news.kind, news.agent) == ("memory_lost", "strategist")
    assert news.cause is not None
    assert news.cause.detail == "it is damaged"


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
    tell(
        ordered,
        "strategist",
        GoalWaits(goal="G2", order="O-1", machines=(MachineFailure("M9", Reason.BROKEN),)),
        first=4,
    )
    assert waits_of(ordered) == "M9 is broken"
    ordered.discard_changes()
    tell(ordered, "strategist", contracted("G2", "M9"), first=5)
    assert order_of(ordered).waits is None
    assert [order.waits for order in ordered.delta(1, NOW_S, None).orders] == [None]


def test_an_order_that_waits_for_many_goals_is_one_piece_of_news(ordered: Projection) -> None:
    for number, goal in enumerate(("G2", "G3"), 4):
        wait = GoalWaits(goal=goal, order="O-1", machines=(MachineFailure(f"M-{goal}", Reason.SILENT),))
        tell(ordered, "strategist", wait, first=number)
    news = the_news(ordered)
    assert (news.kind, news.order) == ("goal_waits", "O-1")
    assert news.cause is not None
    assert news.cause.text == "M-G3 is silent"
    tell(ordered, "strategist", contracted("G2", "M9"), first=6)
    assert waits_of(ordered) == "M-G3 is silent"


def test_a_wait_that_is_told_after_its_end_is_over(ordered: Projection) -> None:
    tell(ordered, "strategist", contracted("G2", "M9"), first=5)
    tell(ordered, "strategist", GoalWaits(goal="G2", order="O-1", machines=()), first=4)
    assert order_of(ordered).waits is None


def test_a_goal_that_nobody_can_make_is_a_task_in_trouble(projection: Projection) -> None:
    work = making(PRODUCT, 4, "O-1")
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
    tell(projection, "strategist", goal, GoalWaits(goal="G2", order="O-1", machines=()))
    view = projection.tasks.view("G2")
    assert view is not None
    assert view.trouble is not None
    answer = AwardAnswered(task="G2", epoch=1, role=Role.PRIMARY, bidder="M9", answer="accepted")
    tell(projection, "strategist", answer, first=3)
    assert view.trouble is None

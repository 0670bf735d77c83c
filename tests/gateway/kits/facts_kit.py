"""Facts and a projection that hears of them, for tests."""

from __future__ import annotations

from typing import Any, cast

from heartbeats import events
from wall_clock import NOW_S

from dray.gateway.live.frames import Delta
from dray.gateway.live.projection import Projection
from dray.gateway.live.views import TaskView
from dray.messages import Phase, Refusal, Role, Transport, TransportCost
from dray.messages.fact import (
    Answer,
    AnyFact,
    AwardAnswered,
    AwardGiven,
    BidReceived,
    BidRefused,
    GoalContracted,
    GoodsDelivered,
    PhaseEntered,
    PieceMade,
    TaskClosed,
    TaskOpened,
)
from dray.store.orders.orders import Item, Order
from dray.store.orders.progress import OrderStatus

SPEED = 10.0
"""Plant seconds per wall second, so that a time that was not turned is seen."""


def wall_s(plant_s: float) -> float:
    return NOW_S + plant_s / SPEED


def tell(projection: Projection, agent: str, *facts: AnyFact, at_s: float = 100.0, first: int = 1) -> None:
    for event in events(agent, *facts, at_s=at_s, first=first):
        projection.fold(event)


def delta(projection: Projection) -> Delta:
    return projection.delta(1, NOW_S, None)


FETCH = Transport(item="steel", quantity=8, sources=("S1", "S2"), destination="M1", ability="tote", goal="G1")


def opened(task: str = "T1", epoch: int = 1, round: int = 1, **fields: Any) -> TaskOpened:  # noqa: A002 - the fact's own word
    usual: dict[str, Any] = {
        "role": Role.PRIMARY,
        "work": FETCH,
        "radius_m": 15.0 * round,
        "deadline_s": 400.0,
        "bids_until_s": 101.0,
    }
    return TaskOpened(task=task, epoch=epoch, round=round, **usual | fields)


def bid(bidder: str, total_s: float = 40.0, epoch: int = 1, **fields: Any) -> BidReceived:
    usual: dict[str, Any] = {
        "task": "T1",
        "role": Role.PRIMARY,
        "round": 1,
        "cost": TransportCost(empty_way_s=total_s - 6.0, loaded_way_s=3.0, energy_s=2.0, suitability_s=1.0),
        "finish_s": 200.0 + total_s,
        "source": "S2",
    }
    return BidReceived(bidder=bidder, total_s=total_s, epoch=epoch, **usual | fields)


def award(bidder: str, epoch: int = 1, role: Role = Role.PRIMARY) -> AwardGiven:
    return AwardGiven(task="T1", epoch=epoch, role=role, bidder=bidder, rank=1)


def answer(bidder: str, word: str = "accepted", epoch: int = 1, role: Role = Role.PRIMARY) -> AwardAnswered:
    if word in ("accepted", "silent"):
        return AwardAnswered("T1", epoch, role, bidder, cast(Answer, word))
    return AwardAnswered("T1", epoch, role, bidder, "declined", Refusal(word))


def refused(reason: Refusal = Refusal.BATTERY, epoch: int = 1, detail: str = "") -> BidRefused:
    return BidRefused(task="T1", epoch=epoch, role=Role.PRIMARY, reason=reason, detail=detail)


def phase(step: Phase, epoch: int = 1) -> PhaseEntered:
    return PhaseEntered(task="T1", epoch=epoch, phase=step, station="S2")


def closed(task: str = "T1", epoch: int = 1, outcome: str = "delivered", **fields: Any) -> TaskClosed:
    return TaskClosed(task=task, epoch=epoch, outcome=outcome, **{"carrier": "ATV2"} | fields)


def task(projection: Projection, name: str = "T1") -> TaskView:
    view = projection.tasks.view(name)
    assert view is not None
    return view


def order(name: str = "O-1", *quantities: int, **fields: Any) -> Order:
    usual: dict[str, Any] = {
        "status": OrderStatus.RELEASED,
        "releases": 1,
        "customer": "Customer",
        "token": f"token-{name}",
        "created_at_s": NOW_S,
    }
    items = tuple(Item(f"P{index}", quantity) for index, quantity in enumerate(quantities or (4,), 1))
    return Order(id=name, **{"items": items} | usual | fields)


def contracted(goal: str = "G1", item: int = 0, quantity: int = 4, of: str = "O-1") -> GoalContracted:
    return GoalContracted(
        goal=goal, order=of, item=item, product=f"P{item + 1}", quantity=quantity, machine="M1", finish_s=9.0
    )


def made(count: int, goal: str = "G1", item: int = 0) -> PieceMade:
    return PieceMade(goal=goal, product=f"P{item + 1}", made=count)


def arrived(count: int, goal: str = "G1", item: int = 0, of: str = "O-1") -> GoodsDelivered:
    return GoodsDelivered(goal=goal, order=of, item=item, product=f"P{item + 1}", quantity=2, delivered=count)


def seen(projection: Projection, name: str = "O-1") -> tuple[str, list[tuple[int, int]]]:
    """The status of an order, and per item what is made and delivered."""
    (view,) = [view for view in projection.orders.views() if view.id == name]
    return view.status, [(item.made, item.delivered) for item in view.items]

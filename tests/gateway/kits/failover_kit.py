"""A gateway that has seen M8 hire ATV3, and ATV1 as its watch, for tests."""

from __future__ import annotations

from facts_kit import SPEED, tell
from fake_bus import PLANT
from gateway_kit import PRODUCT
from wall_clock import NOW_S

from dray.gateway.live.projection import Projection
from dray.gateway.live.timescale import TimeScale
from dray.gateway.live.views import NewsView
from dray.messages import Role, Transport
from dray.messages.fact import AwardAnswered, GoalContracted, GoodsDelivered, TaskOpened

FETCH = Transport(item="steel", quantity=8, sources=("S1",), destination="M8", ability="tote", goal="G1")


def hired() -> Projection:
    """A gateway that has seen M8 hire ATV3, and ATV1 as its watch."""
    projection = Projection(PLANT, TimeScale(0.0, NOW_S, SPEED))
    tell(projection, "M8", opened(1), accepted("ATV3", 1), accepted("ATV1", 1, Role.SECONDARY))
    return projection


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


def the_news(projection: Projection) -> NewsView:
    (news,) = projection.news.views()
    return news


def contracted(goal: str, machine: str, quantity: int = 6) -> GoalContracted:
    return GoalContracted(
        goal=goal, order="O-1", item=0, product=PRODUCT, quantity=quantity, machine=machine, finish_s=300.0
    )


def delivered(goal: str, count: int) -> GoodsDelivered:
    return GoodsDelivered(goal=goal, order="O-1", item=0, product=PRODUCT, quantity=count, delivered=count)

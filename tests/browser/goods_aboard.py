"""M8, whose goods for an order ATV2 has on board and does not go on."""

from __future__ import annotations

from typing import Any

from gateway_kit import House
from msgspec import UNSET
from msgspec.structs import replace
from obedient_machine import STATION, ObedientMachine
from wall_clock import NOW_S

from dray.messages import (
    MachineCommandKind,
    Reason,
    Role,
    StrandedGoods,
    TaskBrief,
    Transport,
)
from dray.messages.fact import AwardAnswered, TaskOpened
from dray.store.orders.orders import Item, Order
from dray.store.orders.progress import Goal, OrderStatus

TASK, NODE = "M8-7", "d2"

REFERENCE = "PO 4711"

WORK = Transport(
    item="pump-p3",
    quantity=24,
    sources=(STATION,),
    destination="DELIVERY",
    ability="tote",
    goal="G8",
)


class MachineWithGoods(ObedientMachine):
    """M8; see `ObedientMachine`."""

    def __init__(self, house: House, at_s: float) -> None:
        order = Order(
            id="O-1",
            status=OrderStatus.RELEASED,
            customer="Hall 3",
            token="token",
            items=(Item(WORK.item, WORK.quantity),),
            created_at_s=NOW_S,
            reference=REFERENCE,
        )
        goal = Goal(id=WORK.goal, order_id=order.id, item=0, product=WORK.item, quantity=WORK.quantity)
        house.projection.orders.put(order, (goal,))
        told = (
            TaskOpened(TASK, 1, Role.PRIMARY, 1, WORK, 20.0, at_s + 900.0, 2.0),
            AwardAnswered(TASK, 1, Role.PRIMARY, "ATV2", "accepted"),
        )
        self._brief = TaskBrief(
            task=TASK,
            epoch=1,
            item=WORK.item,
            quantity=WORK.quantity,
            source=STATION,
            destination=WORK.destination,
            deadline_s=at_s + 300.0,
            primary="ATV2",
            trouble=Reason.SILENT,
            stranded=StrandedGoods(atv="ATV2", node="c2", until_s=at_s + 800.0),
        )
        super().__init__(house, at_s, *told)

    def state(self) -> dict[str, Any]:
        """The goods are on board, then at hand for another vehicle or written off."""
        brief = self._brief
        for command in self.heard:
            if command.kind is MachineCommandKind.FETCH_GOODS:
                goods = replace(brief.stranded, handed_at=NODE)
                brief = replace(brief, epoch=2, primary="ATV6", source=NODE, stranded=goods)
            else:
                brief = replace(brief, stranded=UNSET, trouble=None)
        return {"tasks": (brief,)}

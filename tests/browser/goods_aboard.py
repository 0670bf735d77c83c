"""M8, whose goods for an order ATV2 has on board and does not go on: it obeys, and says so."""

from __future__ import annotations

import sys
from pathlib import Path

from msgspec import UNSET
from msgspec.structs import replace

sys.path.insert(0, str(Path(__file__).parents[1] / "gateway/kits"))

from gateway_kit import House
from heartbeats import events, machine_heartbeat
from wall_clock import NOW_S

from dray.messages import (
    CommandAnswered,
    MachineCommand,
    MachineCommandKind,
    Message,
    Reason,
    Role,
    StrandedGoods,
    TaskBrief,
    Transport,
)
from dray.messages.fact import AwardAnswered, TaskOpened
from dray.store.orders.orders import Item, Order
from dray.store.orders.progress import Goal, OrderStatus

STATION, TASK, NODE = "M8", "M8-7", "d2"

REFERENCE = "PO 4711"

WORK = Transport(
    item="pump-p3",
    quantity=24,
    sources=(STATION,),
    destination="DELIVERY",
    ability="tote",
    goal="G8",
)


class MachineWithGoods:
    """M8.

    Args:
        house: where it joins.
        at_s: when that is (plant clock).
    """

    def __init__(self, house: House, at_s: float) -> None:
        self.heard: list[MachineCommand] = []
        self._house, self._seq, self._at_s = house, 10, at_s
        self._goods = StrandedGoods(atv="ATV2", node="c2", until_s=at_s + 800.0)
        house.bus.join(STATION, self.on_message)
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
        for each in events(STATION, *told, at_s=at_s):
            house.bus.say(each)
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
            stranded=self._goods,
        )
        self.beat()

    def beat(self) -> None:
        """Say how it is."""
        self._seq += 1
        said = machine_heartbeat(STATION, self._seq, at_s=self._at_s + self._seq, tasks=(self._brief,))
        self._house.bus.say(said)

    def on_message(self, sender: str, message: Message) -> None:
        """Obey, and say so."""
        if not isinstance(message, MachineCommand):
            return
        self.heard.append(message)
        self._house.bus.tell(STATION, sender, CommandAnswered(message.command, done=True))
        if message.kind is MachineCommandKind.FETCH_GOODS:
            goods = replace(self._goods, handed_at=NODE)
            self._brief = replace(self._brief, epoch=2, primary="ATV6", source=NODE, stranded=goods)
        else:
            self._brief = replace(self._brief, stranded=UNSET, trouble=None)
        self.beat()

"""Goods on board of failed vehicles: one alert each, until a person deals with them. Pure rules."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from dray.gateway.live.projection.alerting.alert_rules import Moment, in_vain
from dray.gateway.live.views import TaskView
from dray.gateway.live.views.alert import Condition, GoodsView
from dray.messages import HelpCall, OperatorHeartbeat
from dray.plant import Product


def of_goods(
    tasks: Iterable[TaskView],
    calls: Iterable[HelpCall],
    on_duty: Iterable[OperatorHeartbeat],
    products: Mapping[str, Product],
    now: Moment,
) -> Iterator[Condition]:
    """Goods that wait for a person: where, until when they are kept, and whether somebody comes.

    Args:
        tasks: open tasks.
        calls: open calls for help.
        on_duty: operators on duty.
        products: the plant's products, by id.
        now: the moment of the look.
    """
    left = [task for task in tasks if task.stranded is not None]
    if not left:
        return
    called = {call.goods: call for call in calls if call.goods}
    names = {each.operator: each.label or each.operator.partition(".")[2] for each in on_duty}
    for task in left:
        stranded, call = task.stranded, called.get(task.id)
        if stranded is None:
            continue
        yield Condition(
            kind="goods_stranded",
            agent=stranded.atv,
            task=task.id,
            order=stranded.order,
            call=None if call is None else in_vain(call),
            cause=task.trouble,
            goods=GoodsView(
                item=task.item,
                name=products[task.item].name if task.item in products else task.item,
                quantity=task.quantity,
                machine=task.coordinator,
                order_name=stranded.order_name,
                node=stranded.node,
                handed_at=stranded.handed_at,
            ),
            by="" if call is None else names.get(call.taken_by, ""),
            seen_at_s=None if call is None else now.to_wall_s(call.since_s),
            until_at_s=stranded.until_at_s,
        )

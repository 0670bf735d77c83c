"""Goods on board of a vehicle that has failed: the alert of each, and who may say what becomes of them."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest
from alerts_kit import alerts, the_alert
from answers import problem
from facts_kit import opened, tell, wall_s
from gateway_kit import House
from heartbeats import events, machine_heartbeat
from msgspec import UNSET
from obedient_places import obedient
from wall_clock import NOW_S

from dray.gateway.access.principal import Role as PersonRole
from dray.gateway.live.projection import Projection
from dray.gateway.live.visibility import AreaVisibility, FactoryVisibility
from dray.messages import (
    CallState,
    CommandRefusal,
    DutyStatus,
    HelpCall,
    MachineCommand,
    Message,
    OperatorHeartbeat,
    Reason,
    StrandedGoods,
    TaskBrief,
    Transport,
)
from dray.messages.fact import TaskClosed
from dray.plant import load_plant
from dray.store.access.audit import AuditRow
from dray.store.orders.orders import Item, Order
from dray.store.orders.progress import Goal, OrderStatus

pytestmark = pytest.mark.anyio

FLOOR = load_plant("single-track")

MACHINE = "M1"
ITS_AREA = min(FLOOR.areas_near(*FLOOR.position_of(MACHINE), 0.0))
TASK = f"{MACHINE}-7"

NODE, AREA = next(
    (node.id, areas[0])
    for node in FLOOR.nodes.values()
    if (areas := sorted(FLOOR.areas_near(node.x_m, node.y_m, 0.0))) and ITS_AREA not in areas
)
"""Where the goods are: in another area than their machine."""


def announced(projection: Projection, task: str = TASK) -> None:
    """The machine has its goods fetched, which are for order O-1."""
    order = Order(
        id="O-1",
        status=OrderStatus.RELEASED,
        customer="Hall 3",
        token="token",
        items=(Item("pump-p3", 24),),
        created_at_s=NOW_S,
        reference="PO 4711",
    )
    projection.orders.put(order, (Goal(id="O-1.1", order_id="O-1", item=0, product="pump-p3", quantity=24),))
    work = Transport(
        item="pump-p3", quantity=24, sources=(MACHINE,), destination="D1", ability="tote", goal="O-1.1"
    )
    tell(projection, MACHINE, opened(task, work=work), at_s=0.0)


def left_aboard(
    seq: int = 1, *, handed_at: str = "", waits: bool = True, tasks: tuple[str, ...] = (TASK,)
) -> Message:
    """The machine says that ATV2 has them on board, and is silent."""
    stranded = StrandedGoods(atv="ATV2", node=NODE, until_s=902.0, handed_at=handed_at)
    briefs = tuple(
        TaskBrief(
            task=task,
            epoch=1,
            item="pump-p3",
            quantity=24,
            source=MACHINE,
            destination="D1",
            deadline_s=400.0,
            primary="ATV2",
            trouble=Reason.SILENT if waits else None,
            stranded=stranded if waits else UNSET,
        )
        for task in tasks
    )
    return machine_heartbeat(MACHINE, seq, tasks=briefs)


def call(state: CallState, *, number: int = 1, on_duty: int = 0, taken_by: str = "") -> HelpCall:
    return HelpCall(
        call=f"{MACHINE}-1-1",
        caller=MACHINE,
        incarnation=1,
        number=number,
        at_s=1.0,
        state=state,
        since_s=1.0,
        on_duty=on_duty,
        taken_by=taken_by,
        goods=TASK,
    )


# --- the alert --------------------------------------------------------------------------------------


def test_the_alert_tells_which_goods_on_which_vehicle_for_which_order_and_until_when(
    projection: Projection,
) -> None:
    announced(projection)
    projection.fold(left_aboard())
    alert = the_alert(projection)
    assert (alert.kind, alert.agent, alert.task, alert.order) == ("goods_stranded", "ATV2", TASK, "O-1")
    assert (alert.level, alert.response) == ("warning", "see_to_goods")
    assert alert.until_at_s == wall_s(902.0)
    assert alert.cause is not None
    assert alert.cause.reason == "silent"
    goods = alert.goods
    assert goods is not None
    assert (goods.item, goods.name) == ("pump-p3", FLOOR.products["pump-p3"].name)
    assert (goods.quantity, goods.machine) == (24, MACHINE)
    assert (goods.node, goods.handed_at, goods.order_name) == (NODE, "", "PO 4711")


def test_each_goods_have_an_alert_of_their_own_also_of_one_order(projection: Projection) -> None:
    announced(projection)
    announced(projection, f"{MACHINE}-8")
    projection.fold(left_aboard(tasks=(TASK, f"{MACHINE}-8")))
    told = alerts(projection)
    assert [each.id for each in told] == [f"goods_stranded-{TASK}", f"goods_stranded-{MACHINE}-8"]


def test_it_tells_where_they_are_handed_over_and_goes_when_another_vehicle_has_them(
    projection: Projection,
) -> None:
    announced(projection)
    projection.fold(left_aboard())
    began = the_alert(projection)
    projection.fold(left_aboard(2, handed_at="c2"))
    handed = the_alert(projection)
    assert handed.goods is not None
    assert (handed.id, handed.goods.handed_at) == (began.id, "c2")
    projection.fold(left_aboard(3, waits=False))
    assert alerts(projection) == []


def test_it_goes_when_they_are_written_off(projection: Projection) -> None:
    announced(projection)
    projection.fold(left_aboard())
    assert the_alert(projection).kind == "goods_stranded"
    closed = TaskClosed(task=TASK, epoch=1, outcome="withdrawn", carrier="ATV2")
    for event in events(MACHINE, closed, first=2, at_s=2.0):
        projection.fold(event)
    assert alerts(projection) == []


@pytest.mark.parametrize(("on_duty", "vain"), [(0, "call_nobody"), (2, "call_unanswered")])
def test_that_nobody_comes_for_them_is_told_by_the_same_alert(
    projection: Projection, on_duty: int, vain: str
) -> None:
    announced(projection)
    projection.fold(left_aboard())
    projection.people.fold(call(CallState.RESTING, on_duty=on_duty), 2.0)
    alert = the_alert(projection)
    assert (alert.kind, alert.call, alert.level, alert.response) == (
        "goods_stranded",
        vain,
        "alarm",
        "send_somebody",
    )


def test_who_comes_for_them_is_told(projection: Projection) -> None:
    announced(projection)
    projection.fold(left_aboard())
    anna = OperatorHeartbeat(
        operator="operator.k3x7", incarnation=1, seq=1, at_s=1.0, status=DutyStatus.BUSY, label="Anna"
    )
    projection.people.fold(anna, 2.0)
    projection.people.fold(call(CallState.TAKEN, taken_by="operator.k3x7"), 2.0)
    assert the_alert(projection).by == "Anna"


def test_a_machines_own_call_in_vain_stays_an_alert_beside_that_of_its_goods(projection: Projection) -> None:
    announced(projection)
    projection.fold(left_aboard())
    projection.people.fold(call(CallState.ASKING), 2.0)
    own = HelpCall(
        call="M1-1-2",
        caller=MACHINE,
        incarnation=1,
        number=2,
        at_s=1.0,
        state=CallState.RESTING,
        since_s=1.0,
    )
    projection.people.fold(own, 2.0)
    assert {each.kind: each.call for each in alerts(projection)} == {
        "call_nobody": None,
        "goods_stranded": None,
    }


def test_who_may_not_read_orders_is_told_their_name_on_the_goods_and_nothing_else_of_them(
    projection: Projection,
) -> None:
    announced(projection)
    projection.fold(left_aboard())
    view = projection.tasks.view(TASK)
    assert view is not None
    assert view.stranded is not None
    assert (view.stranded.order, view.stranded.order_name) == ("O-1", "PO 4711")
    for seen in (
        FactoryVisibility(projection.site),
        AreaVisibility(projection, frozenset({ITS_AREA})),
    ):
        task, alert = seen.task(view), seen.alert(the_alert(projection))
        assert task is not None
        assert task.stranded is not None
        assert (task.order, task.stranded.order, task.stranded.order_name) == ("", "", "PO 4711")
        assert alert is not None
        assert alert.order == ""


# --- who may say what becomes of them ---------------------------------------------------------------


def machine_in(house: House, *, refusal: CommandRefusal | None = None) -> list[MachineCommand]:
    """The machine joins with goods left aboard; the commands that it will have heard."""
    announced(house.projection)
    house.projection.fold(left_aboard())
    return obedient(house, MACHINE, refusal=refusal)


def said_in(row: AuditRow) -> dict[str, Any]:
    """What a line of the audit log tells."""
    return (
        row.detail if isinstance(row.detail, dict) else msgspec.json.decode(row.detail, type=dict[str, Any])
    )


WORDS: list[dict[str, Any]] = [
    {"kind": "fetch_goods", "task": TASK, "node": NODE},
    {"kind": "write_off", "task": TASK},
]

words = pytest.mark.parametrize("word", WORDS, ids=lambda word: word["kind"])

PATH = f"/api/machines/{MACHINE}/commands"


@words
async def test_an_operator_of_the_area_where_they_are_may_say_it_for_that_area(
    house: House, word: dict[str, Any]
) -> None:
    heard = machine_in(house)
    anna = await house.log_in("anna", PersonRole.OPERATOR, AREA)
    answer = await anna.post(PATH, json=word)
    assert (answer.status_code, answer.json()["done"]) == (200, True)
    [command] = heard
    assert command.grant is not None
    assert (command.grant.areas, command.grant.everywhere) == ((AREA,), False)
    [row] = await house.audit(action="machine.command")
    assert (row.who, row.target, row.result) == ("anna", MACHINE, "done")
    assert (said_in(row)["kind"], said_in(row)["task"]) == (word["kind"], TASK)


@words
async def test_an_operator_of_their_machines_area_may_not_and_nothing_is_said(
    house: House, word: dict[str, Any]
) -> None:
    heard = machine_in(house)
    ben = await house.log_in("ben", PersonRole.OPERATOR, ITS_AREA)
    told = problem(await ben.post(PATH, json=word), 403, "not-allowed")
    assert told["detail"] == f"the goods of {TASK} are not in your areas ({ITS_AREA})"
    assert heard == []
    [row] = await house.audit(action="machine.command")
    assert (row.who, row.result) == ("ben", "refused")


@words
async def test_a_manager_may_say_it_wherever_they_are(house: House, word: dict[str, Any]) -> None:
    heard = machine_in(house)
    max_ = await house.log_in("max", PersonRole.MANAGER)
    answer = await max_.post(PATH, json=word)
    assert (answer.status_code, answer.json()["done"]) == (200, True)
    assert heard[0].grant is not None
    assert heard[0].grant.everywhere
    [row] = await house.audit(action="machine.command")
    assert (row.who, row.result) == ("max", "done")


@words
async def test_what_the_machine_refuses_is_told_with_its_reason_and_kept(
    house: House, word: dict[str, Any]
) -> None:
    machine_in(house, refusal=CommandRefusal.NOT_STRANDED)
    max_ = await house.log_in("max", PersonRole.MANAGER)
    said = (await max_.post(PATH, json=word)).json()
    assert (said["done"], said["reason"]) == (False, "not_stranded")
    [row] = await house.audit(action="machine.command")
    assert row.result == "refused"
    assert said_in(row)["reason"]


@words
async def test_goods_that_do_not_wait_are_their_machines_affair(house: House, word: dict[str, Any]) -> None:
    heard = machine_in(house)
    anna = await house.log_in("anna", PersonRole.OPERATOR, AREA)
    told = problem(await anna.post(PATH, json=word | {"task": f"{MACHINE}-9"}), 403, "not-allowed")
    assert told["detail"] == f"{MACHINE} is not in your areas ({AREA})"
    assert heard == []

"""What an order would need: counted from what the factory has told, and estimated as the factory works."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest
from answers import problem
from fake_bus import PLANT
from gateway_kit import PRODUCT, House, draft
from heartbeats import machine_heartbeat
from wall_clock import NOW_S

from dray.gateway.live.views import BufferView, GoalView, MachineView, OrderItemView, OrderView, SilenceView
from dray.gateway.orders.feasibility import OrderPreview, Situation, Wanted, preview
from dray.gateway.tracking.eta import History
from dray.messages import GoalBrief, MachineStatus

MAKERS = [spec for spec in PLANT.machines if any(making.product == PRODUCT for making in spec.makes)]
"""Machines of the default plant that make the product."""

GEAR = next(product for product in PLANT.products if product.id == PRODUCT)

CYCLE_S = {spec.id: next(m.cycle_s for m in spec.makes if m.product == PRODUCT) for spec in MAKERS}

ALL = GEAR.lot * len(MAKERS)
"""One container for each of them."""


def machine(
    name: str, *queue: int, status: Any = "idle", silent_s: float = 0.0, level: int = 0
) -> MachineView:
    """A machine with goals of so many pieces still to make."""
    return MachineView(
        id=name,
        name=name,
        status=status,
        goals=tuple(
            GoalView(
                goal=f"G-{name}-{i}", product=PRODUCT, quantity=left + 3, made=3, to_begin=left, delivered=0
            )
            for i, left in enumerate(queue)
        ),
        buffers=(BufferView(item=GEAR.bill[0].material, level=level, capacity=100),),
        seen_at_s=NOW_S - silent_s,
        silence=SilenceView(beat_s=1.0, overdue_after_s=1.5, lost_after_s=15.0),
    )


def order(quantity: int, made: int = 0, status: Any = "released") -> OrderView:
    items = (OrderItemView(product=PRODUCT, quantity=quantity, made=made),)
    return OrderView(id=f"O-{quantity}", customer="c", status=status, items=items, created_at_s=NOW_S)


def look(
    quantity: int,
    *machines: MachineView,
    orders: tuple[OrderView, ...] = (),
    due_s: float | None = None,
    speed: float = 1.0,
) -> OrderPreview:
    situation = Situation(
        machines={view.id: view for view in machines or [machine(spec.id) for spec in MAKERS]},
        orders=orders,
        history=History(tuple(float(each) for each in range(8))),
        now_s=NOW_S,
        heard_since_s=NOW_S - 60.0,
        speed=speed,
    )
    due_at_s = None if due_s is None else NOW_S + due_s
    return preview(PLANT, [Wanted(PRODUCT, quantity)], due_at_s, situation)


def shares(found: OrderPreview) -> dict[str, int]:
    return {offer.machine: offer.pieces for offer in found.machines}


def test_the_machines_that_can_make_it_share_it_in_whole_containers() -> None:
    assert shares(look(ALL)) == {spec.id: GEAR.lot for spec in MAKERS}
    assert sum(shares(look(ALL + 1)).values()) == ALL + 1


def test_a_part_goes_to_whoever_is_done_with_it_first() -> None:
    busy, *free = [spec.id for spec in MAKERS]
    found = look(GEAR.lot, machine(busy, 500), *(machine(each) for each in free))
    assert shares(found)[busy] == 0
    assert found.machines[0].queue_s == 500 * CYCLE_S[busy]


def test_what_is_ordered_and_nobody_has_taken_comes_first() -> None:
    empty, waiting = look(ALL), look(ALL, orders=(order(10 * ALL),))
    assert empty.earliest_at_s is not None
    assert waiting.earliest_at_s is not None
    # The longer a range, the coarser are its ends.
    assert waiting.earliest_at_s > empty.earliest_at_s + 9 * GEAR.lot * min(CYCLE_S.values())


def test_orders_whose_pieces_are_in_machines_queues_are_not_counted_twice() -> None:
    queues = tuple(machine(spec.id, 10 * GEAR.lot) for spec in MAKERS)
    made = 3 * len(MAKERS)
    assert look(ALL, *queues, orders=(order(10 * ALL + made, made=made),)) == msgspec.structs.replace(
        look(ALL, *queues), materials=look(ALL, *queues, orders=(order(10 * ALL),)).materials
    )


def test_what_is_stored_or_has_ended_is_no_demand() -> None:
    idle = tuple(order(500, status=status) for status in ("stored", "delivered", "cancelled"))
    assert look(ALL, orders=idle) == look(ALL)


@pytest.mark.parametrize("fault", [{"status": "error"}, {"silent_s": 61.0}])
def test_a_machine_in_error_or_silent_makes_nothing(fault: dict[str, Any]) -> None:
    lost, *others = [spec.id for spec in MAKERS]
    found = look(ALL, machine(lost, **fault), *(machine(each) for each in others))
    assert shares(found)[lost] == 0
    assert sum(shares(found).values()) == ALL
    assert [offer.available for offer in found.machines] == [False] + [True] * len(others)
    nobody = look(ALL, *(machine(spec.id, **fault) for spec in MAKERS))
    assert (nobody.cannot, nobody.earliest_at_s, nobody.latest_at_s) == ((PRODUCT,), None, None)


def test_the_estimate_is_in_the_time_of_the_wall() -> None:
    slow, fast = look(ALL), look(ALL, speed=50.0)
    assert slow.earliest_at_s is not None
    assert fast.earliest_at_s is not None
    assert fast.earliest_at_s - NOW_S < (slow.earliest_at_s - NOW_S) / 10


def test_an_order_that_cannot_be_there_in_time_is_said_to_be_late() -> None:
    found = look(ALL)
    assert found.earliest_at_s is not None
    assert found.latest_at_s is not None
    early, late = found.earliest_at_s - NOW_S, found.latest_at_s - NOW_S
    assert [look(ALL, due_s=due_s).late for due_s in (early - 1.0, (early + late) / 2, late)] == [
        "yes",
        "maybe",
        "",
    ]


def test_material_is_counted_against_buffers_storages_and_other_orders() -> None:
    line = GEAR.bill[0]
    found = look(
        10,
        *(machine(spec.id, level=7) for spec in MAKERS),
        orders=(order(20, made=5),),
    )
    need = next(each for each in found.materials if each.material == line.material)
    lot = next(material.lot for material in PLANT.materials if material.id == line.material)
    assert (need.needed, need.wanted) == (10 * line.quantity, 15 * line.quantity)
    assert (need.loads, need.at_machines) == (-(-need.needed // lot), 7 * len(MAKERS))
    assert {share.storage for share in need.storages} == {
        storage.id
        for storage in PLANT.storages
        if any(stock.material == line.material for stock in storage.stocks)
    }
    assert not need.refills
    held = sum(share.capacity for share in need.storages) + need.at_machines
    assert (
        look(held // line.quantity + 1, *(machine(spec.id, level=7) for spec in MAKERS)).materials[0].refills
    )


# --- over REST -----------------------------------------------------------------------------------


@pytest.mark.anyio
async def test_a_preview_is_told_from_what_the_factory_says_and_keeps_nothing(house: House) -> None:
    goals = (GoalBrief(goal="G1", product=PRODUCT, quantity=30, made=10, delivered=0),)
    for spec in MAKERS:
        house.bus.say(machine_heartbeat(spec.id, at_s=0.0, status=MachineStatus.PRODUCING, goals=goals))
    body = {"items": [{"product": PRODUCT, "quantity": ALL}], "due_at": "2030-03-17T17:47:00Z"}
    response = await house.client.post("/api/orders/preview", json=body)
    assert response.status_code == 200, response.text
    told = response.json()
    assert {offer["queue_s"] for offer in told["machines"]} == {20 * each for each in CYCLE_S.values()}
    assert told["late"] == "yes"
    assert told["earliest_at_s"] > NOW_S
    assert await house.orders_kept() == 0


@pytest.mark.anyio
@pytest.mark.parametrize(
    "fields",
    [
        {"items": [{"product": "nothing", "quantity": 1}]},
        {"due_at": "2020-01-01T00:00:00Z"},
        {"customer": "c"},
    ],
)
async def test_a_preview_of_nonsense_is_refused_as_the_order_would_be(
    house: House, fields: dict[str, Any]
) -> None:
    body = {"items": draft()["items"]} | fields
    problem(await house.client.post("/api/orders/preview", json=body), 422, "unusable-fields")

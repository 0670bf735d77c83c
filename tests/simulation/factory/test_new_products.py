"""A product that no plant file knows is ordered in a running factory: made, fed and delivered like all others."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from dray.messages import BillLine, Document, MachineCycle, OrderItem, ProductDefinition
from dray.messages.fact import GoalContracted, GoalLost, GoodsDelivered, OrderFulfilled
from dray.plant import default_plant
from dray_sim.bodies.documents import SimDocuments
from dray_sim.people.demand import Order
from dray_sim.run.evidence import HELD
from dray_sim.run.stage import Shift, Stage, play

PLANT = default_plant()
MADE_AT = tuple(PLANT.machines)[:2]
"""None of them was set up for the product, and they have no buffer for all of its materials."""

PRODUCT = ProductDefinition(
    lot=6,
    ability="tote",
    bill=tuple(BillLine(material, 1) for material in PLANT.materials),
    name="One of each",
    revision=2,
    machines=tuple(MachineCycle(machine, 20.0) for machine in MADE_AT),
)

KEPT = (GoalContracted, GoalLost, GoodsDelivered, OrderFulfilled)
HOUR_S = 3600.0


@pytest.mark.parametrize("killed", ["", MADE_AT[0], "strategist"])
def test_a_new_product_is_made_from_the_goal_alone(killed: str) -> None:
    async def script(stage: Stage) -> set[str]:
        await stage.until_s(30.0)
        items = (OrderItem("one-of-each", 24, PRODUCT),)
        stage.place(Order("N1", stage.now_s(), stage.now_s() + HOUR_S, items))
        await stage.until_s(200.0)
        if killed:
            stage.factory.restart(killed)
        await stage.settle(3 * HOUR_S)
        assert not stage.undelivered()
        return {seen.said.machine for seen in stage.witness.all(GoalContracted)}

    played = play(Shift("new-products", 1e5, codec=True, keep=KEPT), PLANT, 1, script)
    assert played.invariants == HELD
    assert played.result == set(MADE_AT)


CAM = Document("CAM program", "https://plm.example/one.nc", "text/plain", "ab" * 32)


def test_a_spoiled_document_holds_up_its_product_alone_until_it_is_put_right() -> None:
    held = PLANT.file.products[0].id
    with_cam = replace(PRODUCT, documents=(CAM,))

    async def script(stage: Stage) -> tuple[set[str], set[str]]:
        shelves = [cell.documents for cell in stage.factory.workcells.values()]
        for shelf in shelves:
            assert isinstance(shelf, SimDocuments)
            shelf.lies[CAM.address] = "cd" * 32
        await stage.until_s(30.0)
        due_s = stage.now_s() + HOUR_S
        stage.place(Order("BAD", stage.now_s(), due_s, (OrderItem("one-of-each", 6, with_cam),)))
        stage.place(Order("GOOD", stage.now_s(), due_s, (OrderItem(held, 6),)))
        await stage.until_s(HOUR_S)
        before = {seen.said.order for seen in stage.witness.all(OrderFulfilled)}
        for shelf in shelves:
            assert isinstance(shelf, SimDocuments)
            shelf.lies.clear()
        await stage.settle(2 * HOUR_S)
        return before, {seen.said.order for seen in stage.witness.all(OrderFulfilled)}

    played = play(Shift("spoiled-document", 1e5, codec=True, keep=KEPT), PLANT, 1, script)
    assert played.invariants == HELD
    assert played.result == ({"GOOD"}, {"GOOD", "BAD"})

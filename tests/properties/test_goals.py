"""What was ordered is made once, ordered material is what is needed, and goods travel once (invariants 2, 4)."""

from __future__ import annotations

from defaults import PLANT
from effects import facts, published
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from rigs import MachineRig, StrategistRig
from spoken import production

from dray.messages import Handover, OrderItem, OrderReleased, TaskAnnounced, Transport
from dray.messages.fact import OrderAccepted
from dray.protocol.machine.replenishment import order_quantity, reorder_point

PUMP = PLANT.products["pump-p3"]
MATERIALS = tuple(line.material for line in PUMP.bill)


@given(
    quantity=st.integers(min_value=1, max_value=120),
    stock=st.dictionaries(st.sampled_from(MATERIALS), st.integers(min_value=0, max_value=60)),
)
@settings(max_examples=examples(60))
def test_a_goal_is_made_carried_away_and_supplied_to_the_piece(quantity: int, stock: dict[str, int]) -> None:
    rig = MachineRig("M7", stock)
    rig.start()
    rig.take_goal("G1", production(quantity=quantity))
    done: set[str] = set()
    brought = dict.fromkeys(MATERIALS, 0)
    sent_away = 0
    for _ in range(400):
        waiting = [each for each in published(rig.all, TaskAnnounced) if each.task not in done]
        for announced in waiting[:1]:
            done.add(announced.task)
            work = announced.work
            assert isinstance(work, Transport)
            rig.hire(announced.task, "ATV2")
            if work.goal:
                sent_away += work.quantity
                rig.stocked(work.item, -work.quantity, "ATV2")
            else:
                assert work.quantity <= PLANT.materials[work.item].lot
                brought[work.item] += work.quantity
                rig.stocked(work.item, work.quantity, "ATV2")
                assert rig.stock[work.item] <= PLANT.materials[work.item].buffer
            rig.on_message("ATV2", Handover(task=announced.task, epoch=1, quantity=work.quantity))
        if rig.is_cycling:
            rig.cycle()
        elif not waiting:
            break
    assert sent_away == quantity
    for material in MATERIALS:
        missing = max(0, quantity - stock.get(material, 0))
        assert missing <= brought[material] < missing + PLANT.materials[material].lot


@given(st.integers(min_value=1, max_value=5000), st.sampled_from(sorted(PLANT.products)))
def test_an_order_is_split_into_no_more_goals_than_there_are_machines(quantity: int, product: str) -> None:
    rig = StrategistRig()
    rig.start()
    item = OrderItem(product=product, quantity=quantity)
    rig.on_message("gateway", OrderReleased(order="O1", items=(item,), due_s=7200.0))
    [taken] = facts(rig.all, OrderAccepted)
    assert 1 <= len(taken.goals) <= len(PLANT.machines_for(product))
    assert len(set(taken.goals)) == len(taken.goals)


@given(
    level=st.integers(0, 300),
    on_order=st.integers(0, 300),
    need=st.integers(0, 1000),
    point=st.integers(0, 300),
    lot=st.integers(1, 100),
    capacity=st.integers(1, 300),
)
def test_an_order_fits_its_container_and_its_buffer(
    level: int, on_order: int, need: int, point: int, lot: int, capacity: int
) -> None:
    quantity = order_quantity(
        level=level, on_order=on_order, need=need, point=point, lot=lot, capacity=capacity
    )
    assert 0 <= quantity <= lot
    if quantity:
        assert level + on_order + quantity <= capacity
        assert level + on_order < need
        assert level + on_order <= point


@given(
    use_per_s=st.floats(0.0, 10.0),
    lead_time_s=st.floats(0.0, 3600.0),
    per_cycle=st.integers(1, 20),
    lot=st.integers(1, 100),
    room=st.integers(0, 200),
)
def test_at_the_reorder_point_a_cycle_can_run_and_a_lot_has_room(
    use_per_s: float, lead_time_s: float, per_cycle: int, lot: int, room: int
) -> None:
    capacity = per_cycle + lot + room
    point = reorder_point(use_per_s, lead_time_s, per_cycle, capacity - lot)
    assert per_cycle <= point <= capacity - lot

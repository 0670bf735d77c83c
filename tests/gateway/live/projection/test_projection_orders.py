"""The projection of orders: what facts tell of their progress."""

from __future__ import annotations

from random import Random

import msgspec
from facts_kit import SPEED, arrived, contracted, delta, made, order, seen, tell, wall_s
from fake_bus import PLANT
from heartbeats import events, machine_heartbeat
from wall_clock import NOW_S

from dray.gateway.live.projection import Projection
from dray.gateway.live.projection.orders import ENDED_KEPT
from dray.gateway.live.timescale import TimeScale
from dray.messages import GoalBrief, MachineHeartbeat, MachineStatus, MaterialWait
from dray.messages.fact import AnyFact, OrderAccepted
from dray.store.orders.orders import Item, OrderTotals
from dray.store.orders.progress import Goal, OrderStatus


def test_an_order_is_followed_from_its_release_to_its_last_piece(projection: Projection) -> None:
    projection.orders.put(order("O-1", 4, 2, due_at_s=wall_s(1000.0)))
    assert seen(projection) == ("released", [(0, 0), (0, 0)])
    told: list[tuple[AnyFact, str]] = [
        (OrderAccepted(order="O-1", goals=("G1", "G2")), "released"),
        (contracted(), "in_production"),
        (contracted("G2", 1, 2), "in_production"),
        (made(4), "in_production"),
        (made(2, "G2", 1), "in_delivery"),
        (arrived(4), "in_delivery"),
        (arrived(2, "G2", 1), "delivered"),
    ]
    for fact, status in told:
        tell(projection, "somebody", fact, at_s=500.0)
        assert seen(projection)[0] == status
    factory = projection.factory(NOW_S)
    assert (factory.orders_open, factory.orders_delivered, factory.on_time_frac) == (0, 1, 1.0)
    assert projection.orders.views()[0].delivered_at_s == wall_s(501.0)


def test_a_machines_goal_tells_its_order_and_when_that_is_due(projection: Projection) -> None:
    projection.orders.put(order("O-1", 4, due_at_s=wall_s(1000.0)))
    tell(projection, "strategist", contracted())
    goals = tuple(
        GoalBrief(goal=name, product="P1", quantity=4, made=0, delivered=0) for name in ("G1", "G9")
    )
    projection.fold(machine_heartbeat("M8", goals=goals))
    view = projection.machines.view("M8")
    assert view is not None
    assert [goal.order_due_at_s for goal in view.goals] == [wall_s(1000.0), None]
    assert [goal.order_name for goal in view.goals] == ["O-1", ""]


def begun(projection: Projection, order: str) -> bool:
    view = projection.orders.view(order)
    assert view is not None
    return view.begun


def test_an_order_has_begun_when_a_machine_has_its_goal_first_in_the_queue(projection: Projection) -> None:
    projection.orders.put(order("O-1", 4))
    tell(projection, "strategist", contracted())
    first = GoalBrief(goal="G9", product="P1", quantity=2, made=0, delivered=0)
    own = GoalBrief(goal="G1", product="P1", quantity=4, made=0, delivered=0)
    projection.fold(machine_heartbeat("M8", 1, at_s=100.0, goals=(first, own)))
    assert seen(projection)[0] == "in_production"
    assert not begun(projection, "O-1")
    assert projection.orders.work_since_s("G1") is None
    projection.orders.take_changed()
    done = msgspec.structs.replace(first, made=2)
    projection.fold(machine_heartbeat("M8", 2, at_s=160.0, goals=(done, own)))
    projection.fold(machine_heartbeat("M8", 3, at_s=170.0, goals=(own,)))
    assert begun(projection, "O-1")
    assert projection.orders.work_since_s("G1") == wall_s(160.0)
    assert [view.id for view in projection.orders.take_changed()] == ["O-1"]
    projection.fold(machine_heartbeat("M8", 4, at_s=180.0, status=MachineStatus.ERROR, goals=(own,)))
    assert not begun(projection, "O-1")
    # A machine that works at something more urgent first has begun it all the same, once there is a piece.
    tell(projection, "M8", made(1))
    projection.fold(machine_heartbeat("M8", 5, at_s=190.0, goals=(first, own)))
    assert begun(projection, "O-1")


def test_parts_for_an_order_are_no_beginning_of_its_own_production(projection: Projection) -> None:
    projection.orders.put(order("O-1", 4))
    part = msgspec.structs.replace(contracted(), part_of="G1")
    tell(projection, "strategist", part)
    own = GoalBrief(goal="G1", product="P1", quantity=4, made=0, delivered=0)
    projection.fold(machine_heartbeat("M8", 1, goals=(own,)))
    assert not begun(projection, "O-1")


def test_facts_of_an_order_in_any_order_and_twice_end_the_same(projection: Projection) -> None:
    told = events(
        "somebody", contracted(), contracted("G2", 1, 2), made(2), made(4), arrived(2), arrived(4),
        made(2, "G2", 1), arrived(2, "G2", 1),
    )  # fmt: skip
    for seed in range(20):
        shuffled = [*told, *told]
        Random(seed).shuffle(shuffled)
        one = Projection(PLANT, TimeScale(0.0, NOW_S, SPEED))
        one.orders.put(order("O-1", 4, 2))
        for event in shuffled:
            one.fold(event)
        assert seen(one) == ("delivered", [(4, 4), (2, 2)])
        assert one.factory(NOW_S).orders_delivered == 1


def test_what_is_delivered_after_its_due_time_is_not_on_time(projection: Projection) -> None:
    projection.orders.restore([], OrderTotals(delivered=3, on_time=3))
    projection.orders.put(order(due_at_s=wall_s(50.0)))
    tell(projection, "M1", arrived(4), at_s=100.0)
    assert projection.factory(NOW_S).on_time_frac == 0.75


def test_a_stored_order_moves_only_when_it_is_released(projection: Projection) -> None:
    projection.orders.put(order(status=OrderStatus.STORED))
    tell(projection, "strategist", contracted())
    assert seen(projection)[0] == "stored"
    projection.orders.put(order(status=OrderStatus.RELEASED))
    assert seen(projection)[0] == "in_production"


def test_a_cancelled_order_stays_cancelled_whatever_still_arrives(projection: Projection) -> None:
    projection.orders.put(order())
    projection.orders.put(order(status=OrderStatus.CANCELLED))
    tell(projection, "M1", contracted(), arrived(4))
    assert seen(projection) == ("cancelled", [(4, 4)])
    projection.orders.put(order())
    assert seen(projection)[0] == "cancelled"
    assert projection.factory(NOW_S).orders_delivered == 0


def test_what_sql_says_late_does_not_take_back_what_was_heard(projection: Projection) -> None:
    projection.orders.put(order())
    tell(projection, "M1", contracted(), arrived(2))
    projection.orders.put(order())
    assert seen(projection) == ("in_delivery", [(2, 2)])


def test_after_a_restart_orders_stand_where_sql_left_them(projection: Projection) -> None:
    kept = order(status=OrderStatus.IN_DELIVERY, incarnation=1)
    kept.items[0].made = kept.items[0].delivered = 2
    goal = Goal("G1", "O-1", 0, "P1", 4, "M1", incarnation=1, made=2, delivered=2)
    projection.orders.restore([(kept, [goal])], OrderTotals(delivered=7, on_time=7))
    assert seen(projection) == ("in_delivery", [(2, 2)])
    for event in events(
        "strategist", OrderAccepted(order="O-1", goals=("Gr2",)), contracted("Gr2", 0, 2), life=2
    ):
        projection.fold(event)
    tell(projection, "M1", arrived(2, "Gr2"))
    assert seen(projection) == ("delivered", [(4, 4)])
    assert projection.factory(NOW_S).orders_delivered == 8


def test_only_the_last_fifty_orders_that_ended_are_kept(projection: Projection) -> None:
    names = [f"O-{number}" for number in range(ENDED_KEPT + 2)]
    for name in names:
        projection.orders.put(order(name))
        tell(projection, "M1", arrived(4, f"G-{name}", of=name))
    projection.orders.put(order("O-open"))
    assert [view.id for view in projection.orders.views()] == [*names[2:], "O-open"]
    assert delta(projection).gone == ("order:O-0", "order:O-1")
    # An ended one that is not shown any more is told of again: it is counted once.
    tell(projection, "M1", arrived(4, "G-O-0", of="O-0"))
    assert projection.factory(NOW_S).orders_delivered == len(names)


def test_an_event_about_an_order_that_nobody_placed_here_changes_nothing(projection: Projection) -> None:
    tell(projection, "M1", contracted(of="O-9"), arrived(4, of="O-9"))
    assert projection.orders.views() == ()
    assert not projection.changed


def lacking(*waits: MaterialWait, made_of: int = 0, seq: int = 1) -> MachineHeartbeat:
    """M1 has a goal of O-1, and tells what it waits for."""
    product = PLANT.products[0].id
    goal = GoalBrief(goal="G1", product=product, quantity=4, made=made_of, delivered=0)
    return machine_heartbeat("M1", seq=seq, goals=(goal,), waits=waits)


def test_an_order_tells_by_name_what_material_it_waits_for(projection: Projection) -> None:
    material = PLANT.products[0].bill[0].material
    name = next(each.name for each in PLANT.materials if each.id == material)
    other = next(
        each.id
        for each in PLANT.materials
        if each.id not in {line.material for line in PLANT.products[0].bill}
    )
    items = (Item(PLANT.products[0].id, 4),)
    projection.orders.put(order("O-1", items=items))
    tell(projection, "strategist", contracted(), at_s=1.0)
    projection.orders.take_changed()
    wait = MaterialWait(item=material, quantity=5, short=("S3",), silent=("S4", "S5"))
    projection.fold(lacking(MaterialWait(item=other, quantity=5, short=("S1",)), wait, seq=1))
    [view] = projection.orders.views()
    assert view.waits is not None
    assert view.waits.text == f"for {name} (storage S3 has none and storages S4, S5 do not answer)"
    assert projection.orders.take_changed() == (view,)
    [machine] = projection.machines.views()
    assert machine.waits is not None
    assert machine.waits.text.endswith(f"; {name} (storage S3 has none and storages S4, S5 do not answer)")
    assert not projection.orders.waits("O-1"), "somebody can make it"
    projection.fold(lacking(wait, made_of=4, seq=2))
    assert projection.orders.views()[0].waits is None, "what is made waits for nothing"
    projection.fold(lacking(wait, seq=3))
    projection.fold(lacking(seq=4))
    assert projection.orders.views()[0].waits is None
    assert len(projection.orders.take_changed()) == 1


def test_an_order_says_that_no_vehicle_gets_to_its_machine_and_no_more_when_it_opens(
    projection: Projection,
) -> None:
    projection.orders.put(order("O-1", 4))
    projection.orders.put(order("O-2", 4))
    tell(projection, "strategist", contracted())
    machine = contracted().machine
    projection.discard_changes()
    projection.orders.cut_off({machine, "S3"})
    assert [view.id for view in projection.orders.take_changed()] == ["O-1", "O-2"]
    assert projection.orders.closed("O-2") is None
    waits = projection.orders.closed("O-1")
    assert waits is not None
    assert (waits.reason, waits.detail) == ("closed", machine)
    assert waits.text == f"what is closed leaves no way; {machine}"
    projection.orders.cut_off({"S3", machine})
    assert projection.orders.take_changed() == ()
    projection.orders.cut_off(())
    assert len(projection.orders.take_changed()) == 2
    assert projection.orders.closed("O-1") is None
    projection.orders.cut_off({machine})
    tell(projection, "M1", arrived(4))
    assert projection.orders.closed("O-1") is None, "all of it has arrived"


def test_a_late_order_to_which_no_vehicle_gets_is_late_and_asks_for_no_machine_to_be_restored(
    projection: Projection,
) -> None:
    wanted = order("O-1", items=(Item(PLANT.products[0].id, 4),))
    projection.orders.put(msgspec.structs.replace(wanted, due_at_s=NOW_S + 5))
    tell(projection, "strategist", contracted())
    projection.orders.cut_off({contracted().machine})
    projection.look(NOW_S + 6)
    [alert] = [each for each in projection.alerts.views() if each.order]
    assert (alert.kind, alert.response) == ("order_late", "tell_customer")
    assert alert.cause is not None
    assert alert.cause.reason == "closed"

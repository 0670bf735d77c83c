"""A production machine orders the material that its goals need (paper, 3.2)."""

from __future__ import annotations

from defaults import KEYS, PLANT
from effects import published
from m7 import FULL, NO_HOUSINGS, handover, incoming, m7, transports
from rigs import MachineRig
from spoken import production

from dray.body import Broken, Repaired
from dray.messages import TaskAnnounced, Transport, TransportCancelled, TransportOrdered


def test_without_a_goal_nothing_is_ordered_however_empty_the_buffers_are() -> None:
    rig = m7({})
    assert transports(rig.run(60.0)) == []


def test_a_machine_orders_a_lot_of_everything_it_lacks_when_it_takes_a_goal() -> None:
    rig = m7({}, goal=24)
    assert incoming(rig.all) == [("housing", 24), ("impeller", 30), ("seal-kit", 40)]


def test_an_order_names_storages_destination_ability_and_a_deadline_that_can_be_kept() -> None:
    rig = m7(NO_HOUSINGS, goal=24)
    [announced] = published(rig.all, TaskAnnounced)
    assert announced.work == Transport(
        item="housing",
        quantity=24,
        sources=PLANT.storages_of("housing"),
        destination="M7",
        ability="pallet",
    )
    assert announced.deadline_s > 30.0
    assert announced.coordinator == "M7"
    assert (announced.x_m, announced.y_m) == PLANT.position_of("M7")


def test_material_is_ordered_at_the_reorder_point_and_not_before() -> None:
    rig = m7(FULL | {"housing": 24}, goal=1000)
    rig.run(1.0)
    point = rig.reported_stock()[0][0].reorder_point
    assert 1 < point < 20
    while rig.stock["housing"] > point + 1:
        assert incoming(rig.cycle()) == []
    assert ("housing", 24) in incoming(rig.cycle())
    assert rig.stock["housing"] == point


def test_one_need_is_never_ordered_twice() -> None:
    rig = m7(NO_HOUSINGS, goal=24)
    rig.run(120.0)
    rig.stocked("seal-kit", -1)
    rig.stocked("seal-kit", 1)
    rig.report(Broken(reason="oil"))
    rig.report(Repaired())
    assert incoming(rig.all) == [("housing", 24)]


def test_what_a_called_transport_was_to_bring_is_ordered_when_people_call_it_off() -> None:
    """A starved machine that has counted on it has no other occasion."""
    rig = m7(NO_HOUSINGS)
    [source, *_] = PLANT.storages_of("housing")
    rig.on_message("gateway", TransportOrdered("T-1", source, "housing", 24, 900.0))
    rig.take_goal("G1", production(quantity=24))
    assert [task for task in incoming(rig.all) if task[0] == "housing"] == [("housing", 24)]
    called_off = rig.on_message("gateway", TransportCancelled("T-1"))
    assert incoming(called_off) == [("housing", 24)]


def test_no_more_is_ordered_than_all_goals_need() -> None:
    rig = m7(NO_HOUSINGS, goal=20)
    rig.hire("M7-1", "ATV2")
    rig.stocked("housing", 24, "ATV2")
    rig.on_message("ATV2", handover())
    rig.cycles(20)
    rig.run(rig.now_s + 60.0)
    assert incoming(rig.all) == [("housing", 24)]


def test_a_need_that_grows_is_ordered_for() -> None:
    rig = m7(NO_HOUSINGS, goal=24)
    rig.hire("M7-1", "ATV2")
    rig.take_goal("G2", production(quantity=24, order="O2"))
    rig.stocked("housing", 24, "ATV2")
    effects = rig.on_message("ATV2", handover())
    effects += rig.cycles(24)
    assert ("housing", 24) in incoming(effects)


def test_material_for_several_products_is_ordered_once_for_all() -> None:
    rig = MachineRig("M8", {"impeller": 90, "seal-kit": 120, "shaft": 120, "bearing": 120})
    rig.start()
    rig.take_goal("PUMP", production(quantity=10))
    rig.take_goal("GEAR", production(product="gear-unit-g2", quantity=10, order="O2"))
    assert incoming(rig.all) == [("housing", 24)]


def test_every_task_has_a_name_of_its_own_in_every_life() -> None:
    names = []
    for incarnation in (1, 2):
        rig = MachineRig("M7", {}, incarnation=incarnation)
        rig.start()
        rig.take_goal("G1", production())
        names += [message.task for message in published(rig.all, TaskAnnounced)]
    assert len(names) == len(set(names)) == 6


def test_announcements_go_to_the_cells_within_the_radius_alone() -> None:
    rig = m7(NO_HOUSINGS, goal=24)
    keys = {effect.key for effect in rig.all if published([effect], TaskAnnounced)}  # type: ignore[union-attr]
    x_m, y_m = PLANT.position_of("M7")
    assert keys == {KEYS.transports(cell) for cell in PLANT.cells_within(x_m, y_m, 25.0)}

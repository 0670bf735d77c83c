"""Where a vehicle waits that has no dwell point."""

from __future__ import annotations

import msgspec
import pytest
from kit import PLANT

from dray.plant import Plant
from dray.protocol.vehicle.idle_positioning import WaitingPlaces

DOCKS = {PLANT.node_of(place) for place in PLANT.places}


@pytest.mark.parametrize("machine", PLANT.machines)
def test_it_is_near_and_nobodys_dock(machine: str) -> None:
    dock = PLANT.node_of(machine)
    spot = WaitingPlaces(PLANT, "light").nearest(dock)
    assert spot not in DOCKS
    routes = PLANT.routes("light")
    assert routes.duration_s(dock, spot) <= min(
        routes.duration_s(dock, node) for node in PLANT.nodes if node not in DOCKS
    )


def test_who_stands_at_nobodys_dock_stays() -> None:
    assert WaitingPlaces(PLANT, "light").nearest("e3") == "e3"


def test_where_every_node_is_a_dock_it_is_a_source_warehouse() -> None:
    file = PLANT.file
    spare = [node for node in PLANT.nodes if node not in DOCKS]
    parkings = tuple(
        msgspec.structs.replace(file.parkings[0], id=f"Q{number}", node=node)
        for number, node in enumerate(spare)
    )
    full = Plant(msgspec.structs.replace(file, parkings=(*file.parkings, *parkings)))
    assert WaitingPlaces(full, "light").nearest(PLANT.node_of("M8")) == PLANT.node_of(
        PLANT.source_warehouses[0]
    )


def test_a_dead_end_that_leads_to_no_dock_is_none() -> None:
    file = PLANT.file
    here = PLANT.nodes[PLANT.node_of("M8")]
    pit = msgspec.structs.replace(here, id="pit", x_m=here.x_m + 0.2)
    lane = msgspec.structs.replace(file.lanes[0], start=here.id, end="pit", both_ways=False)
    plant = Plant(msgspec.structs.replace(file, nodes=(*file.nodes, pit), lanes=(*file.lanes, lane)))
    assert WaitingPlaces(plant, "light").nearest(here.id) == WaitingPlaces(PLANT, "light").nearest(here.id)

"""Nodes with a largest vehicle: types that are larger, with their load, are led round them, and cannot be awarded what lies behind."""

from __future__ import annotations

import msgspec
import pytest
from msgspec.structs import replace

from dray.messages import Refusal, Transport
from dray.plant import Plant, PlantFile, load_plant
from dray.plant.exchange.lif_export import export_lif
from dray.plant.exchange.onto import put_onto
from dray.plant.exchange.read import read_layout
from dray.plant.file.check import faults
from dray.plant.file.document import write_document
from dray.plant.file.file import parse_plant
from dray.plant.model import LaneEnds, VehicleSize
from dray.plant.planning.advice import advice
from dray.protocol.vehicle.pricing import Pricer, Quote, Unable

LIGHT, HEAVY = "light", "heavy"
SMALL = VehicleSize(0.9, 0.7)
"""Light vehicles are 0.823 m x 0.592 m, heavy ones larger."""


def narrow(*nodes: str, size: VehicleSize = SMALL, two_lanes: bool = False) -> PlantFile:
    """The default plant with nodes for small vehicles only."""
    file = replace(load_plant("default").file, two_lanes=two_lanes)
    return replace(
        file,
        nodes=tuple(replace(node, max_vehicle=size) if node.id in nodes else node for node in file.nodes),
    )


def _driven_over(file: PlantFile) -> set[str]:
    plant = Plant(file)
    docks = [plant.node_of(place) for place in plant.places]
    routes = plant.routes(HEAVY)
    return {node for a in docks for b in docks for node in routes.way(a, b).nodes}


def _avoidable() -> str:
    """A node of the default plant over which ways of vehicles lead, and that can be driven around."""
    used = _driven_over(narrow())
    return next(
        node.id
        for node in narrow().nodes
        if node.id in used and not any(list(faults(narrow(node.id, two_lanes=two))) for two in (False, True))
    )


NARROW = _avoidable()


@pytest.mark.parametrize("two_lanes", [False, True])
def test_no_way_of_a_larger_type_leads_over_the_node(two_lanes: bool) -> None:
    plant = Plant(narrow(NARROW, two_lanes=two_lanes))
    mine = {
        node
        for node in plant.nodes
        if node == NARROW or node.startswith((f"{NARROW}.to-", f"{NARROW}.from-"))
    }
    assert mine
    entered = {kind: {lane.end for lane in plant.roads_of(kind).lanes} for kind in (LIGHT, HEAVY)}
    assert mine & entered[LIGHT] == mine & {lane.end for lane in plant.lanes}
    assert mine & entered[LIGHT]
    assert not mine & entered[HEAVY]
    assert not mine & _driven_over(plant.file)
    assert mine & _driven_over(narrow(two_lanes=two_lanes))


def test_a_size_that_is_just_enough_is_enough() -> None:
    heavy = load_plant("default").vehicle_types[HEAVY]
    for more_m, comes in ((0.0, True), (-0.01, False)):
        for size in (VehicleSize(heavy.length_m + more_m, 9.0), VehicleSize(9.0, heavy.width_m + more_m)):
            plant = Plant(narrow(NARROW, size=size))
            assert (NARROW in {lane.end for lane in plant.roads_of(HEAVY).lanes}) is comes


def test_a_vehicle_does_not_bid_for_what_it_is_too_large_to_reach() -> None:
    file = load_plant("default").file
    (dock,) = [machine for machine in file.machines if machine.id == "M8"]
    plant = Plant(narrow(dock.node))
    work = Transport(item="shaft", quantity=40, sources=("S3",), destination="M8", ability="tote")
    answers: dict[str, Quote | Unable] = {}
    for kind in (LIGHT, HEAVY):
        start = next(spec.node for spec in file.fleet if spec.type == kind)
        answers[kind] = Pricer(plant, kind).quote(
            work, node=start, node_at_s=0.0, battery_frac=0.9, now_s=0.0, deadline_s=3600.0
        )
    assert isinstance(answers[LIGHT], Quote)
    refused = answers[HEAVY]
    assert isinstance(refused, Unable)
    assert refused.reason is Refusal.NO_WAY


def test_check_names_who_goes_round_and_who_cannot_get_there() -> None:
    found = [one for one in advice(Plant(narrow(NARROW))) if one.kind == "large"]
    assert [(one.field, one.about) for one in found] == [("nodes", ((NARROW,),))]
    assert f"does not come to {NARROW}, where `max_vehicle` is smaller" in found[0].text
    assert not [one for one in advice(load_plant("default")) if one.kind == "large"]
    dock = load_plant("default").file.machines[0]
    told = dict(faults(narrow(dock.node)))
    (reason,) = (text for field, text in told.items() if field.startswith("vehicle_types"))
    assert f"heavy cannot get to {dock.id} and back" in reason
    assert f"it is larger than `max_vehicle` of {dock.node} allows" in reason


def test_a_node_for_nobody_is_a_fault_and_no_crash() -> None:
    file = narrow(load_plant("default").file.machines[0].node, size=VehicleSize(0.1, 0.1))
    assert any("cannot be reached" in text for _, text in faults(file))
    start = file.machines[0].node
    lane = next(lane for lane in file.lanes if start in (lane.start, lane.end))
    plant = Plant(file)
    assert plant.roads.lane(lane.start, lane.end) is None
    assert LaneEnds(lane.start, lane.end) not in [ends for door in plant.driven.doors for ends in door.lanes]


def test_it_comes_back_through_the_file_and_through_lif() -> None:
    file = narrow(NARROW)
    plant = parse_plant(write_document(msgspec.to_builtins(file)).encode(), "x.yaml")
    assert plant.file == file
    text = export_lif(plant, "2026-11-23T08:00:00Z")
    document = msgspec.json.decode(text)
    told = {
        node["nodeId"]: [each["vehicleTypeId"] for each in node["vehicleTypeNodeProperties"]]
        for node in document["layouts"][0]["nodes"]
    }
    assert {name for name, kinds in told.items() if kinds == [LIGHT]} <= {NARROW}
    imported = read_layout(text.encode(), "x.json")
    assert put_onto(imported.data, plant) == msgspec.to_builtins(plant.file)
    lanes = {(lane["start"], lane["end"]): lane.get("types") for lane in imported.data["lanes"]}
    own = plant.roads_of(HEAVY)
    assert all(
        (types is None or HEAVY in [each["type"] for each in types]) is (own.lane(*ends) is not None)
        for ends, types in lanes.items()
    )

"""A layout that is imported, and a fleet that knows only the ids and the frame of that layout: it delivers."""

from __future__ import annotations

import asyncio
from random import Random
from typing import Any

import msgspec

from dray.adapters.vda5050.profile import Profile, load_profile
from dray.messages import Event, Message
from dray.messages.fact import TaskClosed
from dray.plant import Plant, default_plant
from dray.plant.exchange.assemble import Imported
from dray.plant.exchange.lif_export import export_lif
from dray.plant.exchange.read import read_layout
from dray.plant.file.document import write_document
from dray.plant.file.file import parse_plant
from dray_sim.clock.loop import JUMP, clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.people import demand
from dray_sim.people.order_client import OrderClient
from dray_sim.vda5050.fleet import MemoryFleet
from dray_sim.vda5050.own_map import Axes, OwnMap

PROFILE = load_profile("dray-sim")

FAR = Axes(x_m=1000.0, y_m=-400.0)
"""Their maps begin elsewhere: LIF has such coordinates."""

ROOM_M = 10.0

Json = dict[str, Any]


class Delivered:
    def __init__(self) -> None:
        self.count = 0

    def on_message(self, _at_s: float, _sender: str, _address: str, message: Message) -> None:
        if type(message) is Event and type(message.fact) is TaskClosed:
            self.count += message.fact.outcome == "delivered"


def another_system(plant: Plant) -> tuple[bytes, dict[str, tuple[str, str]]]:
    """The floor of a plant as another system has it: two maps, each of which counts its nodes from 1, in coordinates far away.

    Returns:
        A LIF file, and the node of the plant -> its map and its id there.
    """
    document = msgspec.json.decode(export_lif(plant, "2026-11-23T08:00:00Z"))
    document["metaInformation"]["creator"] = "another system"
    (layout,) = document["layouts"]
    west = {node["nodeId"] for node in layout["nodes"] if node["nodePosition"]["x"] < plant.width_m / 2.0}
    ends = [(edge["startNodeId"], edge["endNodeId"]) for edge in layout["edges"]]
    border = {node for pair in ends if (pair[0] in west) != (pair[1] in west) for node in pair}
    theirs: dict[str, tuple[str, str]] = {}
    count = {"1": 0, "2": 0}
    for node in layout["nodes"]:
        map_id = "1" if node["nodeId"] in west | border else "2"
        count[map_id] += 1
        # Nodes of the border stand in both layouts: their numbers are nobody else's.
        theirs[node["nodeId"]] = map_id, f"{count[map_id] + 9000 * (node['nodeId'] in border)}"
        u, v = FAR.outward(node["nodePosition"]["x"], node["nodePosition"]["y"])
        node["nodePosition"] = {"x": u, "y": v}
    layouts = []
    for number in ("1", "2"):
        inside = [
            node
            for node in layout["nodes"]
            if theirs[node["nodeId"]][0] == number or node["nodeId"] in border
        ]
        known = {node["nodeId"] for node in inside}
        edges = [edge for edge in layout["edges"] if {edge["startNodeId"], edge["endNodeId"]} <= known]
        if number == "2":
            edges = [edge for edge in edges if not {edge["startNodeId"], edge["endNodeId"]} <= west | border]
        layouts.append(
            {
                "layoutId": number,
                "layoutLevelId": "ground",
                "layoutVersion": "1",
                "nodes": [
                    {**node, "nodeId": theirs[node["nodeId"]][1], "mapId": theirs[node["nodeId"]][0]}
                    for node in inside
                ],
                "edges": [
                    {
                        **edge,
                        "edgeId": f"{number}/{index}",
                        "startNodeId": theirs[edge["startNodeId"]][1],
                        "endNodeId": theirs[edge["endNodeId"]][1],
                    }
                    for index, edge in enumerate(edges)
                ],
                "stations": [],
            }
        )
    layouts[0]["stations"] = []
    document["layouts"] = layouts
    return msgspec.json.encode(document), theirs


def finished(imported: Imported, plant: Plant, theirs: dict[str, tuple[str, str]]) -> Plant:
    """The imported floor with the places and the fleet of a plant, each where it stood; written down, and read again."""
    by_id = {entry["id"]: entry for entry in imported.data["nodes"]}
    ours = {}
    for name, (map_id, node) in theirs.items():
        (ours[name],) = [
            id_
            for id_, entry in by_id.items()
            if entry["map"] == map_id and node in entry.get("originals", (id_,))
        ]
    known: Json = msgspec.to_builtins(plant.driven)
    data = {**known, **{key: imported.data[key] for key in ("nodes", "lanes", "maps")}}
    # The floor was moved to where it begins: what stands beside it needs room again.
    for spot in (
        *data["nodes"],
        *data["maps"],
        *(c for lane in data["lanes"] for c in lane.get("shape", ())),
    ):
        spot["x_m"], spot["y_m"] = spot["x_m"] + ROOM_M, spot["y_m"] + ROOM_M
    (frame,) = {(one["x_m"], one["y_m"]) for one in imported.data["maps"]}
    for section in ("warehouses", "storages", "chargers", "parkings", "machines"):
        data[section] = [
            {**place, "node": ours[place["node"]], "original": f"{place['id']} !"} for place in known[section]
        ]
    by_m = frame[0] - FAR.x_m, frame[1] - FAR.y_m
    for place in (*data["warehouses"], *data["storages"], *data["chargers"], *data["machines"]):
        place["box"] = {
            **place["box"],
            "x_m": place["box"]["x_m"] + by_m[0],
            "y_m": place["box"]["y_m"] + by_m[1],
        }
    data["fleet"] = [{**vehicle, "node": ours[vehicle["node"]]} for vehicle in known["fleet"]]
    data |= {"areas": (), "doors": (), "two_lanes": False}
    data |= {"width_m": plant.width_m + 2.0 * ROOM_M, "height_m": plant.height_m + 2.0 * ROOM_M}
    return parse_plant(write_document(data).encode(), "imported.yaml")


async def played(plant: Plant, own: OwnMap, profile: Profile, span_s: float) -> tuple[int, MemoryFleet]:
    delivered = Delivered()
    fleet = MemoryFleet(plant, clock(), lambda _: profile, own_map_of=lambda _: own)
    factory = SimFactory(plant, clock(), seed=1, listener=delivered, embody=fleet.embody)
    orders = list(demand.orders(plant, Random(1), load=1.0, until_s=span_s))
    running = asyncio.create_task(factory.run())
    customers = asyncio.create_task(OrderClient(factory.bus, factory.clock).place(orders))
    await asyncio.sleep(span_s)
    assert not running.done(), running
    for task in (running, customers):
        task.cancel()
    await asyncio.gather(running, customers, return_exceptions=True)
    return delivered.count, fleet


def test_a_fleet_that_knows_only_the_ids_of_the_imported_layout_delivers() -> None:
    text, theirs = another_system(default_plant())
    imported = read_layout(text, "hall.json")
    plant = finished(imported, default_plant(), theirs)
    nodes = {
        (entry["map"], name): entry["id"]
        for entry in imported.data["nodes"]
        for name in entry.get("originals", (entry["id"],))
    }
    assert set(nodes) == set(theirs.values())
    assert len({name for _, name in nodes}) < len(nodes), "some ids are on both maps"
    (shift,) = {(one["x_m"], one["y_m"]) for one in imported.data["maps"]}
    own = OwnMap(
        nodes,
        {f"{place} !": place for place in plant.places},
        dict.fromkeys(("1", "2"), Axes(*shift)),
        frozenset(
            lane[key]
            for lane in imported.data["lanes"]
            for key in ("original", "original_back")
            if key in lane
        ),
    )
    count, fleet = run(played(plant, own, PROFILE, 1800.0), JUMP)
    assert own.unknown == []
    assert fleet.notes == []
    assert count >= 10
    assert len(own.said & {"1", "2", "3"}) > 0

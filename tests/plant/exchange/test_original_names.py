"""An import says in the plant file what the layout calls nodes, lanes, stations and maps, where our ids are others."""

from __future__ import annotations

import msgspec
from layout_files import edge, layout, lif, node, station

from dray.plant import default_plant
from dray.plant.exchange.lif_export import export_lif
from dray.plant.exchange.onto import put_onto
from dray.plant.exchange.read import read_layout


def test_nodes_lanes_and_stations_keep_the_ids_that_may_be_none_of_ours() -> None:
    nodes = [node("1", 0, 0), node("b", 10, 0), node("Tor süd", 20, 0)]
    edges = [edge("1", "b"), edge("b", "1"), edge("b", "Tor süd")]
    data = read_layout(lif(layout(nodes, edges, [station("7.1", "b")])), "hall.json").data
    assert [(one["id"], one.get("originals")) for one in data["nodes"]] == [
        ("n-1", ["1"]),
        ("b", None),
        ("Tor-s-d", ["Tor süd"]),
    ]
    assert [(one["original"], one.get("original_back")) for one in data["lanes"]] == [
        ("1-b", "b-1"),
        ("b-Tor süd", None),
    ]
    assert data["unassigned"][0]["original"] == "7.1"
    assert data["maps"] == [{"id": "map"}]


def test_a_lane_there_and_back_keeps_which_edge_leads_where() -> None:
    data = read_layout(
        lif(layout([node("a", 0, 0), node("b", 10, 0)], [edge("b", "a"), edge("a", "b")])), "x"
    ).data
    (lane,) = data["lanes"]
    assert (lane["start"], lane["original"], lane["original_back"]) == ("b", "b-a", "a-b")


def test_two_floors_that_count_alike_lie_on_maps_of_their_own() -> None:
    lower = layout(
        [node("1", 5, 5, mapId="EG"), node("2", 9, 5, mapId="EG")], [edge("1", "2")], layoutLevelId="0"
    )
    upper = layout(
        [node("1", -5, 5, mapId="OG"), node("2", -9, 5, mapId="OG")],
        [edge("1", "2")],
        layoutLevelId="1",
        layoutId="U",
    )
    data = read_layout(lif(lower, upper), "hall.json").data
    assert [(one["id"], one["originals"], one["map"]) for one in data["nodes"]] == [
        ("n-1", ["1"], "EG"),
        ("n-2", ["2"], "EG"),
        ("n-1-U", ["1"], "OG"),
        ("n-2-U", ["2"], "OG"),
    ]
    spots = {one["id"]: (one["x_m"], one["y_m"]) for one in data["nodes"]}
    frames = {one["id"]: (one["x_m"], one.get("y_m", 0.0)) for one in data["maps"]}
    assert spots["n-1"] == (5 + frames["EG"][0], 5 + frames["EG"][1])
    assert spots["n-2-U"] == (-9 + frames["OG"][0], 5 + frames["OG"][1])


def test_nodes_that_became_one_are_all_understood() -> None:
    nodes = [node("a", 0, 0), node("a90", 0, 0), node("b", 10, 0)]
    data = read_layout(lif(layout(nodes, [edge("a", "a90"), edge("a90", "b")])), "hall.json").data
    assert data["nodes"][0]["originals"] == ["a", "a90"]


def test_a_map_of_two_levels_is_named() -> None:
    floors = [
        layout(
            [node(f"{level}1", 0, 0), node(f"{level}2", 5, 0)],
            [edge(f"{level}1", f"{level}2")],
            layoutLevelId=level,
        )
        for level in ("A", "B")
    ]
    notes = read_layout(lif(*floors), "hall.json").notes
    assert any(
        "map map is one of several levels: poses on it are taken for level A" in note.line() for note in notes
    )


def test_put_onto_a_plant_the_names_of_the_layout_are_taken() -> None:
    plant = default_plant()
    document = msgspec.json.decode(export_lif(plant, "2026-11-23T08:00:00Z"))
    document["metaInformation"]["creator"] = "another system"
    layout = document["layouts"][0]
    for one in layout["nodes"]:
        one["mapId"] = "hall 1"
    for one in layout["edges"]:
        one["edgeId"] = f"E {one['edgeId']}"
    moved = msgspec.json.encode(document)
    onto = put_onto(read_layout(moved, "x.json").data, plant)
    first = plant.file.lanes[0]
    assert onto["maps"] == [{"id": "hall 1"}]
    named = [lane for lane in onto["lanes"] if lane["original"]]
    assert named
    assert all(lane["original"] == f"E {lane['start']}--{lane['end']}" for lane in named)
    assert first.original is None
    # And a file of ours, which has other names, leaves those of the plant alone.
    known = msgspec.convert({**onto, "maps": tuple(onto["maps"])}, type(plant.file))
    again = put_onto(
        read_layout(export_lif(plant, "2026-11-23T08:00:00Z").encode(), "x.json").data, type(plant)(known)
    )
    assert msgspec.convert(again, type(plant.file)) == known

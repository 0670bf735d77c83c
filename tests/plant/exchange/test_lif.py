"""Reading LIF: nothing is dropped in silence, and what is odd is said with its place."""

from __future__ import annotations

from math import pi
from typing import Any

import pytest
from layout_files import edge, layout, lif, node, station

from dray.errors import PlantError
from dray.plant import Plant, PlantFile
from dray.plant.exchange.assemble import Imported
from dray.plant.exchange.read import read_layout
from dray.plant.file.document import write_document
from dray.plant.file.file import document_faults, parse_plant
from dray.plant.file.unfinished import drawable
from dray.plant.planning.drawing import draw

LINE = [node("a", 0, 0), node("b", 10, 0)]
HALF_CIRCLE = {
    "degree": 2,
    "knotVector": [0, 0, 0, 0.5, 0.5, 1, 1, 1],
    "controlPoints": [
        {"x": 0, "y": 0},
        {"x": 0, "y": 5, "weight": 0.7071067811865476},
        {"x": 5, "y": 5},
        {"x": 10, "y": 5, "weight": 0.7071067811865476},
        {"x": 10, "y": 0},
    ],
}


def read(*layouts: Any, **more: Any) -> Imported:
    return read_layout(lif(*layouts), "hall.json", **more)


def said(imported: Imported) -> str:
    return "\n".join(note.line() for note in imported.notes)


def drawn(imported: Imported) -> Plant:
    plant, whole = drawable(imported.data)
    assert whole is not None
    assert "<svg" in draw(plant)
    return plant


def test_two_edges_of_one_road_are_one_lane_and_a_single_one_runs_one_way() -> None:
    nodes = [*LINE, node("c", 10, 10)]
    found = read(layout(nodes, [edge("a", "b"), edge("b", "a"), edge("b", "c")]))
    assert found.data["lanes"] == [
        {
            "start": "a",
            "end": "b",
            "speed_limit_mps": 1.0,
            "both_ways": True,
            "original": "a-b",
            "original_back": "b-a",
        },
        {"start": "b", "end": "c", "speed_limit_mps": 1.0, "original": "b-c"},
    ]
    assert [[one["original"] for one in lane["original"]] for lane in found.mapping["lanes"]] == [
        ["a-b", "b-a"],
        ["b-c"],
    ]


def test_directions_of_other_limits_stay_two_lanes() -> None:
    found = read(layout(LINE, [edge("a", "b"), edge("b", "a", maxSpeed=0.5)]))
    assert [lane["speed_limit_mps"] for lane in found.data["lanes"]] == [1.0, 0.5]


def test_a_curve_keeps_its_length_and_its_shape() -> None:
    found = read(layout(LINE, [edge("a", "b", trajectory=HALF_CIRCLE)]))
    plant = drawn(found)
    length_m = sum(lane.length_m for lane in plant.lanes)
    assert length_m == pytest.approx(5 * pi, rel=0.005)
    corners = [(spot["x_m"], spot["y_m"]) for spot in found.data["lanes"][0]["shape"]]
    assert all((x_m - 5) ** 2 + y_m**2 == pytest.approx(25, rel=0.01) for x_m, y_m in corners)
    assert set(plant.stops) == {"a", "b"}


@pytest.mark.parametrize(
    ("broken", "why"),
    [
        ({"knotVector": [0, 1]}, "2 knots where 8 are needed"),
        ({"degree": 0}, "a degree of 0"),
        ({"degree": 99}, "a degree of 99"),
        ({"controlPoints": []}, "0 control points"),
        ({"controlPoints": "none"}, "0 control points"),
        ({"knotVector": [0, 0, 0, 0.6, 0.5, 1, 1, 1]}, "the knots fall"),
        ({"knotVector": [0] * 8}, "all knots are alike"),
        ({"knotVector": "abc"}, "0 knots"),
    ],
)
def test_a_trajectory_that_is_none_is_said_and_the_lane_is_straight(broken: dict[str, Any], why: str) -> None:
    found = read(layout(LINE, [edge("a", "b", trajectory={**HALF_CIRCLE, **broken})]))
    assert why in said(found) or "a knot is no number" in said(found)
    assert "shape" not in found.data["lanes"][0]


def test_a_trajectory_of_another_place_is_not_taken() -> None:
    nodes = [node("a", 0, 20), node("b", 10, 20)]
    found = read(layout(nodes, [edge("a", "b", trajectory=HALF_CIRCLE)]))
    assert "20.0 m off its node" in said(found)
    assert "shape" not in found.data["lanes"][0]


def of_types(*ends: str, **limits_mps: float | None) -> dict[str, Any]:
    """An edge with a limit for each type that may drive there."""
    properties = [
        {"vehicleTypeId": kind, **({} if limit is None else {"maxSpeed": limit})}
        for kind, limit in limits_mps.items()
    ]
    return {**edge(*ends), "vehicleTypeEdgeProperties": properties}


def for_types(each: dict[str, Any], *types: str) -> dict[str, Any]:
    return {**each, "vehicleTypeNodeProperties": [{"vehicleTypeId": kind} for kind in types]}


FOR_BOTH = [for_types(each, "kind", "slow") for each in LINE]


def test_each_type_keeps_its_own_limit_on_a_lane() -> None:
    found = read(
        layout(FOR_BOTH, [of_types("a", "b", kind=1.0, slow=0.4), of_types("b", "a", kind=1.0, slow=0.4)])
    )
    types = [{"type": "kind"}, {"type": "slow", "speed_limit_mps": 0.4}]
    assert found.data["lanes"] == [
        {
            "start": "a",
            "end": "b",
            "speed_limit_mps": 1.0,
            "types": types,
            "both_ways": True,
            "original": "a-b",
            "original_back": "b-a",
        }
    ]
    assert found.mapping["lanes"][0]["original"][0]["limits_mps"] == {"kind": 1.0, "slow": 0.4}
    assert [kind["max_speed_mps"] for kind in found.data["vehicle_types"]] == [1.0, 0.4]


def test_a_type_that_an_edge_does_not_name_may_not_drive_there() -> None:
    nodes = [*FOR_BOTH, for_types(node("c", 10, 10), "kind")]
    edges = [
        of_types("a", "b", kind=1.0),
        of_types("b", "a", kind=1.0, slow=1.0),
        of_types("b", "c", kind=1.0, slow=1.0),
    ]
    found = read(layout(nodes, edges))
    assert [lane.get("types") for lane in found.data["lanes"]] == [
        [{"type": "kind"}],
        None,
        [{"type": "kind"}],
    ]
    assert "edge b-c: slow may not be at one of its nodes" in said(found)
    assert drawn(found).roads_of("slow").lane("a", "b") is None


def test_an_edge_whose_nodes_are_for_nobody_is_said_and_kept_for_its_types() -> None:
    nodes = [for_types(LINE[0], "kind"), for_types(LINE[1], "slow")]
    found = read(layout(nodes, [of_types("a", "b", kind=1.0)]))
    assert found.data["lanes"][0]["types"] == [{"type": "kind"}]
    assert "none of its types (kind) may be at both of its nodes" in said(found)


def test_a_second_edge_for_another_type_admits_it_to_the_lane() -> None:
    second = {**of_types("a", "b", slow=0.5), "edgeId": "other"}
    found = read(layout(FOR_BOTH, [of_types("a", "b", kind=1.0), second]))
    types = [{"type": "kind"}, {"type": "slow", "speed_limit_mps": 0.5}]
    assert found.data["lanes"] == [
        {"start": "a", "end": "b", "speed_limit_mps": 1.0, "types": types, "original": "a-b"}
    ]
    assert "edge other is a second one from a to b: the first one is taken, also for slow" in said(found)


def test_what_a_plant_has_no_field_for_is_said_of_each_type() -> None:
    odd = edge("a", "b", rotationAllowed=True, maxRotationSpeed=0.3, loadRestriction={"loaded": False})
    found = read(layout(LINE, [odd]))
    for name in ("rotationAllowed", "maxRotationSpeed", "loadRestriction"):
        assert f"`{name}` of an edge property" in said(found)
    assert (
        found.mapping["lanes"][0]["original"][0]["kept"]["vehicleTypeEdgeProperties"]
        == (odd["vehicleTypeEdgeProperties"])
    )


def test_parallel_edges_are_said_and_kept_in_the_mapping() -> None:
    second = {**edge("a", "b", maxSpeed=2.0), "edgeId": "other"}
    found = read(layout(LINE, [edge("a", "b"), second]))
    assert len(found.data["lanes"]) == 1
    assert "/layouts/0/edges/1: edge other is a second one from a to b" in said(found)
    assert [one["original"] for one in found.mapping["lanes"][0]["original"]] == ["a-b", "other"]


def test_a_station_of_several_nodes_is_a_place_at_each() -> None:
    found = read(layout(LINE, [edge("a", "b")], [station("S 1", "b", "a", stationHeight="0.4")]))
    assert found.data["unassigned"] == [
        {"id": "S-1", "node": "b", "name": "S 1", "original": "S 1"},
        {"id": "S-1.2", "node": "a", "name": "S 1 (2 of 2)", "part_of": "S-1", "original": "S 1"},
    ]
    assert [(each["original"], each["node"]) for each in found.mapping["places"]] == [
        ("S 1", "b"),
        ("S 1", "a"),
    ]
    assert "/layouts/0/stations/0: station S 1 is served from 2 nodes (b, a): a place at each" in said(found)
    assert "`stationHeight` is a number written as text" in said(found)


def test_chargers_and_parking_places_of_several_nodes_are_one_at_each() -> None:
    nodes = [
        node("a", 0, 0, actions=("startCharging",)),
        node("b", 10, 0, actions=("startCharging",)),
        node("c", 20, 0, actions=("park",)),
        node("d", 30, 0, actions=("park",)),
    ]
    found = read(layout(nodes, [edge("a", "b")], [station("C", "a", "b"), station("P", "c", "d")]))
    assert [(each["id"], each["node"]) for each in found.data["chargers"]] == [("C", "a"), ("C.2", "b")]
    assert [(each["id"], each["node"]) for each in found.data["parkings"]] == [("P", "c"), ("P.2", "d")]
    assert found.data["unassigned"] == []


def test_chargers_and_parking_places_are_told_by_their_actions() -> None:
    nodes = [node("a", 0, 0, actions=("startCharging",)), node("b", 10, 0, actions=("park",))]
    found = read(layout(nodes, [edge("a", "b"), edge("b", "a")], [station("C", "a")]))
    assert found.data["chargers"] == [{"id": "C", "node": "a", "box": None}]
    assert found.data["parkings"] == [{"id": "P-b", "node": "b"}]


def test_levels_lie_beside_one_another() -> None:
    upper = layout([node("c", 0, 0), node("d", 10, 0)], [edge("c", "d")], layoutLevelId="1")
    lower = layout(LINE, [edge("a", "b"), edge("b", "c")], layoutLevelId="0")
    found = read(lower, {**upper, "layoutId": "U"})
    plant = drawn(found)
    assert plant.nodes["c"].x_m > plant.nodes["b"].x_m
    assert "leads to another level" in said(found)
    assert [moved["level"] for moved in found.mapping["moved_m"]] == ["0", "1"]
    alone = read(lower, {**upper, "layoutId": "U"}, layouts=("L",))
    assert [each["id"] for each in alone.data["nodes"]] == ["a", "b"]
    assert "layout U is left out, as asked for" in said(alone)
    assert "there is no node c" in said(alone)


def test_millimetres_are_found_out_and_degrees_are_said() -> None:
    nodes = [node("a", 0, 0), node("b", 10_000, 0)]
    nodes[0]["vehicleTypeNodeProperties"][0]["theta"] = 90.0
    found = read(layout(nodes, [edge("a", "b")]))
    assert found.data["nodes"][1]["x_m"] == 10.0
    assert "read as millimetres" in said(found)
    assert "degrees, it seems" in said(found)
    assert read(layout(nodes, [edge("a", "b")]), unit="m").data["nodes"][1]["x_m"] == 10_000


def test_ids_that_may_not_be_ours_are_given_others_and_the_mapping_keeps_them() -> None:
    names = ["Nächster Punkt", "1", "a" * 40, "n-1", 7]
    found = read(layout([node(name, 10 * at, 0) for at, name in enumerate(names)], []))
    ids = [each["id"] for each in found.data["nodes"]]
    assert len(set(ids)) == 5
    assert [each["original"] for each in found.mapping["nodes"]] == [str(name) for name in names]
    drawn(found)
    assert "`nodeId` is a number where a text belongs" in said(found)


def test_what_is_not_understood_is_said_and_kept() -> None:
    odd = {**node("a", "0", 0), "colour": "red"}
    found = read(layout([odd, LINE[1]], [edge("a", "b", wobble=1)], zones=[]))
    for text in (
        "`colour` of a node is not understood",
        "`wobble` of an edge property",
        "`zones` of a layout",
    ):
        assert text in said(found)
    assert "`x` is a number written as text" in said(found)
    assert found.mapping["nodes"][0]["kept"]["colour"] == "red"


def test_negative_coordinates_are_moved_onto_the_floor() -> None:
    found = read(layout([node("a", -5, -1), node("b", 10, 0)], [edge("a", "b")]))
    drawn(found)
    assert found.mapping["moved_m"] == [{"level": "map", "x_m": 7.0, "y_m": 3.0}]


def test_check_names_exactly_the_open_points() -> None:
    found = read(layout(LINE, [edge("a", "b"), edge("b", "a")], [station("S", "a")]))
    points = list(document_faults(found.data))
    fields = [field for field, _ in points]
    assert fields == [
        *("materials", "products", "warehouses", "storages", "stations", "machines", "areas", "chargers"),
        *(f"vehicle_types[0].{name}" for name in ("length_m", "width_m", "load_s", "unload_s", "battery_wh")),
        *("vehicle_types[0].charge_w", "fleet", "unassigned[0]"),
    ]
    with pytest.raises(PlantError) as raised:
        parse_plant(write_document(found.data), "hall.yaml")
    assert sorted(error.field for error in raised.value.errors) == sorted(fields)  # type: ignore[attr-defined]


def test_what_is_filled_in_is_open_no_more() -> None:
    nodes = [*LINE, node("c", 10, 10), node("d", 0, 10)]
    ends = [("a", "b"), ("b", "c"), ("c", "d"), ("d", "a")]
    found = read(
        layout(nodes, [edge(*pair) for one in ends for pair in (one, one[::-1])], [station("S", "a")])
    )
    box = {"x_m": 1, "y_m": 1, "width_m": 1, "depth_m": 1}
    data = found.data
    data.update(
        unassigned=[],
        areas=[],
        materials=[{"id": "steel", "name": "Steel", "lot": 5, "buffer": 20}],
        products=[{"id": "bolt", "name": "Bolt", "lot": 5, "bill": [{"material": "steel", "quantity": 1}]}],
        stations=[{"id": "W", "name": "W"}],
        warehouses=[
            {"id": kind, "name": kind, "kind": kind, "node": at, "box": box}
            for kind, at in (("source", "b"), ("delivery", "c"))
        ],
        storages=[
            {
                "id": "S",
                "name": "S",
                "node": "a",
                "box": box,
                "stocks": [{"material": "steel", "capacity": 50}],
            }
        ],
        machines=[
            {
                "id": "M",
                "name": "M",
                "station": "W",
                "node": "d",
                "box": box,
                "makes": [{"product": "bolt", "cycle_s": 9}],
            }
        ],
        chargers=[{"id": "C", "node": "b", "box": box}],
        fleet=[{"id": "V", "type": "kind", "node": "a"}],
    )
    data["vehicle_types"][0].update(
        length_m=1.0, width_m=0.6, load_s=10, unload_s=10, battery_wh=900, charge_w=500
    )
    plant = parse_plant(write_document(data), "hall.yaml")
    assert isinstance(plant.file, PlantFile)
    assert list(plant.machines) == ["M"]


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"", "is empty"),
        (b"[]", "no LIF file"),
        (b"{}", "no LIF file"),
        (b"{" * 100_000, "not JSON"),
        (b"[" * 100_000, "not JSON"),
        (b"\xff\xfe{", "not UTF-8"),
        (b'{"layouts": 3}', "no node"),
        (b'{"layouts": [null, 3, {"nodes": "x"}]}', "no node"),
        (b'{"layouts": [{"nodes": [{"nodeId": "a", "nodePosition": {"x": "far", "y": 1}}]}]}', "no node"),
    ],
)
def test_what_is_no_layout_is_refused(content: bytes, why: str) -> None:
    with pytest.raises(PlantError, match=why):
        read_layout(content, "hall.json")


def test_things_of_the_wrong_kind_are_said_and_not_stumbled_over() -> None:
    found = read(
        {
            "layoutId": 3,
            "nodes": [None, *LINE, {}, {"nodeId": None}, node("a", 1, 1), node("x", None, 1)],
            "edges": [
                {},
                edge("a", "nowhere"),
                edge("a", "a"),
                {**edge("a", "b"), "vehicleTypeEdgeProperties": None},
                {**edge("b", "a"), "vehicleTypeEdgeProperties": [3, {"maxSpeed": -1, "trajectory": 3}]},
            ],
            "stations": [
                3,
                {},
                station("S"),
                station("T", "nowhere"),
                {"stationId": "U", "interactionNodeIds": "a"},
            ],
        }
    )
    told = said(found)
    for text in (
        "an entry of `nodes` is no object",
        "node a is there already",
        "there is no node nowhere",
        "leads back to its own node",
        "a speed of -1 is none",
        "station S is left out",
        "the trajectory is no object",
    ):
        assert text in told
    assert [one["id"] for one in found.data["unassigned"]] == ["U"]
    drawn(found)


def test_a_name_that_turns_text_round_comes_without_that() -> None:
    file = lif(layout(LINE, [edge("a", "b")])).replace(b'"Hall"', b'"Hall \\u202eA\\u0007"')
    assert read_layout(file, "hall.json").data["name"] == "Hall A"


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32", "cp1252"])
def test_a_file_is_read_in_its_own_encoding(encoding: str) -> None:
    text = lif(layout([node("Prüfplatz", 0, 0), node("b", 5, 0)], [])).decode()
    found = read_layout(text.encode(encoding), "hall.json")
    assert found.mapping["nodes"][0]["original"] == "Prüfplatz"
    told = [note.line() for note in found.notes if "UTF-8" in note.text]
    assert len(told) == (1 if encoding == "cp1252" else 0)


def test_an_error_is_told_by_line_and_column_and_in_no_library_s_words() -> None:
    with pytest.raises(PlantError) as nan:
        read_layout('{"layouts":\n  [{"ü": NaN}]}'.encode(), "hall.json")
    assert nan.value.reason == "not JSON: line 2, column 10: NaN is no number of JSON: write null"
    with pytest.raises(PlantError) as cut:
        read_layout(b'{"layouts": [', "hall.json")
    assert cut.value.reason == "not JSON: it ends too soon"


def test_two_layouts_with_the_same_ids_are_each_driven_on_its_own_nodes() -> None:
    lower = layout(
        [node("a", 0, 0), node("b", 10, 0)], [edge("a", "b")], [station("S", "b")], layoutLevelId="0"
    )
    upper = layout(
        [node("a", 0, 5), node("b", 10, 5)],
        [edge("a", "b")],
        [station("S", "b")],
        layoutLevelId="0",
        layoutId="U",
    )
    found = read(lower, upper)
    assert [(each["id"], each["y_m"]) for each in found.data["nodes"]] == [
        ("a", 0.0),
        ("b", 0.0),
        ("a-U", 5.0),
        ("b-U", 5.0),
    ]
    assert [(lane["start"], lane["end"]) for lane in found.data["lanes"]] == [("a", "b"), ("a-U", "b-U")]
    assert [(place["id"], place["node"]) for place in found.data["unassigned"]] == [
        ("S", "b"),
        ("S-2", "b-U"),
    ]
    assert [each["original"] for each in found.mapping["nodes"]] == ["a", "b", "a", "b"]
    assert "node a stands in another layout, too, elsewhere: these are two nodes" in said(found)


def test_a_node_of_two_layouts_at_one_spot_is_one_and_joins_them() -> None:
    west = layout([node("a", 0, 0), node("door", 10, 0)], [edge("a", "door")])
    east = layout([node("door", 10, 0), node("b", 20, 0)], [edge("door", "b")], layoutId="E")
    found = read(west, east)
    assert [each["id"] for each in found.data["nodes"]] == ["a", "door", "b"]
    assert len(found.data["lanes"]) == 2
    assert "node door stands in two layouts at one spot: it is one node" in said(found)


@pytest.mark.parametrize(
    ("length", "speed", "unit", "factor"), [(300, 800, "mm", 0.001), (30, 80, "cm", 0.01)]
)
def test_speeds_that_cannot_be_are_asked_about_with_the_factor(
    length: int, speed: int, unit: str, factor: float
) -> None:
    content = layout([node("a", 0, 0), node("b", length, 0)], [edge("a", "b", maxSpeed=speed)])
    with pytest.raises(
        PlantError, match=f"speeds of {speed} m/s cannot be.*{unit} .times {factor}: edges of"
    ):
        read(content)
    found = read(content, unit=unit)
    assert found.data["nodes"][1]["x_m"] == pytest.approx(length * factor)
    told = read(content, unit="m")
    assert "a speed of" in said(told)
    assert told.data["lanes"][0]["speed_limit_mps"] == 1.5


@pytest.mark.parametrize(("speed", "unit", "factor"), [(800, "mm", 0.001), (80, "cm", 0.01)])
def test_lengths_and_speeds_that_both_cannot_be_tell_their_unit(speed: int, unit: str, factor: float) -> None:
    content = layout([node("a", 0, 0), node("b", 3000, 0)], [edge("a", "b", maxSpeed=speed)])
    found = read(content)
    assert found.data["nodes"][1]["x_m"] == pytest.approx(3000 * factor)
    assert found.data["lanes"][0]["speed_limit_mps"] == 0.8
    assert f"they are read as {unit}/s" in said(found)
    slow = layout([node("a", 0, 0), node("b", 3000, 0)], [edge("a", "b", maxSpeed=300)])
    with pytest.raises(PlantError, match=r"say its unit, cm .* or mm "):
        read(slow)


def test_one_speed_that_cannot_be_is_doubted_and_lengths_without_speeds_too() -> None:
    nodes = [node("a", 0, 0), node("b", 10, 0), node("c", 20, 0), node("d", 30, 0)]
    found = read(layout(nodes, [edge("a", "b"), edge("b", "c", maxSpeed=80), edge("c", "d")]))
    assert [lane["speed_limit_mps"] for lane in found.data["lanes"]] == [1.0, 1.5, 1.0]
    assert "a speed of 80 m/s cannot be: no limit is taken" in said(found)
    long = read(layout([node("a", 0, 0), node("b", 300, 0)], [edge("a", "b")]))
    assert "an edge is 300 m long at the median: say --unit cm or mm" in said(long)


@pytest.mark.parametrize(("off", "one_road"), [(0.0, True), (0.0009, True), (0.01, False)])
@pytest.mark.parametrize("knots", [[0, 0, 0, 0.5, 0.5, 1, 1, 1], [0, 0, 0, 0.4999, 0.4999, 1, 1, 1]])
def test_a_curve_there_and_back_is_one_road_when_it_is_the_same_to_a_millimetre(
    off: float, one_road: bool, knots: list[float]
) -> None:
    points = [
        {**point, "y": point["y"] + (off if point["y"] else 0.0)}
        for point in reversed(HALF_CIRCLE["controlPoints"])
    ]
    back = {**HALF_CIRCLE, "controlPoints": points, "knotVector": knots}
    found = read(layout(LINE, [edge("a", "b", trajectory=HALF_CIRCLE), edge("b", "a", trajectory=back)]))
    assert len(found.data["lanes"]) == (1 if one_road else 2)
    assert found.data["lanes"][0].get("both_ways", False) is one_road


def test_nodes_on_one_spot_that_turning_edges_join_are_one() -> None:
    nodes = [
        node("A", 0, 0),
        node("P", 5, 0),
        node("P_90", 5, 0.001, actions=("startCharging",)),
        node("B", 5, 6),
    ]
    pairs = ["A P", "P A", "P P_90", "P_90 P", "P_90 B", "B P_90"]
    edges = [edge(*pair.split()) for pair in pairs]
    found = read(layout(nodes, edges, [station("S", "P", "P_90"), station("T", "B")]))
    assert [each["id"] for each in found.data["nodes"]] == ["A", "P", "B"]
    assert [(lane["start"], lane["end"], lane["both_ways"]) for lane in found.data["lanes"]] == [
        ("A", "P", True),
        ("P", "B", True),
    ]
    assert [(place["id"], place["node"]) for place in found.data["chargers"]] == [("S", "P")]
    assert "nodes P and P_90 lie on one spot: they are one, at which vehicles turn" in said(found)
    assert found.mapping["nodes"][1]["kept"]["same_spot"][0]["original"] == "P_90"
    assert [turn["original"] for turn in found.mapping["kept"]["turns"]] == ["P-P_90", "P_90-P"]


def test_nodes_on_one_spot_that_no_edge_joins_and_short_chains_stay_as_they_are() -> None:
    apart = read(
        layout([node("a", 0, 0), node("b", 0, 0), node("c", 5, 0)], [edge("a", "c"), edge("c", "b")])
    )
    assert len(apart.data["nodes"]) == 3
    # Each is near its neighbour, and the last one is not near the first.
    row = [node(f"n{at}", at * 0.04, 0) for at in range(4)]
    chain = read(layout(row, [edge(f"n{at}", f"n{at + 1}") for at in range(3)]))
    assert [each["x_m"] for each in chain.data["nodes"]] == [0.0, 0.08]


def test_what_lif_2_0_0_has_new_is_understood() -> None:
    types = [{"manufacturer": "Maker", "seriesName": "S1"}]
    new = {"nodeId": "a", "nodePosition": {"x": 0, "y": 0}}
    forbidden = {"mobileRobotTypes": types, "forbiddenActionTypes": ["startCharging"]}
    found = read(
        layout(
            [{**new, "mobileRobotTypeNodeProperties": [forbidden]}],
            [],
            [station("S", "a", stationType="RACK", stationDescriptor="rack")],
        )
    )
    assert "is not understood" not in said(found)
    assert (
        "`forbiddenActionTypes` of a node property (actions that are forbidden) has no field in a plant"
        in said(found)
    )
    assert (found.data["chargers"], [place["id"] for place in found.data["unassigned"]]) == (None, ["S"])

"""Reading LIF of each version: the drafts name types of vehicles, and what vehicles do at a node, in ways of their own."""

from __future__ import annotations

from typing import Any

import pytest
from layout_files import edge, layout, lif, node, station

from dray.errors import PlantError
from dray.plant.exchange.assemble import Imported
from dray.plant.exchange.lif_values import NAMED as KNOWN
from dray.plant.exchange.read import read_layout

LINE = [node("a", 0, 0), node("b", 10, 0)]
NAMED = {"mobileRobotTypes": [{"manufacturer": "Maker", "seriesName": "S"}]}


def read(*layouts: Any) -> Imported:
    return read_layout(lif(*layouts), "hall.json")


def said(imported: Imported) -> str:
    return "\n".join(note.line() for note in imported.notes)


def test_the_draft_of_version_2_is_read() -> None:
    nodes = [{**each, "mobileRobotTypeNodeProperties": [NAMED]} for each in LINE]
    edges = [
        {
            "edgeId": "e",
            "startNodeId": "a",
            "endNodeId": "b",
            "mobileRobotTypeEdgeProperties": [{**NAMED, "maximumSpeed": 0.7}],
        }
    ]
    text = lif(origins=[{"originId": "O", "layouts": [layout(nodes, edges)]}])
    found = read_layout(text.replace(b'"layouts":[],', b""), "hall.json")
    assert found.data["lanes"] == [{"start": "a", "end": "b", "speed_limit_mps": 0.7, "original": "e"}]
    assert found.data["vehicle_types"][0]["id"] == "Maker.S"


@pytest.mark.parametrize("key", ["feasibleActions", "requiredActions"])
def test_chargers_are_told_by_what_vehicles_may_or_must_do_there_in_version_2(key: str) -> None:
    charges = {**NAMED, key: [{"actionType": "startCharging", "blockingType": "HARD"}]}
    nodes = [
        {**each, "mobileRobotTypeNodeProperties": [properties]}
        for each, properties in zip(LINE, (charges, NAMED), strict=True)
    ]
    found = read(layout(nodes, [edge("a", "b"), edge("b", "a")], [station("C", "a")]))
    assert found.data["chargers"] == [{"id": "C", "node": "a", "box": None}]
    assert f"`{key}` of a node property (actions, other than to tell chargers" in said(found)
    assert "not understood" not in said(found)


def test_a_draft_between_the_versions_names_the_type_in_its_own_way() -> None:
    nodes = [{**each, "mobileRobotTypeNodeProperties": [{"mobileRobotTypeId": "light"}]} for each in LINE]
    one = {
        "edgeId": "e",
        "startNodeId": "a",
        "endNodeId": "b",
        "mobileRobotTypeEdgeProperties": [{"mobileRobotTypeId": "light", "maximumSpeed": 0.7}],
    }
    found = read(layout(nodes, [one]))
    assert [each["id"] for each in found.data["vehicle_types"]] == ["light"]
    assert "taken for all" not in said(found)
    assert "not understood" not in said(found)


def origin(name: str | None, *layouts: Any, **more: object) -> dict[str, Any]:
    return {**({} if name is None else {"originId": name}), "layouts": list(layouts), **more}


def read_origins(*origins: dict[str, Any]) -> Imported:
    return read_layout(lif(origins=list(origins)).replace(b'"layouts":[],', b"", 1), "hall.json")


def test_origins_without_an_id_do_not_lie_on_one_another() -> None:
    one = layout(LINE, [edge("a", "b")])
    other = layout([node("c", 0, 0), node("d", 10, 0)], [edge("c", "d")], layoutId="M")
    apart = read_origins(origin(None, one), origin(None, other))
    spots = {(each["x_m"], each["y_m"]) for each in apart.data["nodes"]}
    assert len(spots) == 4
    assert "`originId` is missing (2 times" in said(apart)
    together = read_origins(origin("O", one), origin("O", other))
    assert len({(each["x_m"], each["y_m"]) for each in together.data["nodes"]}) == 2
    assert "originId" not in said(together)


def test_what_is_said_of_layouts_and_origins_is_kept() -> None:
    drawn = layout(LINE, [edge("a", "b")], layoutDescriptor="hall B", wild=1)
    found = read_origins(origin("O", drawn, originDescriptor="pillar 3", odd=2))
    assert found.mapping["kept"]["origins"] == [{"originId": "O", "originDescriptor": "pillar 3", "odd": 2}]
    (kept,) = found.mapping["kept"]["layouts"]
    assert (kept["layoutId"], kept["layoutDescriptor"], kept["wild"]) == ("L", "hall B", 1)
    assert kept.keys().isdisjoint({"nodes", "edges", "stations"})
    for text in ("`odd` of an origin is not understood", "`wild` of a layout is not understood"):
        assert text in said(found)


def test_a_list_of_types_that_is_empty_is_said() -> None:
    nobody = {**LINE[1], "mobileRobotTypeNodeProperties": []}
    found = read(layout([LINE[0], nobody], [edge("a", "b")]))
    assert "/nodes/1/mobileRobotTypeNodeProperties: `mobileRobotTypeNodeProperties` is empty" in said(found)


def test_a_lane_with_a_trajectory_and_a_guide_line_is_said() -> None:
    curve = {
        "degree": 1,
        "knotVector": [0, 0, 0.5, 1, 1],
        "controlPoints": [{"x": x, "y": y} for x, y in ((0, 0), (5, 3), (10, 0))],
    }
    guide = {"direction": "left", "length": 12.0}
    both = read(layout(LINE, [edge("a", "b", trajectory=curve, physicalLineGuidedProperty=guide)]))
    assert "a trajectory or a guide line, not both: the trajectory is taken" in said(both)
    assert both.data["lanes"][0]["shape"] == [{"x_m": 5.0, "y_m": 3.0}]
    for alone in ({"trajectory": curve}, {"physicalLineGuidedProperty": guide}):
        assert "not both" not in said(read(layout(LINE, [edge("a", "b", **alone)])))


def test_each_field_of_the_schema_of_2_0_0_is_known() -> None:
    """Its names as published in September 2026, by kind of object; what is not in a plant is kept."""
    published = {
        "metaInformation": "lifId creator exportTimestamp lifVersion",
        "origin": "originId originDescriptor layouts",
        "layout": "layoutId layoutName layoutVersion layoutLevelId layoutDescriptor nodes edges stations",
        "node": "nodeId nodeDescriptor mapId nodePosition mobileRobotTypeNodeProperties",
        "node property": "mobileRobotTypes theta allowedDeviationXY loadRestriction requiredActions"
        " feasibleActions forbiddenActionTypes",
        "edge": "edgeId edgeName edgeDescriptor startNodeId endNodeId mobileRobotTypeEdgeProperties",
        "edge property": "mobileRobotTypes orientationType reachOrientationBeforeEntering"
        " mobileRobotOrientations rotationAtStartNodeAllowed rotationAtEndNodeAllowed maximumSpeed"
        " maximumRotationSpeed minimumLoadHandlingDeviceHeight maximumMobileRobotHeight loadRestriction"
        " requiredActions feasibleActions forbiddenActionTypes trajectory physicalLineGuidedProperty"
        " reentryAllowed corridor",
        "station": "stationId interactionNodeIds stationName stationType stationDescriptor stationHeight"
        " stationPosition",
    }
    assert published.keys() == KNOWN.keys()
    assert {kind: set(names.split()) - KNOWN[kind] for kind, names in published.items()} == {
        kind: set() for kind in published
    }


@pytest.mark.parametrize("version", ["0.11.0", "1.0.0", "2.0.0"])
def test_a_version_that_is_known_is_no_oddity(version: str) -> None:
    assert "lifVersion" not in said(read_layout(of_version(version), "hall.json"))


@pytest.mark.parametrize("version", ["9.9.9", "3.0.0", "draft"])
def test_another_version_is_reported_with_those_that_are_known(version: str) -> None:
    assert (
        f"/metaInformation/lifVersion: lifVersion {version} is none of 0.x, 1.x, 2.x: read as far as it is alike"
        in said(read_layout(of_version(version), "hall.json"))
    )


def of_version(version: str) -> bytes:
    return lif(layout(LINE, [edge("a", "b")])).replace(
        b'"lifVersion":"1.0.0"', f'"lifVersion":"{version}"'.encode()
    )


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"", "it is empty: choose a LIF file (JSON) or a plant model of openTCS (XML)"),
        (b" \r\n", "it is empty: choose a LIF file (JSON) or a plant model of openTCS (XML)"),
        (b"hello", "it is neither JSON, as a LIF file is, nor XML, as a plant model of openTCS is"),
        (b'{"layouts":', "not JSON: it ends too soon"),
    ],
)
def test_a_file_that_is_no_layout_says_what_it_is_not(content: bytes, why: str) -> None:
    with pytest.raises(PlantError) as refused:
        read_layout(content, "hall.json")
    assert str(refused.value) == f"hall.json: {why}"

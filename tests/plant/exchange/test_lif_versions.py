"""Reading LIF of each version: the drafts name types of vehicles, and what vehicles do at a node, in ways of their own."""

from __future__ import annotations

from typing import Any

import pytest
from layout_files import edge, layout, lif, node, station

from dray.plant.exchange.assemble import Imported
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

"""Errors of a draft offer a repair; whoever takes it has solved the error and made no other."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any

import msgspec
import pytest

from dray.gateway.factory.plant_drafts import FindingView, findings
from dray.gateway.factory.repairs import MAX_REPAIRS, RepairView
from dray.plant import load_plant

Data = dict[str, Any]


def workshop() -> Data:
    data: Data = msgspec.json.decode(msgspec.json.encode(load_plant("workshop").file))
    return data


def repaired(data: Data, repair: RepairView) -> Data:
    """As the panel does it."""
    data = deepcopy(data)
    entries = data[repair.section]
    if repair.entry is None:
        assert repair.index is not None
        del entries[repair.index]
    elif repair.index is None:
        entries.append(repair.entry)
    else:
        entries[repair.index] |= repair.entry
        for other in repair.also:
            entries[other.index] |= other.entry
    return data


def faults(data: Data) -> list[FindingView]:
    return [each for each in findings(data) if each.level != "warning"]


def unreached(data: Data) -> None:
    data["nodes"].append({"id": "n1", "x_m": 3.0, "y_m": 3.0})
    data["parkings"].append({"id": "PX", "node": "n1"})


def without_a_way_out(data: Data) -> None:
    node = data["machines"][1]["node"]
    for lane in data["lanes"]:
        if node in (lane["start"], lane["end"]):
            lane["both_ways"] = False
            if lane["start"] == node:
                lane["start"], lane["end"] = lane["end"], lane["start"]


def box_beside_the_floor(data: Data) -> None:
    data["machines"][0]["box"]["x_m"] = -1.0


def node_beside_the_floor(data: Data) -> None:
    data["nodes"][0]["x_m"] = -1.0


def lane_twice(data: Data) -> None:
    data["lanes"].append(dict(data["lanes"][0]))


def two_on_one_spot(data: Data) -> None:
    data["fleet"][1]["node"] = data["fleet"][0]["node"]


@pytest.mark.parametrize(
    ("spoil", "kind"),
    [
        (unreached, "join"),
        (without_a_way_out, "back"),
        (box_beside_the_floor, "move"),
        (node_beside_the_floor, "move"),
        (lane_twice, "drop"),
        (two_on_one_spot, "stand"),
    ],
)
def test_an_error_of_the_floor_offers_a_repair_that_solves_it(
    spoil: Callable[[Data], None], kind: str
) -> None:
    data = workshop()
    assert faults(data) == []
    spoil(data)
    first = faults(data)[0]
    assert first.repair is not None
    assert first.repair.kind == kind
    assert first.repair.distance_m > 0.0
    assert len(first.repair.measure) == 2
    # The whole plant is judged then, and what a node has too little room for is another error.
    assert not [each for each in faults(repaired(data, first.repair)) if each.field == first.field]


def test_a_repair_of_a_lane_counts_the_lanes_that_are_closed_in_the_draft() -> None:
    data = workshop()
    lane_twice(data)
    extra = {"start": "x1", "end": "x2", "speed_limit_mps": 1.0}
    data["nodes"] += [{"id": "x1", "x_m": 1.0, "y_m": 1.0}, {"id": "x2", "x_m": 4.0, "y_m": 1.0}]
    data["lanes"].insert(0, extra)
    data["closed"] = [{"start": "x1", "end": "x2"}]
    repair = faults(data)[0].repair
    assert repair is not None
    assert repair.index == len(data["lanes"]) - 1
    assert faults(repaired(data, repair)) == []


def test_what_no_change_that_is_tried_solves_is_offered_none() -> None:
    data = workshop()
    data["lanes"][0]["end"] = data["lanes"][0]["start"]
    data["machines"][0]["node"] = "nowhere"
    assert [each.repair for each in faults(data)] == [None] * len(faults(data))


def test_a_draft_full_of_errors_gets_a_few_repairs_at_a_time() -> None:
    data = workshop()
    for number in range(3 * MAX_REPAIRS):
        data["nodes"].append({"id": f"far{number}", "x_m": -1.0 - number, "y_m": 1.0})
    offered = [each.repair for each in faults(data)]
    assert len(offered) >= 3 * MAX_REPAIRS
    assert sum(each is not None for each in offered) == MAX_REPAIRS


@pytest.mark.parametrize("nodes", [None, 7, [{}], [{"id": "a", "x_m": "?", "y_m": 1}]])
def test_a_draft_of_another_shape_is_judged_without_repairs(nodes: object) -> None:
    data = workshop() | {"nodes": nodes}
    assert all(each.repair is None for each in faults(data))


# --- warnings of the floor --------------------------------------------------------------------------------


def single_track() -> Data:
    data: Data = msgspec.json.decode(msgspec.json.encode(load_plant("single-track").file))
    return data


def with_floor(
    nodes: dict[str, tuple[float, float]], *lanes: tuple[str, str], two_lanes: bool = False
) -> Data:
    """A plant with a piece of road that nothing else is joined to."""
    data = single_track()
    data["height_m"] = 80.0
    data["nodes"] += [{"id": name, "x_m": x_m, "y_m": y_m} for name, (x_m, y_m) in nodes.items()]
    data["lanes"] += [
        {"start": start, "end": end, "both_ways": True, "two_lanes": two_lanes} for start, end in lanes
    ]
    return data


def narrow(data: Data) -> list[FindingView]:
    told = ("nearer to one another", "in the way of whoever drives past", "no room for a stop point")
    found = findings(data)
    assert {each.level for each in found} <= {"warning", "error"}
    return [each for each in found if any(text in each.text for text in told)]


NARROW = {
    "two places nearer than a vehicle is long": with_floor({"x1": (3, 38), "x2": (3.5, 38)}, ("x1", "x2")),
    "a stop point too near to a lane": with_floor(
        {"x1": (3, 38), "x2": (9, 38), "x3": (6, 37.6), "x4": (6, 34)}, ("x1", "x2"), ("x3", "x4")
    ),
    "a stop point too near to one of another road": with_floor(
        {"x1": (20, 60), "x2": (35, 60), "x3": (36.2, 60), "x4": (52, 60), "x5": (35, 50), "x6": (36.2, 50)},
        ("x1", "x2"),
        ("x2", "x5"),
        ("x3", "x6"),
        ("x3", "x4"),
        two_lanes=True,
    ),
    "two crossings without room for a stop point": with_floor(
        {"x1": (20, 60), "x2": (35, 60), "x3": (37, 60), "x4": (52, 60), "x5": (35, 50), "x6": (37, 70)},
        ("x1", "x2"),
        ("x2", "x3"),
        ("x3", "x4"),
        ("x2", "x5"),
        ("x3", "x6"),
        two_lanes=True,
    ),
}


@pytest.mark.parametrize("what", NARROW)
def test_a_warning_of_the_floor_offers_a_repair_that_mends_it(what: str) -> None:
    data = deepcopy(NARROW[what])
    first = next(each for each in narrow(data) if each.repair is not None)
    assert first.repair is not None
    assert first.repair.kind == "shift"
    assert 0.0 < first.repair.distance_m <= 5.0
    repaired_once = repaired(data, first.repair)
    assert len(narrow(repaired_once)) < len(narrow(data)) or (narrow(repaired_once)[0].text != first.text)


def test_each_of_several_narrow_places_is_mended_in_its_turn() -> None:
    places = {f"x{number}": (3 + 0.5 * number, 38.0) for number in range(4)}
    data = with_floor(places, *((f"x{number}", f"x{number + 1}") for number in range(3)))
    for _ in range(8):
        found = narrow(data)
        if not found:
            return
        repair = found[0].repair
        if repair is None:
            # Between two others, a place cannot be moved away from both at once.
            break
        data = repaired(data, repair)
    assert len(narrow(data)) <= 2


def test_a_shipped_plant_offers_nothing() -> None:
    assert [each.repair for each in findings(workshop())] == [None] * len(findings(workshop()))

"""Plant files that are not finished: what is open is named with its field, and what is in them is drawn."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from dray.errors import PlantError
from dray.plant import parse_plant
from dray.plant.file.document import read_document, write_document
from dray.plant.file.file import document_faults, unfinished_plant
from dray.plant.file.unfinished import drawable
from dray.plant.planning.drawing import draw

Break = Any


def data_of(text: str) -> dict[str, Any]:
    data = read_document(text, "small.yaml").data
    assert isinstance(data, dict)
    return data


def test_a_good_file_has_no_open_points_and_is_drawn_whole(small_text: str) -> None:
    data = data_of(small_text)
    assert list(document_faults(data)) == []
    plant, whole = drawable(data)
    assert whole is not None
    assert list(plant.machines) == ["M1"]


@pytest.mark.parametrize("section", ["machines", "materials", "chargers", "fleet", "vehicle_types", "areas"])
def test_a_section_that_is_null_is_open_and_nothing_else_is_said(small_text: str, section: str) -> None:
    data = {**data_of(small_text), section: None}
    found = [field for field, _ in document_faults(data)]
    assert section in found
    assert "<svg" in draw(drawable(data)[0])


def test_open_fields_are_named_one_by_one_and_wrong_ones_beside_them(small_text: str) -> None:
    data = data_of(small_text)
    data["machines"][0].update(box=None, makes=None, goods_capacity="many", nose=1)
    data["lanes"][0]["two_lanes"] = None
    found = dict(document_faults(data))
    assert list(found) == [
        "machines[0].box",
        "machines[0].makes",
        "machines[0].goods_capacity",
        "machines[0].nose",
    ]
    assert found["machines[0].box"].startswith("is open: where it stands")


def test_a_box_that_is_open_is_said_once_at_the_edge_of_the_floor_too(small_text: str) -> None:
    data = data_of(small_text)
    spot = next(node for node in data["nodes"] if node["id"] == data["machines"][0]["node"])
    spot.update(x_m=0.0, y_m=0.0)
    data["machines"][0]["box"] = None
    said = [reason for field, reason in document_faults(data) if field == "machines[0].box"]
    assert len(said) == 1
    assert said[0].startswith("is open")


def test_lanes_are_checked_although_something_else_is_open(small_text: str) -> None:
    data = {**data_of(small_text), "machines": None}
    data["lanes"].append({"start": "west", "end": "middle"})
    assert "lanes[4]" in dict(document_faults(data))


def test_a_station_that_is_unassigned_is_a_fault_of_a_file_that_is_complete_otherwise(
    small_text: str,
) -> None:
    data = {**data_of(small_text), "unassigned": [{"id": "U", "name": "U", "node": "west"}]}
    (only,) = document_faults(data)
    assert only[0] == "unassigned[0]"
    assert "nobody has said what U at west is" in only[1]


def test_an_unfinished_file_is_drawn_and_a_file_that_is_none_is_refused(
    small_text: str, tmp_path: Path
) -> None:
    path = tmp_path / "draft.yaml"
    path.write_text(
        small_text.replace("id: M1", "id: ~").replace("end: north", "end: nowhere"), encoding="utf-8"
    )
    plant, faults = unfinished_plant(path)
    assert not plant.machines
    assert {fault.field for fault in faults} == {"machines[0].id"}
    path.write_text("- 1", encoding="utf-8")
    with pytest.raises(PlantError, match="no mapping"):
        unfinished_plant(path)


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-3, 3) | st.text(max_size=3) | st.floats(-1e9, 1e9),
    lambda inner: (
        st.lists(inner, max_size=2) | st.dictionaries(st.sampled_from(["id", "node", "x_m", "start"]), inner)
    ),
    max_leaves=4,
)


@settings(max_examples=examples(80), deadline=None)
@given(spot=st.data())
def test_a_file_with_anything_anywhere_is_judged_and_drawn(spot: st.DataObject, small_text_once: str) -> None:
    data = data_of(small_text_once)
    section = spot.draw(st.sampled_from(list(data)))
    value = data[section]
    if isinstance(value, list) and value and spot.draw(st.booleans()):
        entry = value[spot.draw(st.integers(0, len(value) - 1))]
        entry[spot.draw(st.sampled_from(list(entry)))] = spot.draw(VALUES)
    else:
        data[section] = spot.draw(VALUES)
    found = list(document_faults(data))
    plant, _ = drawable(data)
    assert draw(plant).startswith("<svg")
    if not found:
        parse_plant(write_document(data), "again.yaml")

"""Reading plant models of openTCS."""

from __future__ import annotations

from math import pi

import pytest
from layout_files import model

from dray.errors import PlantError
from dray.plant.exchange.assemble import Imported
from dray.plant.exchange.curves import bezier, length_m
from dray.plant.exchange.read import read_layout
from dray.plant.file.unfinished import drawable
from dray.plant.planning.drawing import draw


def read(content: bytes) -> Imported:
    return read_layout(content, "hall.xml")


def said(imported: Imported) -> str:
    return "\n".join(note.line() for note in imported.notes)


def test_a_model_becomes_a_plant_in_metres_with_ids_of_ours() -> None:
    found = read(model())
    assert found.data["nodes"] == [
        {"id": "Point-1", "x_m": 2.0, "y_m": 0.0},
        {"id": "Point-2", "x_m": 12.0, "y_m": 0.0},
        {"id": "Point-3", "x_m": 12.0, "y_m": 10.0},
    ]
    assert found.data["lanes"] == [
        {"start": "Point-1", "end": "Point-2", "speed_limit_mps": 1.0},
        {"start": "Point-2", "end": "Point-3", "speed_limit_mps": 0.5},
    ]
    assert found.mapping["nodes"][0]["original"] == "Point 1"
    plant, whole = drawable(found.data)
    assert whole is not None
    assert "<svg" in draw(plant)


def test_locations_chargers_and_parking_places() -> None:
    found = read(model())
    assert found.data["chargers"] == [{"id": "Outlet", "node": "Point-1", "box": None}]
    assert found.data["parkings"] == [{"id": "P-Point-3", "node": "Point-3"}]
    assert found.data["unassigned"] == [
        {"id": "Rack-A", "node": "Point-2", "name": "Rack --- A"},
        {"id": "Rack-A.2", "node": "Point-3", "name": "Rack --- A (2 of 2)", "part_of": "Rack-A"},
    ]
    assert "location Alone is left out: no link leads to it" in said(found)
    assert "line 30, <block Block>: a block has no place in a plant" in said(found)


def test_vehicles_are_the_fleet_with_their_levels() -> None:
    found = read(model())
    assert found.data["fleet"] == [{"id": "Truck-1", "type": "type-1", "node": "Point-3"}]
    kind = found.data["vehicle_types"][0]
    assert (kind["length_m"], kind["width_m"], kind["max_speed_mps"]) == (1.5, 0.8, 1.2)
    assert kind["charging"] == {"must_below_frac": 0.2, "below_frac": 0.7, "up_to_frac": 0.95}
    assert kind["battery_wh"] is None


def test_a_path_that_is_driven_backwards_leads_the_other_way_too() -> None:
    alike = read(model(reverse="1000"))
    assert alike.data["lanes"][0] == {
        "start": "Point-1",
        "end": "Point-2",
        "speed_limit_mps": 1.0,
        "both_ways": True,
    }
    slower = read(model(reverse="300"))
    assert [(lane["start"], lane["speed_limit_mps"]) for lane in slower.data["lanes"][:2]] == [
        ("Point-1", 1.0),
        ("Point-2", 0.3),
    ]


def test_a_locked_path_is_no_lane_and_is_kept() -> None:
    found = read(model(locked="true"))
    assert len(found.data["lanes"]) == 1
    assert "a locked path is left out of the lanes" in said(found)
    assert found.mapping["kept"]["locked"][0]["name"] == "Point 2 --- Point 3"


def test_a_bezier_path_keeps_its_shape_and_its_length_is_compared() -> None:
    # A quarter of a circle to the right of the straight way, as well as a cubic can.
    points = '<controlPoint x="290.457" y="0"/><controlPoint x="290.457" y="-200"/>'
    found = read(model(drawn="BEZIER", points=points))
    lane = found.data["lanes"][1]
    plant, _ = drawable(found.data)
    driven_m = sum(one.length_m for one in plant.lanes if one.start != "Point-1")
    assert len(lane["shape"]) > 3
    assert driven_m > 10.5
    assert f"{driven_m:.2f} m as it is drawn" in said(found)
    assert max(corner["x_m"] for corner in lane["shape"]) > 15.0


def test_a_chain_is_taken_as_it_is_and_the_symbols_of_the_editor_as_straight() -> None:
    chain = read(model(drawn="POLYPATH", points='<controlPoint x="200" y="-20"/>'))
    assert chain.data["lanes"][1]["shape"] == [{"x_m": 13.0, "y_m": 1.0}]
    for drawn in ("ELBOW", "SLANTED", "SPIRAL"):
        odd = read(model(drawn=drawn))
        assert "shape" not in odd.data["lanes"][1]
        assert f"a path drawn as {drawn} is taken as straight" in said(odd)


def test_a_quarter_circle_is_right_to_a_thousandth() -> None:
    k = 0.5522847498
    corners = bezier([(10.0, 0.0), (10.0, 10 * k), (10 * k, 10.0), (0.0, 10.0)])
    assert length_m(corners) == pytest.approx(5 * pi, rel=0.002)


def test_older_and_newer_models_are_read_as_far_as_they_are_alike() -> None:
    old = model().replace(b"7.0.0", b"0.0.2")
    for new, before in ((b"positionX", b"xPosition"), (b"positionY", b"yPosition")):
        old = old.replace(new, before)
    found = read(old)
    assert len(found.data["nodes"]) == 3
    assert "model version 0.0.2 is none of" in said(found)


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"<", "not XML"),
        (b"<html/>", "begins with <model>"),
        (b'<!DOCTYPE m [<!ENTITY a "b">]><model/>', "document type"),
        (b"<model/>", "there is no node"),
        (b"<model>" + b"<a>" * 500, "nested too deep"),
        (b"<model><point name='a' positionX='x' positionY='1'/></model>", "no number"),
    ],
)
def test_what_is_no_model_is_refused(content: bytes, why: str) -> None:
    with pytest.raises(PlantError, match=why):
        read(content)


def test_references_to_nothing_are_said() -> None:
    broken = model().replace(b'destinationPoint="Point 3"', b'destinationPoint="Point 9"')
    broken = broken.replace(b'value="Point 3"', b'value="Point 9"').replace(
        b'<link point="Point 2"/>', b'<link point="P"/>'
    )
    told = said(read(broken))
    assert "path Point 2 --- Point 3 is left out: there is no point Point 9" in told
    assert "vehicle Truck 1 begins at Point 9" in told
    assert "location Rack --- A: there is no point P" in told

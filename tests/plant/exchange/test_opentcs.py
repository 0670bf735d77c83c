"""Reading plant models of openTCS."""

from __future__ import annotations

import re
from math import pi
from pathlib import Path

import pytest
import yaml
from layout_files import model

from dray.errors import PlantError
from dray.plant.exchange.assemble import Imported
from dray.plant.exchange.curves import bezier, length_m
from dray.plant.exchange.read import read_layout
from dray.plant.file.document import write_document
from dray.plant.file.file import parse_plant
from dray.plant.file.unfinished import drawable
from dray.plant.planning.advice import advice
from dray.plant.planning.drawing import draw


def read(content: bytes) -> Imported:
    return read_layout(content, "hall.xml")


def said(imported: Imported) -> str:
    return "\n".join(note.line() for note in imported.notes)


def test_a_model_becomes_a_plant_in_metres_with_ids_of_ours() -> None:
    found = read(model())
    assert found.data["nodes"] == [
        {"id": "Point-1", "x_m": 2.0, "y_m": 0.0, "originals": ["Point 1"]},
        {"id": "Point-2", "x_m": 12.0, "y_m": 0.0, "originals": ["Point 2"]},
        {"id": "Point-3", "x_m": 12.0, "y_m": 10.0, "originals": ["Point 3"]},
    ]
    assert found.data["lanes"] == [
        {"start": "Point-1", "end": "Point-2", "speed_limit_mps": 1.0, "original": "Point 1 --- Point 2"},
        {"start": "Point-2", "end": "Point-3", "speed_limit_mps": 0.5, "original": "Point 2 --- Point 3"},
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
        {"id": "Rack-A", "node": "Point-2", "name": "Rack --- A", "original": "Rack --- A"},
        {
            "id": "Rack-A.2",
            "node": "Point-3",
            "name": "Rack --- A (2 of 2)",
            "part_of": "Rack-A",
            "original": "Rack --- A",
        },
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
        "original": "Point 1 --- Point 2",
        "original_back": "Point 1 --- Point 2",
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


def drawn_model(*, lengths: str = "5000", head: str = "", kind: str = "DIRECT", points: str = "") -> bytes:
    """A model of 0.0.2 that was drawn in the editor and never given coordinates."""
    spots = {"A": (0, 0), "B": (5000, 0), "C": (5000, 5000)}
    return f"""{head}<model version="0.0.2" name="hall">
    {"".join(f'<point name="{name}" xPosition="0" yPosition="0" type="HALT_POSITION"/>' for name in spots)}
    <path name="A --- B" sourcePoint="A" destinationPoint="B" length="{
        lengths
    }" maxVelocity="1000" maxReverseVelocity="0"/>
    <path name="B --- C" sourcePoint="B" destinationPoint="C" length="{
        lengths
    }" maxVelocity="1000" maxReverseVelocity="0"/>
    <visualLayout name="V" scaleX="50.0" scaleY="50.0">
      {
        "".join(
            f'<modelLayoutElement visualizedObjectName="{name}" layer="0"><property name="POSITION_X" value="{x}"/>'
            f'<property name="POSITION_Y" value="{y}"/></modelLayoutElement>'
            for name, (x, y) in spots.items()
        )
    }
      <modelLayoutElement visualizedObjectName="B --- C" layer="0">
        <property name="CONN_TYPE" value="{kind}"/><property name="CONTROL_POINTS" value="{points}"/>
      </modelLayoutElement>
    </visualLayout></model>""".encode()


def test_a_model_that_was_only_drawn_has_the_coordinates_of_its_drawing_and_says_so() -> None:
    found = read(drawn_model())
    assert [(node["x_m"], node["y_m"]) for node in found.data["nodes"]] == [
        (0.0, 0.0),
        (5.0, 0.0),
        (5.0, 5.0),
    ]
    assert "no point has coordinates of its own: where they are drawn is taken" in said(found)
    assert "times" not in said(found)


def test_a_drawing_is_scaled_by_the_lengths_of_its_paths_where_these_agree() -> None:
    found = read(drawn_model(lengths="20000"))
    assert found.data["nodes"][2] == {"id": "C", "x_m": 20.0, "y_m": 20.0}
    assert "times 4, so that paths are as long as their `length`" in said(found)
    # What the editor writes where no length is known tells nothing.
    assert read(drawn_model(lengths="1")).data["nodes"][2]["x_m"] == 5.0


def test_a_drawing_of_today_is_taken_too_and_only_where_points_lie_on_one_spot() -> None:
    old = drawn_model().decode()
    for name, x, y in (("A", 0, 0), ("B", 5000, 0), ("C", 5000, 5000)):
        point = f'<point name="{name}" xPosition="0" yPosition="0" type="HALT_POSITION"'
        old = old.replace(f"{point}/>", f'{point}><pointLayout xPosition="{x}" yPosition="{y}"/></point>')
    new = old[: old.index("<visualLayout")] + "</model>"
    assert read(new.encode()).data["nodes"][2] == {"id": "C", "x_m": 5.0, "y_m": 5.0}
    placed = new.replace('name="B" xPosition="0"', 'name="B" xPosition="3000"', 1)
    assert read(placed.encode()).data["nodes"][1] == {"id": "B", "x_m": 3.0, "y_m": 0.0}


def test_curves_of_older_models_are_read() -> None:
    found = read(drawn_model(kind="BEZIER", points="140,0;140,-100"))
    assert max(corner["x_m"] for corner in found.data["lanes"][1]["shape"]) > 6.0
    chain = read(drawn_model(kind="POLYPATH", points="120,-20;120,-80;"))
    assert chain.data["lanes"][1]["shape"] == [{"x_m": 6.0, "y_m": 1.0}, {"x_m": 6.0, "y_m": 4.0}]
    odd = read(drawn_model(kind="BEZIER", points="140;x,y"))
    assert "a control point without a place" in said(odd)


@pytest.mark.parametrize(
    ("kind", "of"),
    [
        ('<property name="tcs:defaultLocationTypeSymbol" value="RECHARGE_GENERIC"/>', ""),
        ('<property name="tcs:defaultLocationTypeSymbol" value="ChargingStation20.png"/>', ""),
        ("", '<property name="tcs:defaultLocationSymbol" value="RECHARGE_ALT_1"/>'),
        ("", '<locationLayout locationRepresentation="RECHARGE_ALT_2"/>'),
        ('<allowedOperation name="Fill up"/>', ""),
    ],
)
def test_a_charger_is_known_by_any_symbol_and_by_the_operation_that_vehicles_name(kind: str, of: str) -> None:
    content = f"""<model version="0.0.2" name="hall">
    <point name="A" xPosition="0" yPosition="0"/><point name="B" xPosition="5000" yPosition="0"/>
    <vehicle name="V"><property name="loopback:rechargeOperation" value="Fill up"/></vehicle>
    <locationType name="T">{kind}</locationType>
    <location name="L" type="T"><link point="A"/>{of}</location>
    <location name="M" type="U"><link point="B"/></location></model>"""
    found = read(content.encode())
    assert [place["id"] for place in found.data["chargers"]] == ["L"]
    assert [place["id"] for place in found.data["unassigned"]] == ["M"]


@pytest.mark.parametrize(
    ("declared", "real", "said_of_it"),
    [
        ("UTF-8", "utf-8", ""),
        ("ISO-8859-1", "latin-1", ""),
        ("windows-1252", "cp1252", ""),
        ("windows-1250", "cp1250", ""),
        ("GB18030", "gb18030", ""),
        ("UTF-16", "utf-16", ""),
        ("UTF-16LE", "utf-16-le", ""),
        ("UTF-16", "utf-16-be", ""),
        ("utf-32", "utf-32", ""),
        ("ANSI", "cp1252", "encoding ANSI is not what it is in: read as windows-1252"),
        ("unicode", "utf-8", "encoding unicode is not what it is in: read as utf-8"),
        ("unicode", "utf-16", ""),
        ("UTF-8", "cp1252", "encoding UTF-8 is not what it is in: read as windows-1252"),
        ("UTF-16", "utf-8", "encoding UTF-16 is not what it is in: read as utf-8"),
        ("", "cp1252", "it does not say its encoding: read as windows-1252"),
    ],
)
def test_xml_is_read_in_any_encoding_or_says_which_was_taken(
    declared: str, real: str, said_of_it: str
) -> None:
    head = f'<?xml version="1.0" encoding="{declared}"?>' if declared else '<?xml version="1.0"?>'
    body = '<model version="7.0.0" name="h"><point name="Prüfplatz" positionX="0" positionY="0"/></model>'
    found = read(f"{head}\n{body}".encode(real))
    assert found.mapping["nodes"][0]["original"] == "Prüfplatz"
    told = [note.line() for note in found.notes if "encoding" in note.text]
    assert [line.startswith(f"line 1: {said_of_it}") for line in told] == ([True] if said_of_it else [])


def test_letters_that_nobody_can_tell_are_refused_with_what_to_do() -> None:
    with pytest.raises(PlantError, match="its letters are not in ANSI: save it as UTF-8"):
        read('<?xml version="1.0" encoding="ANSI"?><model name="Pr\u00fcfplatz"/>'.encode("cp850"))


def test_a_file_whose_text_somebody_else_has_read_may_name_any_encoding() -> None:
    text = '<?xml version="1.0" encoding="ANSI"?>' + drawn_model().decode().replace('"hall"', '"Prüfhalle"')
    assert read_layout(text, "hall.xml").data["name"] == "Prüfhalle"
    lost = read_layout(text.replace("ü", "\ufffd"), "hall.xml")
    assert "letters were lost before it came here" in said(lost)


def test_the_largest_vehicle_of_a_point_comes_into_the_plant() -> None:
    box = '<maxVehicleBoundingBox length="1200" width="800" height="1000" referenceOffsetX="{}" referenceOffsetY="0"/>'
    text = model().replace(b"<outgoingPath", box.format(0).encode() + b"<outgoingPath", 1)
    found = read(text)
    nodes = {node["id"]: node.get("max_vehicle") for node in found.data["nodes"]}
    assert nodes == {"Point-1": {"length_m": 1.2, "width_m": 0.8}, "Point-2": None, "Point-3": None}
    assert "BoundingBox" not in said(found)
    off = read(model().replace(b"<outgoingPath", box.format(100).encode() + b"<outgoingPath", 1))
    assert "<maxVehicleBoundingBox> is taken about the middle of vehicles" in said(off)
    none = read(
        model().replace(b"<outgoingPath", b'<maxVehicleBoundingBox length="0" width="a"/><outgoingPath', 1)
    )
    assert all("max_vehicle" not in node for node in none.data["nodes"])
    assert "<maxVehicleBoundingBox> without a length and a width is for all vehicles" in said(none)


# --- docs/layouts.md: from a layout to a served order ----------------------------------------------------

POINTS = {
    "P1": (2, 2), "P2": (12, 2), "P3": (22, 2), "P4": (22, 12), "P5": (12, 12), "P6": (2, 12),
    "S": (2, 7), "M": (22, 7), "G": (12, 7), "PK1": (7, 15), "PK2": (17, 15), "CH": (7, 0),
}  # fmt: skip

PATHS = "P1 P2, P2 P3, P4 P5, P5 P6, P1 S, S P6, P3 M, M P4, P2 G, G P5, P6 PK1, PK1 P5, P5 PK2, PK2 P4, P1 CH, CH P2"

LOCATIONS = {"Storage A": "S", "Press": "M", "Gate": "G", "Goods in": "P1"}


def hall() -> bytes:
    """The model of openTCS to which the document's sections belong."""
    points = "".join(
        f'<point name="{name}" positionX="{x * 1000}" positionY="{y * 1000}" '
        f'type="{"PARK" if name.startswith("PK") else "HALT"}_POSITION"/>'
        for name, (x, y) in POINTS.items()
    )
    paths = "".join(
        f'<path name="{start} --- {end}" sourcePoint="{start}" destinationPoint="{end}" maxVelocity="1000" '
        f'maxReverseVelocity="1000"/>'
        for start, end in (path.split() for path in PATHS.split(", "))
    )
    vehicles = "".join(f'<vehicle name="{name}" length="1200" maxVelocity="1000"/>' for name in ("V1", "V2"))
    locations = "".join(
        f'<location name="{name}" type="{kind}"><link point="{point}"/></location>'
        for name, point, kind in (
            *((name, point, "Transfer") for name, point in LOCATIONS.items()),
            ("Charger", "CH", "Charging"),
        )
    )
    kinds = (
        '<locationType name="Charging"><allowedOperation name="CHARGE"/></locationType>'
        '<locationType name="Transfer"><allowedOperation name="Load"/></locationType>'
    )
    return f'<model version="6.0.0" name="Hall">{points}{paths}{vehicles}{kinds}{locations}</model>'.encode()


def test_a_hall_of_opentcs_is_finished_with_the_sections_of_the_document_and_runs() -> None:
    data = read(hall()).data
    document = (Path(__file__).parents[3] / "docs/layouts.md").read_text(encoding="utf-8")
    [block] = re.findall(r"```yaml\n(materials:.*?)```", document, re.DOTALL)
    written = yaml.safe_load(block)
    assert {name for name in data if data[name] is None} == set(written)
    assert {each["node"] for each in data["unassigned"]} == set(LOCATIONS.values())
    data |= written
    data["unassigned"] = []
    data["chargers"][0]["box"] = {"x_m": 9, "y_m": 0.5, "width_m": 0.5, "depth_m": 0.5}
    [kind] = data["vehicle_types"]
    still_open = {name for name, value in kind.items() if value is None}
    assert still_open == {"width_m", "load_s", "unload_s", "battery_wh", "charge_w"}
    assert all(f"`{name}`" in document for name in still_open)
    kind.update(width_m=0.8, load_s=15, unload_s=15, battery_wh=500, charge_w=600)
    for vehicle, node in zip(data["fleet"], ("PK1", "PK2"), strict=True):
        vehicle["node"] = node
    plant = parse_plant(write_document(data), "hall.yaml")
    assert [each for each in advice(plant) if each.level == "error"] == []

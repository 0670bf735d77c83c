"""A plant as a picture: well-formed whatever its names are, with everything in it, and nothing beyond its edge."""

from __future__ import annotations

from xml.etree import ElementTree as ET

import pytest
from msgspec.structs import replace

from dray.plant import SHIPPED, Plant, default_plant, load_plant
from dray.plant.planning.drawing import KINDS, draw
from dray_sim.plants.draw import draw_plant

SVG = "{http://www.w3.org/2000/svg}"


def picture(plant: Plant) -> ET.Element:
    return ET.fromstring(draw(plant))


def texts(root: ET.Element) -> list[str]:
    return [each.text or "" for each in root.iter(f"{SVG}text")]


@pytest.mark.parametrize("name", SHIPPED)
def test_every_machine_storage_and_vehicle_of_a_shipped_plant_has_a_legible_label(name: str) -> None:
    plant = load_plant(name)
    shown = texts(picture(plant))
    wanted = {*plant.machines, *plant.storages, *plant.warehouses}
    assert wanted <= set(shown)
    missing = [atv for atv in plant.fleet if atv not in shown]
    assert len(missing) <= len(plant.fleet) // 10


def test_names_are_escaped() -> None:
    file = default_plant().file
    wild = replace(file, name="<script>alert('&')</script> \"x\" \x07\ufffe 工場")
    root = picture(Plant(wild))
    assert f"{wild.name[:30]}" in texts(root)[0]
    assert "\x07" not in draw(Plant(wild))
    assert not list(root.iter("script"))
    assert "工場" in texts(root)[0]


@pytest.mark.parametrize("seed", range(4))
def test_any_plant_can_be_drawn(seed: int) -> None:
    plant = draw_plant(seed)
    root = picture(plant)
    titles = [each.text or "" for each in root.iter(f"{SVG}title")]
    for place in (*plant.machines, *plant.storages, *plant.chargers):
        assert any(title.startswith(f"{place}:") for title in titles)
    assert draw(plant) == draw(plant)


def test_one_way_lanes_have_an_arrow_and_others_none() -> None:
    plant = load_plant("two-halls")
    paths = [each for each in picture(plant).iter(f"{SVG}path") if each.find(f"{SVG}title") is not None]
    arrows = [each for each in paths if each.get("marker-mid")]
    one_way = [lane for lane in plant.lanes if plant.roads.lane(lane.end, lane.start) is None]
    assert len(arrows) == len(one_way)
    assert len(paths) == len(one_way) + (len(plant.lanes) - len(one_way)) // 2


def test_no_label_stands_on_another() -> None:
    root = picture(default_plant())
    size = {float(each.get("font-size", "0")) for each in root.iter(f"{SVG}text")}
    assert min(size) >= default_plant().width_m / 120
    spots = [(each.get("x"), each.get("y")) for each in root.iter(f"{SVG}text")]
    assert len(set(spots)) == len(spots)


def test_the_legend_names_every_kind() -> None:
    assert {label for label, _, _ in KINDS.values()} <= set(texts(picture(default_plant())))


def test_a_road_of_two_lanes_is_drawn_with_its_stop_points_and_crossings() -> None:
    picture = draw(default_plant())
    assert "<title>b2.from-a2</title>" in picture
    assert "over crossing b2" in picture
    assert "over crossing" not in draw(load_plant("single-track"))

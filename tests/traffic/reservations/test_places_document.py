"""What `dray plant json --places` writes is what agents go by."""

from __future__ import annotations

import json

import pytest
from typer.testing import CliRunner

from dray.cli import app
from dray.plant import Plant, default_plant, load_plant
from dray.protocol.traffic.places import Places
from dray.protocol.traffic.places_document import places_document


@pytest.mark.parametrize(
    "plant", [load_plant("single-track"), default_plant()], ids=["single track", "two lanes"]
)
def test_it_has_every_place_and_every_lane_as_agents_have_them(plant: Plant) -> None:
    places, document = Places(plant), places_document(plant)
    assert {
        place: each.district for each in document.districts for place in each.places
    } == places.district_of
    assert {each.district: each.replicas for each in document.districts} == places.replicas_of
    assert len(document.lanes) == len(plant.roads.lanes)
    assert all(lane.needs == places.needs(lane.start, lane.end) for lane in document.lanes)
    assert all(places.place_of(node) == place for node, place in document.crossed.items())
    assert bool(document.crossed) == bool(plant.crossings)


def test_the_command_writes_it_as_json() -> None:
    done = CliRunner().invoke(app, ["plant", "json", "--places"])
    assert done.exit_code == 0
    told = json.loads(done.stdout)
    assert set(told) == {"districts", "lanes", "dock_entries", "dead_ends", "crossed"}
    plant = default_plant()
    kept = {place for each in told["districts"] for place in each["places"]}
    assert kept == {*plant.stops, *plant.crossings}

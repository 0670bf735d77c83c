"""A machine that the plant file does not know: panels have it by its own word, where they have its kind."""

from __future__ import annotations

from typing import Any

import pytest
from fake_bus import PLANT
from gateway_kit import gateway
from joining_kit import BEFORE, SPEC, introduction
from wall_clock import NOW_S

from dray.gateway.http.provided import provided
from dray.gateway.live.joinings import Joinings
from dray.gateway.live.projection import Projection
from dray.gateway.live.projection import site as site_module
from dray.gateway.live.timescale import TimeScale
from dray.gateway.live.visibility import AreaVisibility, visibility_of
from dray.plant import Plant

AREA = next(iter(Plant(PLANT).areas_at(*Plant(PLANT).position_of(SPEC.id))))


@pytest.fixture
def projection() -> Projection:
    return Projection(BEFORE, TimeScale(0.0, NOW_S))


def test_a_joining_machine_stands_where_it_says(projection: Projection) -> None:
    projection.fold(introduction())
    assert projection.site.plant.machines[SPEC.id] == SPEC
    view = projection.machines.view(SPEC.id)
    assert view is not None
    assert view.name == SPEC.name


def test_operators_of_its_area_see_a_joining_machine_that_comes_while_they_look(
    projection: Projection,
) -> None:
    here, elsewhere = (
        AreaVisibility(projection, frozenset(areas))
        for areas in ({AREA}, {each.id for each in PLANT.areas} - {AREA})
    )
    assert not here.has(SPEC.id)
    projection.fold(introduction())
    view = projection.machines.view(SPEC.id)
    assert view is not None
    assert (here.has(SPEC.id), elsewhere.has(SPEC.id)) == (True, False)
    assert here.machine(view) is not None
    assert elsewhere.machine(view) is None
    assert SPEC in here.plant().machines
    assert SPEC in visibility_of(projection, None).plant().machines


@pytest.mark.parametrize("wrong", [{"node": "nowhere"}, {"station": "nobody's"}, {"makes": ()}])
def test_a_joining_machine_that_does_not_fit_is_seen_and_stands_nowhere(
    projection: Projection, wrong: dict[str, Any]
) -> None:
    before = projection.site.plant
    projection.fold(introduction(**wrong))
    assert projection.site.plant is before
    assert projection.machines.view(SPEC.id) is not None


def test_what_a_machine_says_of_itself_later_moves_nothing(projection: Projection) -> None:
    projection.fold(introduction())
    projection.fold(introduction(seq=2, node="c3"))
    assert projection.site.plant.machines[SPEC.id] == SPEC


def test_a_peer_that_invents_machines_ends_somewhere(
    projection: Projection, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(site_module, "JOINING_MACHINES_MAX", 2)
    for number in range(3):
        projection.fold(introduction(f"X{number}", node="nowhere"))
    projection.fold(introduction())
    assert SPEC.id not in projection.site.plant.machines


@pytest.mark.anyio
async def test_the_plant_over_rest_has_the_joining_machine_and_so_has_a_preview(url: str) -> None:
    async with gateway(url, plant=BEFORE) as house:
        client = house.client
        house.bus.say(introduction())
        await provided(house.app, Joinings).waiting.join()
        file = (await client.get("/api/plant")).json()
        assert SPEC.id in {machine["id"] for machine in file["machines"]}
        items = [{"product": SPEC.makes[0].product, "quantity": 1}]
        needs = (await client.post("/api/orders/preview", json={"items": items})).json()
        assert SPEC.id in {offer["machine"] for offer in needs["machines"]}

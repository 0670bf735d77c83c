"""A plant as small as one can be, and a way to break it."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from dray.errors import PlantError, PlantErrors
from dray.plant import parse_plant

SMALL = """\
plant: small
name: Small plant
width_m: 40
height_m: 30
nodes:
  - {id: west, x_m: 5, y_m: 10}
  - {id: middle, x_m: 20, y_m: 10}
  - {id: east, x_m: 35, y_m: 10}
  - {id: north, x_m: 20, y_m: 25}
  - {id: south, x_m: 20, y_m: 2}
lanes:
  - {start: west, end: middle, both_ways: true}
  - {start: middle, end: east, both_ways: true}
  - {start: middle, end: north, both_ways: true}
  - {start: middle, end: south, speed_limit_mps: 0.8, both_ways: true}
materials:
  - {id: shaft, name: Shaft, lot: 20, buffer: 60}
products:
  - {id: gear, name: Gear, lot: 10, bill: [{material: shaft, quantity: 2}]}
warehouses:
  - {id: SOURCE, name: Source, kind: source, node: west, box: {x_m: 4, y_m: 14, width_m: 4, depth_m: 4}}
  - {id: DELIVERY, name: Delivery, kind: delivery, node: east, box: {x_m: 36, y_m: 14, width_m: 4, depth_m: 4}}
storages:
  - id: S1
    name: Storage
    node: south
    box: {x_m: 24, y_m: 2, width_m: 3, depth_m: 2}
    stocks: [{material: shaft, capacity: 100}]
chargers:
  - {id: CH1, node: west, box: {x_m: 5, y_m: 5, width_m: 2, depth_m: 2}}
parkings:
  - {id: P1, node: middle}
stations:
  - {id: WS1, name: Turning}
machines:
  - id: M1
    name: Lathe
    station: WS1
    node: north
    box: {x_m: 26, y_m: 25, width_m: 5, depth_m: 3}
    makes: [{product: gear, cycle_s: 30}]
areas:
  - id: FLOOR
    name: The floor
    polygon: [{x_m: 0, y_m: 0}, {x_m: 40, y_m: 0}, {x_m: 40, y_m: 30}, {x_m: 0, y_m: 30}]
vehicle_types:
  - {id: light, name: Light carrier}
fleet:
  - {id: ATV1, type: light, node: middle}
"""

Break = Callable[..., list[tuple[str, str]]]


@pytest.fixture
def small_text() -> str:
    """The text of a plant without faults."""
    return SMALL


@pytest.fixture(scope="session")
def small_text_once() -> str:
    """The same for tests that draw many examples."""
    return SMALL


@pytest.fixture
def broken() -> Break:
    """Replace pieces of the small plant; the faults that follow, as (field, reason) in file order."""

    def break_it(*changes: tuple[str, str]) -> list[tuple[str, str]]:
        text = SMALL
        for old, new in changes:
            assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times in the small plant"
            text = text.replace(old, new)
        with pytest.raises(PlantError) as raised:
            parse_plant(text, "small.yaml")
        error = raised.value
        errors = error.errors if isinstance(error, PlantErrors) else (error,)
        return [(single.field, single.reason) for single in errors]

    return break_it

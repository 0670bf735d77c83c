"""How material comes to storages and machines, as a plant file says it: what fits together, and what does not."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from dray.plant import parse_plant

Break = Callable[..., list[tuple[str, str]]]

STOCK = "stocks: [{material: shaft, capacity: 100}]"
SOURCE = "kind: source, node: west,"
STOCKED = (SOURCE, f"{SOURCE} stocks: [{{material: shaft, capacity: 400}}],")


def refilled(text: str) -> tuple[str, str]:
    """Vehicles refill the storage, with more said of its stock."""
    return STOCK, f"refill: vehicles\n    stocks: [{{material: shaft, capacity: 100{text}}}]"


def test_a_warehouse_with_stocks_has_a_station_and_is_where_refills_come_from(small_text: str) -> None:
    plant = parse_plant(small_text.replace(*STOCKED).replace(*refilled("")), "small.yaml")
    assert tuple(plant.stores) == ("S1", "SOURCE")
    assert plant.supplies_of("shaft") == ("SOURCE",)
    assert plant.storages_of("shaft") == ("S1",)
    assert plant.keepers_of("shaft") == ("S1", "SOURCE", "M1")


def test_a_warehouse_without_stocks_is_as_before(small_text: str) -> None:
    plant = parse_plant(small_text, "small.yaml")
    assert tuple(plant.stores) == ("S1",)
    assert (plant.supplies_of("shaft"), plant.keepers_of("shaft")) == ((), ("S1", "M1"))


def test_a_plant_without_storages_has_machines_fetch_in_the_warehouse(small_text: str) -> None:
    text = small_text.replace(SOURCE, f"{STOCKED[1]} direct: true,")
    begin, end = text.index("storages:"), text.index("chargers:")
    plant = parse_plant(f"{text[:begin]}storages: []\n{text[end:]}", "small.yaml")
    assert plant.storages_of("shaft") == ("SOURCE",)


FAULTS = {
    "a reorder point above the capacity": (
        (STOCKED, refilled(", reorder_point: 120")),
        "storages[0].stocks[0].reorder_point",
        "above 120 there is no room for 20 more, of 100: lower it to 80 at most",
    ),
    "a reorder point above which no lot finds room": (
        (STOCKED, refilled(", reorder_point: 91, lot: 10")),
        "storages[0].stocks[0].reorder_point",
        "lower it to 90 at most",
    ),
    "a lot that no vehicle carries": (
        (STOCKED, refilled(", lot: 21")),
        "storages[0].stocks[0].lot",
        "21 pieces are more than a vehicle brings at once: a container holds 20",
    ),
    "a refill that comes from nowhere": (
        (refilled(""),),
        "storages[0].stocks[0].material",
        "no source warehouse has shaft",
    ),
    "a reorder point of a storage that fills itself": (
        ((STOCK, "stocks: [{material: shaft, capacity: 100, reorder_point: 20}]"),),
        "storages[0].stocks[0].reorder_point",
        "for materials of a storage with `refill: vehicles` only",
    ),
    "a warehouse that machines use, with nothing there": (
        ((SOURCE, f"{SOURCE} direct: true,"),),
        "warehouses[0].direct",
        "SOURCE has no `stocks`",
    ),
    "stocks where products go to": (
        (("kind: delivery,", "kind: delivery, stocks: [{material: shaft, capacity: 100}],"),),
        "warehouses[1].stocks",
        "leave it out",
    ),
    "less than a lot in a warehouse": (
        ((SOURCE, f"{SOURCE} stocks: [{{material: shaft, capacity: 19}}],"),),
        "warehouses[0].stocks[0].capacity",
        "19 pieces are less than a lot of 20",
    ),
    "a misspelt material in a warehouse": (
        ((SOURCE, f"{SOURCE} stocks: [{{material: shafd, capacity: 90}}],"),),
        "warehouses[0].stocks[0].material",
        "did you mean shaft?",
    ),
}


@pytest.mark.parametrize(("changes", "field", "reason"), FAULTS.values(), ids=FAULTS)
def test_what_does_not_fit_together_is_named(
    broken: Break, changes: tuple[tuple[str, str], ...], field: str, reason: str
) -> None:
    found = broken(*changes)
    assert field in [name for name, _ in found]
    assert reason in dict(found)[field]

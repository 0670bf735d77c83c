"""Bills of several levels in a plant file: what a part is, and what cannot be."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec
import pytest

from dray.plant import Plant
from dray.plant.file.check import faults
from dray.plant.file.check_levels import chain_told, circle_of, levels_of
from dray.plant.file.file import shipped_plant, sum_up
from dray.plant.model import BillLine, PlantFile, Product

FILE = shipped_plant("levels").file


def changed(product: str, **fields: Any) -> PlantFile:
    """The shipped plant with one product otherwise."""
    products = tuple(
        msgspec.structs.replace(each, **fields) if each.id == product else each for each in FILE.products
    )
    return msgspec.structs.replace(FILE, products=products)


def told(file: PlantFile) -> str:
    return "; ".join(reason for _, reason in faults(file))


def test_a_part_is_a_material_of_other_products_and_a_product_of_its_machines() -> None:
    plant = Plant(FILE)
    assert set(plant.parts) == {"shaft", "gear", "gear-set"}
    assert plant.ordered == ("gearbox", "winch")
    assert plant.materials["shaft"].buffer == plant.products["shaft"].buffer
    users = {machine for machine in plant.machines if "shaft" in plant.materials_of(machine)}
    assert users == {"PRESS1", "PRESS2", "ASSEMBLY1", "ASSEMBLY2"}
    assert plant.machines_for("shaft") == ("LATHE1", "LATHE2")


def test_a_plant_says_how_many_levels_it_has() -> None:
    assert levels_of(FILE) == 3
    assert "3 of them parts, on 3 levels" in sum_up(Plant(FILE))
    assert "levels" not in sum_up(shipped_plant("default"))


def test_a_circle_is_refused_with_all_that_is_in_it() -> None:
    round_about = (BillLine("bar", 1), BillLine("gear-set", 1))
    assert "is made of itself: shaft <- gear-set <- shaft" in told(changed("shaft", bill=round_about))


def test_a_circle_is_told_once() -> None:
    round_about = (BillLine("bar", 1), BillLine("gear-set", 1))
    assert told(changed("shaft", bill=round_about)).count("made of itself") == 1


def test_an_unknown_part_is_refused_by_name() -> None:
    assert "there is no geer in `materials`: did you mean gear?" in told(
        changed("gear-set", bill=(BillLine("geer", 2),))
    )


def test_a_product_without_a_buffer_is_in_no_bill() -> None:
    assert "gearbox is a product without a `buffer`" in told(
        changed("winch", bill=(BillLine("gearbox", 1), BillLine("drum", 1)))
    )


def test_a_part_that_nobody_makes_is_refused_with_what_it_is_needed_for() -> None:
    machines = tuple(each for each in FILE.machines if not each.id.startswith("PRESS"))
    file = msgspec.structs.replace(FILE, machines=machines)
    assert "no machine makes gear-set: add it to the `makes` of one (needed for gearbox <- gear-set)" in told(
        file
    )


def test_a_part_that_no_storage_keeps_is_refused_with_what_it_is_needed_for() -> None:
    storages = tuple(
        msgspec.structs.replace(
            each, stocks=tuple(stock for stock in each.stocks if stock.material != "gear")
        )
        for each in FILE.storages
    )
    file = msgspec.structs.replace(FILE, storages=storages)
    assert "no storage keeps gear" in told(file)
    assert "(needed for gearbox <- gear-set <- gear)" in told(file)


def test_a_part_that_no_vehicle_carries_is_refused_with_what_it_is_needed_for() -> None:
    reason = (
        "no vehicle of the fleet can carry crate: gear-set would never move (needed for gearbox <- gear-set)"
    )
    assert reason in told(changed("gear-set", ability="crate"))


def test_a_machine_does_not_use_what_it_makes() -> None:
    machines = tuple(
        msgspec.structs.replace(each, makes=(*each.makes, *FILE.machines[5].makes))
        if each.id == "LATHE1"
        else each
        for each in FILE.machines
    )
    file = msgspec.structs.replace(FILE, machines=machines)
    assert "LATHE1 makes shaft, of which gear-set is made" in told(file)


@pytest.mark.parametrize("length", [3, 8, 30])
def test_a_chain_is_told_with_its_ends(length: int) -> None:
    way = [f"p{number}" for number in range(length)]
    assert chain_told(way).startswith("p0 <- p1")
    assert chain_told(way).endswith(f"<- p{length - 1}")
    assert chain_told(way).count("<-") < 8


def test_a_way_down_that_comes_to_no_end_is_no_circle_of_what_is_above_it() -> None:
    def made_of(*parts: str) -> tuple[BillLine, ...]:
        return tuple(BillLine(part, 1) for part in parts)

    products: Mapping[str, Product] = {
        name: Product(name, name, 1, made_of(*parts))
        for name, parts in {"top": ("left", "right"), "left": ("right",), "right": ("left",)}.items()
    }
    assert circle_of("top", products) == ()
    assert circle_of("left", products) == ("left", "right", "left")

"""The verdict on a run names what was short: the workshop, made so that one thing is.

Each plant is the shipped workshop with one thing taken away or made slow; the cause is known, so the verdict can be wrong.
"""

from __future__ import annotations

import msgspec
import pytest
from msgspec.structs import replace
from variants import in_campaigns

from dray.plant import Making, Plant, PlantFile, Stock, VehicleSpec, shipped_plant
from dray_sim.run.evidence import HELD
from dray_sim.run.report import Report
from dray_sim.run.stage import Shift, play
from dray_sim.run.verdict import NOTHING

HOURS = 1.5


def quick(file: PlantFile, frac: float) -> PlantFile:
    """Machines that take so much less for a piece, and have room for what they make."""
    return replace(
        file,
        machines=tuple(
            replace(
                machine,
                makes=tuple(Making(each.product, each.cycle_s * frac) for each in machine.makes),
                goods_capacity=60,
            )
            for machine in file.machines
        ),
    )


def vehicles(file: PlantFile, count: int, battery_frac: float = 0.9, **figures: float) -> PlantFile:
    """So many of them, made so."""
    return replace(
        file,
        vehicle_types=tuple(replace(kind, **figures) for kind in file.vehicle_types),
        fleet=tuple(
            VehicleSpec(f"CART{number}", "cart", node.id, battery_frac)
            for number, node in enumerate(file.nodes[:count], 1)
        ),
    )


def boards(file: PlantFile, lot: int, buffer: int) -> PlantFile:
    """In containers and buffers of this size."""
    return replace(
        file,
        materials=tuple(
            replace(each, lot=lot, buffer=buffer) if each.id == "board" else each for each in file.materials
        ),
    )


def stocked(file: PlantFile, capacity: int) -> PlantFile:
    """The rack holds so many boards."""
    return replace(
        file,
        storages=tuple(
            replace(
                storage,
                stocks=tuple(
                    Stock("board", capacity) if stock.material == "board" else stock
                    for stock in storage.stocks
                ),
            )
            for storage in file.storages
        ),
    )


WORKSHOP = shipped_plant("workshop").file

SHORT = {
    "machine": (WORKSHOP, 1.8),
    "vehicles": (vehicles(quick(WORKSHOP, 0.25), 1), 0.8),
    "charger": (
        vehicles(quick(WORKSHOP, 0.5), 4, 0.5, battery_wh=60.0, idle_w=60.0, charge_w=150.0),
        0.7,
    ),
    "material": (stocked(boards(WORKSHOP, 4, 36), 4), 0.8),
    "buffer": (vehicles(boards(quick(WORKSHOP, 0.2), 4, 8), 9), 0.7),
    "dock": (vehicles(quick(WORKSHOP, 0.5), 12, unload_s=150.0), 0.7),
}
"""What is short, the plant, and the load."""


def played(file: PlantFile, load: float, hours: float = HOURS) -> Report:
    report = play(Shift(name="short", duration_s=hours * 3600.0, load=load), Plant(file), 1).report
    assert report.invariants == HELD
    return report


@pytest.mark.parametrize("kind", in_campaigns(SHORT, "vehicles", "charger", "dock"))
def test_the_verdict_names_what_was_short(kind: str) -> None:
    verdict = played(*SHORT[kind]).verdict
    assert verdict.bottleneck == kind, "\n".join(verdict.lines())
    assert "%" in verdict.text


@pytest.mark.slow
def test_where_nothing_is_short_the_verdict_says_so() -> None:
    report = played(WORKSHOP, 0.4)
    assert report.verdict.bottleneck == NOTHING
    assert report.verdict.text.startswith("nothing is short")
    assert (report.verdict.overloaded_frac, report.verdict.overloaded_waiting) == (0.0, 0)
    assert "overloaded" not in report.describe()
    assert any(each.kind == "machine" and 0.0 < each.busy_frac < 0.85 for each in report.verdict.resources)


@pytest.mark.slow
def test_the_material_is_named_and_where_it_is_kept() -> None:
    verdict = played(*SHORT["material"], hours=1.0).verdict
    assert verdict.name == "board"
    assert "RACK 4" in verdict.text


def test_a_report_has_the_verdict_as_data_and_in_words() -> None:
    report = played(WORKSHOP, 0.4, hours=0.5)
    data = msgspec.json.decode(msgspec.json.encode(report))
    assert data["verdict"]["bottleneck"] == NOTHING
    assert {"kind", "name", "busy_frac", "waiting_frac", "lost_frac"} <= data["verdict"]["resources"][
        0
    ].keys()
    assert report.verdict.text in report.describe()

"""The benchmarks of the panels measure something: with few vehicles, and for a moment only."""

from __future__ import annotations

import pytest

from dray_sim.bench.panels import paint
from dray_sim.bench.panels import plant_map as plantmap


@pytest.mark.campaign
def test_the_map_is_measured_far_and_near_beside_its_baselines(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in (("VEHICLES", (30, 40)), ("QUICK_SPAN_S", 0.5), ("SETTLED_S", 0.5)):
        monkeypatch.setattr(plantmap, name, value)
    rows = plantmap.measure(quick=True)
    assert [row.name.removeprefix("map: ") for row in rows] == [
        f"{what}, {vehicles} vehicles, {view}"
        for vehicles in (30, 40)
        for view in ("whole plant", "near")
        for what in ("script per picture", "from picture to picture, p95")
    ]
    assert all(row.figure > 0.0 and row.baseline > 0.0 and row.less for row in rows)


@pytest.mark.campaign
def test_the_first_paint_of_each_page_is_measured_beside_the_plainest_page(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(paint, "QUICK_TIMES", 1)
    rows = paint.measure(quick=True)
    pages = ("management panel", "operator panel", "login page", "customer page")
    lines = ("first live picture at 1.6 Mbit/s", "first live picture at 400 kbit/s")
    assert [row.name for row in rows] == [f"paint: {what}" for what in (*pages, *lines)]
    assert all(row.figure > 0.0 and row.baseline > 0.0 and row.less for row in rows)

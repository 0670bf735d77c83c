"""The benchmarks of the panels measure something: with few vehicles, and for a moment only."""

from __future__ import annotations

import pytest

from dray_sim.bench.panels import paint
from dray_sim.bench.panels import plant_map as plantmap


@pytest.mark.slow
def test_the_map_is_measured_far_and_near_beside_its_baselines(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in (("VEHICLES", 30), ("QUICK_SPAN_S", 0.5), ("SETTLED_S", 0.5)):
        monkeypatch.setattr(plantmap, name, value)
    rows = plantmap.measure(quick=True)
    assert [row.name.removeprefix("map: ") for row in rows] == [
        "script per picture, whole plant",
        "from picture to picture, p95, whole plant",
        "script per picture, near",
        "from picture to picture, p95, near",
    ]
    assert all(row.figure > 0.0 and row.baseline > 0.0 and row.less for row in rows)


@pytest.mark.slow
def test_the_first_paint_of_each_page_is_measured_beside_the_plainest_page(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(paint, "QUICK_TIMES", 1)
    rows = paint.measure(quick=True)
    assert [row.name for row in rows] == [
        f"paint: {page}" for page in ("management panel", "operator panel", "login page", "customer page")
    ]
    assert all(row.figure > 0.0 and row.baseline > 0.0 and row.less for row in rows)

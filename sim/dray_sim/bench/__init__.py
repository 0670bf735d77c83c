"""Benchmarks: every figure stands beside a baseline measured in the same run.

Rates differ between machines and from minute to minute, so only the ratio to a stated baseline can be compared. A
benchmark is a function `measure(quick) -> list[Row]`, registered in `BENCHES` under the name that `dray bench NAME`
knows.
"""

from __future__ import annotations

import json
import platform
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from dray_sim.bench import fleet, history, losses, orders, rest_work, sim, stop, wired
from dray_sim.bench.network import bus, links, zenoh
from dray_sim.bench.panels import paint, plant_map, projection, replay, stream
from dray_sim.bench.row import Row, rates
from dray_sim.bench.traffic import measure as traffic
from dray_sim.bench.vda5050 import measure as vda5050

__all__ = ["BENCHES", "DRIVEN", "LONG", "Bench", "Row", "as_json", "rates"]

Bench = Callable[[bool], list[Row]]
"""Measures; True means quick: a tenth of the work, for a look and for tests."""


BENCHES: dict[str, Bench] = {
    "bus": bus.measure,
    "projection": projection.measure,
    "sim": sim.measure,
    "stream": stream.measure,
    "map": plant_map.measure,
    "paint": paint.measure,
    "zenoh": zenoh.measure,
    "fleet": fleet.measure,
    "links": links.measure,
    "orders": orders.measure,
    "history": history.measure,
    "replay": replay.measure,
    "losses": losses.measure,
    "calls": losses.measure_calls,
    "stop": stop.measure,
    "traffic": traffic.measure,
    "vda5050": vda5050.measure,
    "wired": wired.measure,
    "work": rest_work.measure,
}
"""Name -> benchmark, in the order in which they run."""

DRIVEN: dict[str, Callable[..., list[Row]]] = {
    "sim": sim.measure,
    "fleet": fleet.measure,
    "losses": losses.measure,
    "calls": losses.measure_calls,
    "work": rest_work.measure,
}
"""Benchmarks of a whole factory, whose vehicles can drive with right of way or without (`traffic`). `wired` has it
always, `traffic` compares."""

LONG = frozenset({"calls", "history", "losses", "replay", "stop", "traffic", "wired", "work"})
"""Benchmarks that take some minutes or more, or all of the computer; they run only when asked for by name."""


def as_json(rows: list[Row]) -> str:
    """The rows and the machine that they were measured on, as a JSON document."""
    document: dict[str, Any] = {
        "python": platform.python_version(),
        "machine": platform.machine(),
        "rows": [{**asdict(row), "ratio": row.ratio, "met": row.met} for row in rows],
    }
    return json.dumps(document, indent=2)

"""Runs of fleets that take no time, for tests of what is made of them."""

from __future__ import annotations

from dray_sim.plants.fleet_sizes import Asked, FleetRun
from dray_sim.run.evidence import HELD


def fleet_run(asked: Asked, transports: int, most: int = 9) -> FleetRun:
    """The run that was asked for, with so many transports; its floor bears `most` vehicles."""
    return FleetRun(
        seed=asked.seed,
        floor=asked.floor.name,
        vehicles=asked.vehicles,
        hours=asked.hours,
        traffic=asked.traffic,
        places=24,
        transports=transports,
        pieces=80,
        p50_s=160.0,
        p95_s=400.0,
        starvation_frac=0.3,
        invariants=HELD,
        most=most,
    )

"""A run in which the central planner grants the ways."""

from __future__ import annotations

from dray.protocol.traffic.places import Footprint, Places
from dray_sim.bench.traffic.air import Air
from dray_sim.bench.traffic.checks import Checks
from dray_sim.bench.traffic.clock import LeanClock
from dray_sim.bench.traffic.planner import CentralPilot, Planner
from dray_sim.bench.traffic.run import Figures, Setting, carriers_of, figures


def run_central(setting: Setting) -> Figures:
    """The planner's figures."""
    clock = LeanClock()
    carriers = carriers_of(setting, clock)
    footprint = Footprint()
    places = Places(setting.plant, footprint)
    places.dock_entries = places.dead_ends = {}
    planner = Planner(setting.plant, places, clock)
    for carrier in carriers:
        pilot = CentralPilot(carrier, planner)
        carrier.pilot = pilot
        planner.pilots[carrier.atv] = pilot
    planner.start()
    checks = Checks(carriers, {}, {}, places, Air(clock, setting.quality, 0), footprint, clock)
    checks.start()
    clock.run(setting.span_s)
    return figures(setting, carriers, checks.found)

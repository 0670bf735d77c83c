"""Whoever holds the places of its way has room for it: bodies with their real size, and one who gives places out.

The warden knows everything and gives a group of places to one vehicle at a time, up to the next stop; what lies behind is free when the
vehicle has come to that stop. It is no protocol (it gets stuck, and then sends everybody elsewhere), but whatever protocol gives places
out one by one, vehicles must not touch: that is asked of the floor here, and judged by geometry.
"""

from __future__ import annotations

import asyncio
from itertools import pairwise
from random import Random

import pytest

from dray.body import Drive, NodePassed, ReleaseWay, Report, WayDone
from dray.plant import Plant, default_plant, load_plant
from dray.plant import layout as layout_module
from dray_sim.bodies.floor import Floor
from dray_sim.bodies.vehicle.vehicle import SimVehicle
from dray_sim.checks.floor.overlaps import Overlaps
from dray_sim.clock.loop import JUMP, clock, run
from dray_sim.plants.generator import generate_plant

STANDS_S = 3.0
"""At a goal, and before another way is tried."""

LOOK_S = 1.0


class Warden:
    """Gives places out."""

    def __init__(self, plant: Plant, floor: Floor, seed: int) -> None:
        self._plant, self._floor = plant, floor
        self._random = Random(f"{seed} warden")
        self._holder = {spec.node: spec.id for spec in plant.fleet.values()}
        self._ways: dict[str, tuple[str, ...]] = {}
        self._at: dict[str, int] = {}
        self._granted: dict[str, int] = {}
        self._orders: dict[str, int] = {}
        self._order = 0
        self.passed = 0
        for vehicle in floor.vehicles.values():
            vehicle.attach(lambda report, vehicle=vehicle: self._on_report(vehicle, report))
            self._ways[vehicle.id] = (vehicle.sense().node,)
            self._at[vehicle.id] = self._granted[vehicle.id] = 0

    async def keep(self, until_s: float) -> None:
        """Go on for so long."""
        for _ in range(int(until_s / LOOK_S)):
            for vehicle in self._floor.vehicles.values():
                if self._granted[vehicle.id] > self._at[vehicle.id] or vehicle.sense().speed_mps:
                    continue
                if not self._grant(vehicle) and self._random.random() < LOOK_S / STANDS_S:
                    self._send(vehicle)
            await asyncio.sleep(LOOK_S)

    def _send(self, vehicle: SimVehicle) -> None:
        """To some place, by the way that its type takes."""
        plant, here = self._plant, vehicle.sense().node
        goal = plant.node_of(self._random.choice(tuple(plant.places)))
        if goal == here:
            return
        vehicle.replace_battery()
        way = plant.routes(plant.fleet[vehicle.id].type).way(here, goal).nodes
        self._ways[vehicle.id], self._at[vehicle.id], self._granted[vehicle.id] = way, 0, 0
        self._order += 1
        self._orders[vehicle.id] = self._order
        vehicle.instruct(Drive(order=self._order, nodes=way, released=1))
        self._grant(vehicle)

    def _grant(self, vehicle: SimVehicle) -> bool:
        """All places up to the next stop, or none."""
        way, first = self._ways[vehicle.id], self._granted[vehicle.id]
        group: list[str] = []
        index = first
        for lane in pairwise(way[first:]):
            index += 1
            group += self._plant.places_on(*lane)
            if lane[1] in self._plant.stops:
                break
        else:
            return False
        if any(self._holder.get(place, vehicle.id) != vehicle.id for place in group):
            return False
        self._holder.update(dict.fromkeys(group, vehicle.id))
        self._granted[vehicle.id] = index
        vehicle.instruct(ReleaseWay(order=self._orders[vehicle.id], released=index + 1))
        return True

    def _on_report(self, vehicle: SimVehicle, report: Report) -> None:
        if not isinstance(report, NodePassed | WayDone) or report.order != self._orders[vehicle.id]:
            return
        if isinstance(report, NodePassed) and report.index:
            self.passed += 1
            self._at[vehicle.id] = report.index
            if report.node in self._plant.stops:
                self._free_behind(vehicle.id)
                self._grant(vehicle)

    def _free_behind(self, name: str) -> None:
        way, here = self._ways[name], self._at[name]
        ahead = {
            place
            for lane in pairwise(way[here : self._granted[name] + 1])
            for place in self._plant.places_on(*lane)
        }
        for place in [place for place, holder in self._holder.items() if holder == name]:
            if place != way[here] and place not in ahead:
                del self._holder[place]


def watched(plant: Plant, seed: int, until_s: float) -> tuple[Overlaps, int]:
    """What the judge has seen, and how many nodes were passed."""

    async def play() -> tuple[Overlaps, int]:
        floor = Floor(plant, clock(), seed=seed)
        overlaps = Overlaps(floor.vehicles, strict=False)
        warden = Warden(plant, floor, seed)
        await warden.keep(until_s)
        overlaps.check_end(until_s)
        return overlaps, warden.passed

    return run(play(), JUMP)


PLANTS = {
    "two lanes": default_plant(),
    "single track": load_plant("single-track"),
    "generated": generate_plant(1, 6, 12),
    "generated, single track": generate_plant(1, 6, 12, two_lanes=False),
}


@pytest.mark.parametrize("plant", PLANTS.values(), ids=PLANTS)
def test_who_holds_the_places_of_its_way_touches_nobody(plant: Plant) -> None:
    overlaps, passed = watched(plant, 1, 1200.0)
    assert passed > 300
    assert str(overlaps.first) == "None"
    assert overlaps.count == 0


def test_stop_points_too_near_to_a_crossing_are_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    """The check can fail: half a metre less, and vehicles touch although nobody holds what another one holds."""
    file = PLANTS["generated"].file
    monkeypatch.setattr(layout_module, "MARGIN_M", -0.3)
    overlaps, _ = watched(Plant(file), 1, 1200.0)
    assert overlaps.count > 0

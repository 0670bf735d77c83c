"""The battery that a vehicle needs to reach a charger and to wait there for others: pure arithmetic over a plant file.

    needed    = way * Wh per metre + max(RESERVE_FRAC, SPARE_FRAC + detour + draw * (way + held up + wait))
    wait      = the longest sessions of as many as are ahead, or those of all others / chargers if that is less; each with a changeover
    ahead     = vehicles / chargers, rounded up, without the vehicle itself
    session   = a charge from SPARE_FRAC up to `enough`
    enough    = what is needed at the charger itself, and WORTH_FRAC more
    detour    = from the charger to a waiting place and back
    changeover = LOOKS_AGAIN_S, and the way of the detour

`draw` is the power of computers and sensors, moving or not. The wait depends on the session, and the session on the
wait, so both are computed in turns until they no longer change. If they do not converge, the waiting vehicles use
more than the chargers give meanwhile, and the plant file is refused.

It is the worst case: all vehicles come to the chargers at once, and each has one session before the next one plugs in.
`dray.protocol.vehicle` works by these figures, and `dray plant check` (`dray.plant.planning.power`) checks them.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import ceil, log
from typing import TYPE_CHECKING

from dray.errors import NoWay
from dray.plant.model import VehicleType
from dray.plant.restrictions import OPEN

if TYPE_CHECKING:
    from dray.plant.plant import Plant

RESERVE_FRAC = 0.10
"""Battery that no promise may touch: ways around obstacles, a short wait for a charger, and ageing."""

SPARE_FRAC = 0.05
"""Remainder of the reserve for obstacles and ageing where the wait is computed separately."""

WORTH_FRAC = 0.15
"""The least charge that is worth the way to a charger. A charger is left to a vehicle that is emptier by as much, since both
drive for it."""

LOOKS_AGAIN_S = 65.0
"""The longest time until a waiting vehicle asks for the charger again: `TAKEN_MEMORY_S` and the contest that follows, rounded up."""

CHANGEOVER_S = 6.0
"""Time from one vehicle at a dock to the next: the answer that the dock is open, and the way into it."""

DOCKS_OF_A_TASK = 2

LEFT_AT_FULL = 0.1
"""The part of the full charging power that is left when the battery is full (`VehicleType.charge_w`)."""

CHARGERS_LOOKED_AT = 24
"""Chargers whose waiting places are looked for, evenly among all: those of a large plant are much alike."""

TURNS = 200
"""Most turns until wait and session converge: each comes nearer by a constant factor, unless there is no limit."""

SAME_FRAC = 1e-6

HOUR_S = 3600.0


def charging_s(kind: VehicleType, from_frac: float, to_frac: float) -> float:
    """Duration of charging a type of vehicle from one level to another; 0 where it is there already."""
    if to_frac <= from_frac:
        return 0.0
    full_s = HOUR_S * kind.battery_wh / kind.charge_w
    bend_frac = kind.charge_taper_frac
    flat_s = max(0.0, min(to_frac, bend_frac) - from_frac) * full_s
    begin_frac = max(from_frac, bend_frac)
    if to_frac <= begin_frac:
        return flat_s
    fall = (1.0 - LEFT_AT_FULL) / (1.0 - bend_frac)
    begin, end = (1.0 - fall * (level_frac - bend_frac) for level_frac in (begin_frac, to_frac))
    return flat_s + full_s / fall * log(begin / end)


class ChargerQueue:
    """The queue at the chargers of one plant, as seen by each type of vehicle.

    Args:
        plant: as it stands in its file.
        chargers: how many there are; by default those of the plant. Another number shows the effect of more chargers.
        battery: how much larger all batteries are.

    Attributes:
        ahead: vehicles that may be charged before one that comes to a charger.
        wait_s: how long a vehicle waits for a charger at most, when all come at once.
        starved: types of the fleet whose battery cannot last for the wait, even when it is full.
    """

    def __init__(self, plant: Plant, *, chargers: int = 0, battery: float = 1.0) -> None:
        self._plant = plant
        count = chargers or len(plant.chargers)
        self._chargers = max(count, 1)
        self.ahead = max(0, ceil(len(plant.fleet) / self._chargers) - 1)
        self._battery = battery
        self._apart_m, self._apart_s = self._apart()
        self.wait_s = 0.0
        self.starved: tuple[str, ...] = ()
        self._base_frac = {kind: self._reckon(kind) for kind in plant.vehicle_types}
        types = {spec.type for spec in plant.fleet.values()} or set(plant.vehicle_types)
        self._settle(sorted(types))

    def base_frac(self, kind: str) -> float:
        """Battery level that a vehicle before a charger needs for its wait.

        For a starved type, the level that still leaves a charge to be had.
        """
        return self._base_frac[kind]

    def enough_frac(self, kind: str) -> float:
        """The level from which on a vehicle leaves a charger to another one that cannot wait, and takes work again."""
        rules = self._plant.vehicle_types[kind].charging
        worth_frac = min(rules.below_frac, rules.must_below_frac + WORTH_FRAC)
        return min(rules.up_to_frac, max(worth_frac, self._base_frac[kind] + WORTH_FRAC))

    def needed_frac(self, kind: str, way_m: float, way_s: float) -> float:
        """Battery level that a vehicle at this distance from the nearest charger needs to come there and to wait."""
        spec = self._plant.vehicle_types[kind]
        battery_wh = spec.battery_wh * self._battery
        drive_frac = way_m * spec.drive_wh_per_m / battery_wh
        if kind in self.starved:
            return drive_frac + self._base_frac[kind]
        draw_frac = spec.idle_w * way_s / HOUR_S / battery_wh
        return drive_frac + max(RESERVE_FRAC, self._own_frac(spec) + draw_frac)

    def way_frac(self, kind: str, way_m: float, way_s: float) -> float:
        """Battery level that a vehicle needs when it sets off to a charger."""
        spec = self._plant.vehicle_types[kind]
        used_wh = way_m * spec.drive_wh_per_m + way_s * spec.idle_w / HOUR_S
        return used_wh / (spec.battery_wh * self._battery) + SPARE_FRAC

    # --- how it is done ---

    def _settle(self, types: Iterable[str]) -> None:
        """Compute wait and session in turns until both converge."""
        plant = self._plant
        kinds = [plant.vehicle_types[kind] for kind in types]
        for _ in range(TURNS):
            before_frac = dict(self._base_frac)
            self.wait_s = self._reckon_wait_s(kinds)
            self._base_frac = {kind: self._reckon(kind) for kind in plant.vehicle_types}
            self.starved = tuple(
                kind.id for kind in kinds if self._base_frac[kind.id] + WORTH_FRAC > kind.charging.up_to_frac
            )
            same = all(abs(self._base_frac[kind] - before_frac[kind]) < SAME_FRAC for kind in before_frac)
            if same or self.starved:
                break
        for kind in self.starved:
            rules = plant.vehicle_types[kind].charging
            self._base_frac[kind] = min(rules.below_frac, rules.up_to_frac - WORTH_FRAC)

    def _reckon_wait_s(self, kinds: Iterable[VehicleType]) -> float:
        """Time until the last vehicle has a charger: all others have a session each, at the first free charger."""
        each_s = {
            kind.id: self._battery * charging_s(kind, SPARE_FRAC, self.enough_frac(kind.id))
            + LOOKS_AGAIN_S
            + self._apart_s
            for kind in kinds
        }
        longest_s = sorted((each_s[spec.type] for spec in self._plant.fleet.values()), reverse=True)
        return min(sum(longest_s[: self.ahead]), sum(longest_s[:-1]) / self._chargers)

    def _reckon(self, kind: str) -> float:
        return max(RESERVE_FRAC, self._own_frac(self._plant.vehicle_types[kind]))

    def _own_frac(self, spec: VehicleType) -> float:
        """Spare, detour, hold-ups and wait, without the way."""
        battery_wh = spec.battery_wh * self._battery
        idle_s = self.wait_s + self._held_up_s(spec)
        detour_frac = 2.0 * self._apart_m * spec.drive_wh_per_m / battery_wh if self.ahead else 0.0
        return SPARE_FRAC + detour_frac + spec.idle_w * idle_s / HOUR_S / battery_wh

    def _held_up_s(self, spec: VehicleType) -> float:
        """Longest wait at both docks of a task beyond the quoted time: for as many vehicles as share a dock."""
        plant = self._plant
        docks = len(plant.machines) + len(plant.storages) + len(plant.warehouses)
        others = ceil(len(plant.fleet) / max(docks, 1)) if len(plant.fleet) > 1 else 0
        return DOCKS_OF_A_TASK * others * (max(spec.load_s, spec.unload_s) + CHANGEOVER_S)

    def _apart(self) -> tuple[float, float]:
        """Distance (m), and time there and back (s), from a charger to the waiting place of the last vehicle in the queue."""
        plant = self._plant
        farthest_m = farthest_s = 0.0
        if not self.ahead:
            return farthest_m, farthest_s
        for kind in sorted({spec.type for spec in plant.fleet.values()}):
            routes = plant.routes(kind, OPEN)
            step = ceil(len(plant.chargers) / CHARGERS_LOOKED_AT)
            for charger in map(plant.node_of, list(plant.chargers)[::step]):
                for place in plant.closest(charger, plant.parkings, self.ahead):
                    node = plant.node_of(place)
                    try:
                        out, back = routes.way(charger, node), routes.way(node, charger)
                    except NoWay:
                        continue
                    farthest_m = max(farthest_m, 0.5 * (out.length_m + back.length_m))
                    farthest_s = max(farthest_s, out.duration_s + back.duration_s)
        return farthest_m, farthest_s

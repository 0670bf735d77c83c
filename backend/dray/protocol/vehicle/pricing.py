"""The price of a transport: pure arithmetic over the plant's ways (paper, 4.1).

A price has five parts, all in seconds so that they add up and can be compared:

    empty way    driving from here to the source
    loaded way   driving from the source to the destination
    energy       Wh used * ENERGY_S_PER_WH, plus a premium that grows as the battery empties
    waiting      at the places of loading and unloading, as measured there lately
    suitability  SPARE_ABILITY_S for every ability of the vehicle that the task does not need

A vehicle quotes only what it can keep: the deadline, and enough charge to reach a charger.
"""

from __future__ import annotations

from collections.abc import Callable

import msgspec

from dray.errors import NoWay
from dray.messages import Refusal, Transport, TransportCost
from dray.plant import Plant
from dray.plant.restrictions import OPEN
from dray.protocol.contract_net.dock import dock_of
from dray.protocol.vehicle.battery_reserve import BatteryReserve
from dray.protocol.vehicle.drivers.driver import limited_s

ENERGY_S_PER_WH = 2.0
"""Price of energy (s/Wh). A second of charging at 600 W gives a sixth of a Wh. Energy costs a third of its charging time,
because charging mostly happens while there is no other work."""

LOW_BATTERY_S = 60.0
"""The premium of an empty battery (s): as much as a way across the plant. Emptier vehicles leave work to fuller ones near
by, and still take it when they are alone."""

SPARE_ABILITY_S = 10.0
"""Price of an unneeded ability (s): a few lanes, so that vehicles for rarer work stay free."""


class Quote(msgspec.Struct, frozen=True):
    """A vehicle's offer."""

    source: str
    cost: TransportCost
    finish_s: float
    """Promised handover (plant clock)."""


class Unable(msgspec.Struct, frozen=True):
    """Why there is no offer."""

    reason: Refusal
    detail: str


class Pricer:
    """Prices transports for one type of vehicle.

    Args:
        plant: its ways.
        vehicle_type: id of the type.
    """

    def __init__(self, plant: Plant, vehicle_type: str) -> None:
        self._plant = plant
        self._type = plant.vehicle_types[vehicle_type]
        self._reserve = BatteryReserve(plant, vehicle_type)

    def quote(
        self,
        work: Transport,
        *,
        node: str,
        node_at_s: float,
        battery_frac: float,
        now_s: float,
        deadline_s: float,
        node_in_m: float = 0.0,
        speed_frac: float = 1.0,
        wait_s: Callable[[str, float], float] = lambda _place, _comes_s: 0.0,
    ) -> Quote | Unable:
        """Price a transport from a node.

        Args:
            work: the transport.
            node: the vehicle's node, or the next one.
            node_at_s: when it is there (plant clock).
            battery_frac: the present charge.
            now_s: the present time.
            deadline_s: when it should be done.
            node_in_m: its way to that node. The battery must last for it, but the price leaves it out: the vehicle
                drives it whatever it does next.
            speed_frac: what a person's limit and other vehicles leave of the vehicle's own speed (`Driver.pace_frac`).
            wait_s: how long it would have to wait at a place beyond the handling, where it comes at a time (plant clock).

        Returns:
            The cheapest offer over all sources that can be kept; otherwise why the cheapest of all cannot be kept.
        """
        kind = self._type
        for ability in work.needed:
            if ability not in kind.abilities:
                return Unable(Refusal.ABILITY, f"cannot carry a {ability}")
        docks = {place: dock_of(self._plant, work, place) for place in (*work.sources, work.destination)}
        if not all(docks.values()):
            return Unable(Refusal.NO_WAY, "a place that is not in this plant")
        there = docks[work.destination]
        spare_s = SPARE_ABILITY_S * (len(kind.abilities) - 1)
        routes = self._plant.routes(kind.id)
        offers: list[tuple[Quote, float]] = []
        for source in work.sources:
            try:
                empty = routes.way(node, docks[source])
                loaded = routes.way(docks[source], there)
            except NoWay:
                continue
            empty_s = max(0.0, node_at_s - now_s) + limited_s(empty.duration_s, speed_frac)
            loaded_s = limited_s(loaded.duration_s, speed_frac)
            waiting_s = wait_s(source, now_s + empty_s)
            comes_s = now_s + empty_s + waiting_s + kind.load_s + loaded_s
            waiting_s += wait_s(work.destination, comes_s)
            took_s = empty_s + kind.load_s + loaded_s + kind.unload_s + waiting_s
            used_wh = (
                empty.length_m * kind.drive_wh_per_m
                + loaded.length_m * kind.loaded_wh_per_m
                + took_s * kind.idle_w / 3600.0
            )
            left_frac = battery_frac - used_wh / kind.battery_wh
            cost = TransportCost(
                empty_way_s=empty_s,
                loaded_way_s=loaded_s,
                energy_s=used_wh * ENERGY_S_PER_WH + low_battery_s(left_frac),
                suitability_s=spare_s,
                waiting_s=waiting_s,
            )
            offers.append((Quote(source=source, cost=cost, finish_s=now_s + took_s), left_frac))
        if not offers:
            return self._no_way(node, [docks[source] for source in work.sources], there)
        needed_frac = self._reserve.needed_frac(there) + node_in_m * kind.drive_wh_per_m / kind.battery_wh
        if self._plant.obstructed:
            # A load behind an obstacle without a way round is fetched only if no other source has it.
            clear = [offer for offer in offers if self._is_clear(node, docks[offer[0].source], there)]
            offers = clear or offers
        # The sort is stable: among equal prices the task's first source wins.
        offers.sort(key=lambda offer: offer[0].cost.total_s)
        for quote, left_frac in offers:
            if left_frac >= needed_frac and quote.finish_s <= deadline_s:
                return quote
        quote, left_frac = offers[0]
        if left_frac < needed_frac:
            return Unable(Refusal.BATTERY, f"{left_frac:.0%} would be left, {needed_frac:.0%} are needed")
        return Unable(Refusal.DEADLINE, f"{quote.finish_s - deadline_s:.0f} s too late")

    def _is_clear(self, node: str, source: str, there: str) -> bool:
        routes = self._plant.routes(self._type.id)
        return routes.leads_round(node, source) and routes.leads_round(source, there)

    def _no_way(self, node: str, sources: list[str], there: str) -> Unable:
        """Why no way leads there: closures, or the lanes of the plant."""
        routes = self._plant.routes(self._type.id, OPEN)
        if any(routes.leads(node, source) and routes.leads(source, there) for source in sources):
            return Unable(Refusal.CLOSED, "what is closed leaves no way")
        return Unable(Refusal.NO_WAY, "no way leads there")


def low_battery_s(left_frac: float) -> float:
    """The premium for leaving only `left_frac` in the battery (s): none above half, then quadratic."""
    missing = max(0.0, 0.5 - left_frac) / 0.5
    return LOW_BATTERY_S * missing * missing

"""A vehicle without work: it moves to a useful place, and charges in time.

    settle ----> dwell point claimed ----> driving there ----> standing, charging if it is a charger
       ^            (CONTEST_S)
       +---- work ended, dwell point lost, charge ended, charger left to another, battery low

If all chargers are taken, it waits at a parking place. Without one it waits at a spare road place
(`dray.plant.spare_places`), else at a node without a dock: a vehicle that waits at a machine blocks others.
Charging decisions are made in `charging`.

A resting vehicle goes on bidding; `stop` ends the rest when it wins.
"""

from __future__ import annotations

from heapq import nsmallest
from math import hypot

from dray.body import Charge
from dray.errors import NoWay
from dray.messages import DwellPointClaimed
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.runtime.life import Life
from dray.protocol.runtime.timers import spread_frac
from dray.protocol.vehicle.battery_reserve import COMPARED, NEVER_FRAC, BatteryReserve
from dray.protocol.vehicle.charging import Charging
from dray.protocol.vehicle.drivers.driver import Driver
from dray.protocol.vehicle.dwell_points import CONTEST_S, DwellPoints, Hold

SETTLE = "settle"
CLAIM = "claim"

SETTLE_S = 4.0
"""Time for which an idle vehicle waits for work near by before it drives to a dwell point (s)."""

SEEK_AGAIN_S = 30.0
"""Interval of attempts while all dwell points are taken (s)."""

TRIES = 3
"""Failed charges at one charger before another one is sought: a leaving vehicle may need a moment."""


class WaitingPlaces:
    """Waiting places of one type of vehicle without a dwell point: nodes without a dock, out of the way.

    Args:
        plant: its docks and lanes.
        vehicle_type: id of the type, for its ways.
    """

    def __init__(self, plant: Plant, vehicle_type: str) -> None:
        self._plant = plant
        self._type = vehicle_type
        self._reserve = BatteryReserve(plant, vehicle_type)
        docks = {plant.node_of(place) for place in plant.places}
        free = tuple(node for node in plant.stops if node not in docks)
        # No vehicle fetches from a source warehouse: material leaves it by other means.
        self._spots = free or tuple(plant.node_of(place) for place in plant.source_warehouses)

    def nearest(self, node: str) -> str:
        """The nearest such node, perhaps this one; this one if there is none."""
        here = self._plant.nodes[node]

        def distance_m(spot: str) -> float:
            there = self._plant.nodes[spot]
            return hypot(there.x_m - here.x_m, there.y_m - here.y_m)

        routes = self._plant.routes(self._type)
        closed = self._plant.restrictions.nodes
        spots = [spot for spot in self._spots if spot not in closed] if closed else self._spots
        found, least_s = node, float("inf")
        for spot in nsmallest(COMPARED, spots, key=distance_m):
            try:
                way_s = routes.duration_s(node, spot)
            except NoWay:
                continue
            # Avoid a dead end that leads to no dock.
            if way_s < least_s and self._reserve.needed_frac(spot) < NEVER_FRAC:
                found, least_s = spot, way_s
        return found


class IdlePositioning:
    """One vehicle's positions without work, and its charging.

    Args:
        atv: the vehicle's id.
        plant: its dwell points.
        vehicle_type: id of the vehicle's type.
        keys: the plant's bus keys.
        charging: the vehicle's charging decisions.
        driver: the vehicle's place on the lanes.
        life: the agent's life; alarms are named `SETTLE` and `CLAIM`.
    """

    def __init__(
        self,
        atv: str,
        plant: Plant,
        vehicle_type: str,
        keys: Keys,
        charging: Charging,
        driver: Driver,
        life: Life,
    ) -> None:
        self._atv = atv
        self._plant = plant
        self._charging = charging
        self._aside = WaitingPlaces(plant, vehicle_type)
        self._driver = driver
        self._life = life
        self._dwell_points = DwellPoints(atv, plant, vehicle_type, keys, life)
        self._charge_order = 0
        """Order number of the running charge; 0 for none."""
        self._failed = 0
        """Failed charges at this charger."""

    @property
    def dwell_point(self) -> str:
        """The dwell point where it stands or drives to; empty for none."""
        return self._dwell_points.dwell_point

    @property
    def charging(self) -> bool:
        return self._charge_order != 0

    def is_reserve(self, now_s: float) -> bool:
        """Whether it belongs to the reserve, and takes only work that others cannot do."""
        return self._dwell_points.reserve.is_member(now_s)

    # --- beginning and end ---

    def start(self, battery_frac: float, now_s: float) -> None:
        """The vehicle was switched on, perhaps in a dwell point."""
        self._stand_here(battery_frac, now_s)
        self._life.alarm(SETTLE, now_s + SETTLE_S + spread_frac(self._atv) * SETTLE_S)

    def soon(self, now_s: float) -> None:
        """Work is over: seek a place in a moment."""
        self._life.alarm(SETTLE, now_s + SETTLE_S)

    def stay(self, now_s: float) -> None:
        """Seek no place any more; a vehicle on its way to one stops at the next node."""
        self._life.cancel(SETTLE)
        self._life.cancel(CLAIM)
        if self._driver.way:
            self._driver.halt(now_s)

    def stop(self, now_s: float) -> None:
        """The vehicle has work: stop positioning, and leave the reserve."""
        self._give_up(now_s)
        self._dwell_points.reserve.take_work()

    def seek_anew(self, now_s: float) -> None:
        """Leave the present place for another one."""
        self._give_up(now_s)
        self.soon(now_s)

    def _give_up(self, now_s: float) -> None:
        self._dwell_points.leave(now_s)
        self._charge_order = self._failed = 0
        self._life.cancel(SETTLE)
        self._life.cancel(CLAIM)

    def go_elsewhere(self, now_s: float) -> None:
        """An obstacle blocks every way to its place: seek another one."""
        if self._driver.way:
            self.seek_anew(now_s)

    def turn_aside(self, node: str, now_s: float) -> bool:
        """Turn back without work before an obstacle that blocks every way to its place.

        It drives to the nearest reachable dwell point, even an occupied one, and claims one on the way.

        Returns:
            False if none can be reached; nothing is done then.
        """
        away = self._dwell_points.nearest_round(node)
        if not away or not self._driver.turn_back(node, now_s, away):
            return False
        self.seek_anew(now_s)
        return True

    def floor_changed(self, now_s: float) -> None:
        """Closures have changed: leave closed nodes, and take other ways."""
        claimed = self._dwell_points.dwell_point
        closed = bool(claimed) and self._is_closed(claimed)
        if closed:
            self._give_up(now_s)
        if not self._driver.follow(now_s):
            self._dwell_points.leave(now_s)
            closed = True
        if closed:
            self.soon(now_s)

    def _is_closed(self, dwell_point: str) -> bool:
        return self._plant.stand_of(dwell_point) in self._plant.restrictions.nodes

    # --- time passes ---

    def wake(self, name: str, battery_frac: float, now_s: float) -> None:
        """Handle one of its alarms."""
        if name == SETTLE:
            self._settle(battery_frac, now_s)
        elif self._dwell_points.dwell_point:
            self._take_dwell_point(now_s)

    def check_battery(self, battery_frac: float, now_s: float) -> None:
        """Send a parked vehicle to a charger in time, and a charged one away from it."""
        if self.charging:
            if self._charging.is_done(battery_frac, now_s):
                self._end_charge(now_s)
            return
        seeking = (
            self._dwell_points.hold is Hold.CLAIMED or self._life.awaits(SETTLE) or self._life.awaits(CLAIM)
        )
        if not seeking and self._charging.wants(battery_frac, now_s):
            self._life.alarm(SETTLE, now_s)

    # --- the body reports ---

    def arrived(self, now_s: float) -> None:
        """The vehicle has arrived."""
        there = (
            self._dwell_points.dwell_point
            and self._plant.stand_of(self._dwell_points.dwell_point) == self._driver.node
        )
        if there and self._dwell_points.hold is Hold.CLAIMED:
            self._dwell_points.arrive(now_s)
            self._charge()

    def action_done(self, order: int, now_s: float) -> bool:
        """A charge has filled the battery; False for another action."""
        if order != self._charge_order:
            return False
        self._end_charge(now_s)
        return True

    def action_failed(self, order: int, now_s: float) -> bool:
        """A charge has failed; False for another action."""
        if order != self._charge_order:
            return False
        self._charge_order = 0
        self._failed += 1
        if self._failed < TRIES:
            self._dwell_points.leave(now_s)
        else:
            self._failed = 0
            self._dwell_points.block(now_s)
        self.soon(now_s)
        return True

    # --- others ---

    def on_claim(
        self, claim: DwellPointClaimed, *, battery_frac: float, may_leave: bool, now_s: float
    ) -> None:
        """Handle another vehicle's claim on a dwell point.

        Args:
            claim: the claim.
            battery_frac: this vehicle's charge.
            may_leave: whether this vehicle can drive away.
            now_s: the present time.
        """
        gives_way = (
            claim.dwell_point == self._dwell_points.dwell_point
            and may_leave
            and self._dwell_points.is_charger
            and self._dwell_points.hold is Hold.STANDING
            and self._charging.gives_way(
                claim.atv,
                claim.battery_frac,
                battery_frac=battery_frac,
                charging=self.charging,
                now_s=now_s,
            )
        )
        if self._dwell_points.on_claim(claim, now_s, plugged=self.charging, gives_way=gives_way):
            self._charge_order = self._failed = 0
            self._life.cancel(CLAIM)
            self._life.alarm(SETTLE, now_s)

    # --- internals ---

    def _settle(self, battery_frac: float, now_s: float) -> None:
        if self.charging:
            return
        dwell_points, charging = self._dwell_points, self._charging
        if dwell_points.hold is Hold.NONE and not self._driver.way:
            self._stand_here(battery_frac, now_s)
        at_charger = dwell_points.hold is Hold.STANDING and dwell_points.is_charger
        parked = dwell_points.hold is Hold.STANDING and not dwell_points.is_charger
        if at_charger and charging.plugs_in(battery_frac, now_s):
            self._charge()
            return
        wants_charge = not at_charger and charging.wants(battery_frac, now_s)
        if parked and not wants_charge:
            return
        if (wants_charge and self._seek(True, battery_frac, now_s)) or (
            self._seek_nearer(battery_frac, now_s) if parked else self._seek(False, battery_frac, now_s)
        ):
            self._life.alarm(CLAIM, now_s + CONTEST_S)
            return
        if dwell_points.hold is Hold.NONE:
            self._step_aside(now_s)
        self._life.alarm(SETTLE, now_s + SEEK_AGAIN_S)

    def _seek(self, charger: bool, battery_frac: float, now_s: float) -> bool:
        node, near = self._driver.next_node, ""
        if not charger and self._charging.is_needy:
            # It waits for a charger, and has little charge for the way there.
            near = self._dwell_points.battery_reserve.nearest_charger(node)
        found = self._dwell_points.seek(
            charger=charger, node=node, battery_frac=battery_frac, now_s=now_s, near=near
        )
        return found or (not charger and self._seek_spare(node, battery_frac, now_s, near))

    def _seek_nearer(self, battery_frac: float, now_s: float) -> bool:
        """Move a parked vehicle that waits for a charger nearer to one."""
        return self._charging.is_needy and self._dwell_points.seek_nearer(
            self._driver.next_node, battery_frac, now_s
        )

    def _seek_spare(self, node: str, battery_frac: float, now_s: float, near: str) -> bool:
        """Without a parking place: wait on a clear road, else at a free charger, in the reserve, or on another road."""
        dwell_points, spare = self._dwell_points, self._plant.spare_places
        if dwell_points.seek_spare(spare.clear, node, battery_frac, now_s, near):
            return True
        if spare.reserve:
            if dwell_points.hold is Hold.STANDING and dwell_points.is_charger:
                return False  # As good as any that is left.
            if dwell_points.seek(charger=True, node=node, battery_frac=battery_frac, now_s=now_s):
                return True
        rest = (*spare.reserve, *spare.others)
        return dwell_points.seek_spare(rest, node, battery_frac, now_s, near)

    def _stand_here(self, battery_frac: float, now_s: float) -> None:
        """Claim the dwell point where the vehicle stands, unless another one has just won it."""
        for dwell_point in (*self._plant.dwell_points, *self._plant.spare_places.all):
            if (
                self._plant.stand_of(dwell_point) == self._driver.node
                and not self._dwell_points.is_taken(dwell_point, now_s)
                and not self._is_closed(dwell_point)
            ):
                self._dwell_points.stand(dwell_point, battery_frac, now_s)
                return

    def _step_aside(self, now_s: float) -> None:
        """Without a dwell point, or after its loss, do not wait at a dock."""
        aside = self._aside.nearest(self._driver.next_node)
        if aside == self._driver.next_node:
            self._driver.halt(now_s)
        else:
            self._driver.go(aside, now_s)

    def _take_dwell_point(self, now_s: float) -> None:
        """The claim is uncontested: drive there."""
        self._dwell_points.set_off()
        try:
            drives = self._driver.go(self._plant.stand_of(self._dwell_points.dwell_point), now_s)
        except NoWay:
            self._dwell_points.leave(now_s)
            self.soon(now_s)
            return
        if not drives:
            self.arrived(now_s)

    def _charge(self) -> None:
        if self._dwell_points.is_charger:
            self._charge_order = self._driver.next_order()
            self._driver.act(Charge(order=self._charge_order, charger=self._dwell_points.dwell_point))

    def _end_charge(self, now_s: float) -> None:
        """The charge suffices: seek another place, and keep this one until there is one or a vehicle asks for it."""
        self._charge_order = self._failed = 0
        self._life.alarm(SETTLE, now_s)

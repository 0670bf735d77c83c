"""Finding a place to charge or to park, without a central agent.

    SEEKING   --claim uncontested for CONTEST_S--> DRIVING --arrived--> STANDING --left to another--+
       |  ^                                          |                                              |
       |  +---------------- lost to another ---------+----------------------------------------------+
       +-- no dwell point of the kind is left: try again later

`dray.messages.floor.dwell_point` has the rule by which both sides decide a contest alike. A claim cannot be
checked. A claim that keeps this vehicle from a charger for longer than driving there or charging takes is not
believed. The vehicle then drives there.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import Enum
from heapq import nsmallest
from math import hypot

from dray.errors import NoWay
from dray.messages import DwellPointClaimed
from dray.messages.keys import Keys
from dray.plant import Plant, Routes
from dray.plant.charger_queue import WORTH_FRAC
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.life import Life
from dray.protocol.vehicle.battery_reserve import COMPARED, BatteryReserve
from dray.protocol.vehicle.reserve import Reserve

CONTEST_S = 1.0
"""Time to wait for an objection (s): many times the latency of a good WLAN. A later one is still handled on the way."""

TAKEN_MEMORY_S = 60.0
"""Time for which a lost dwell point is not claimed again (s)."""

BLOCKED_S = 600.0
"""Time for which a charger that was occupied or gave no power is not claimed again (s): a person has fixed it by then, or
none will."""

OBJECTS_AGAIN_S = 0.5
"""Minimum interval of objections to one rival (s): two vehicles that both believe to stand there must not flood the
network."""

APPROACH_S = 600.0
"""Maximum time of an approach (s): a claim of a vehicle that has not arrived by then is not believed."""

CHARGE_STRETCH = 1.5
"""Maximum charging time as a multiple of that at full power: with the taper it takes a third longer."""

PAUSE_S = 300.0
"""Pause after which a rival's next claim counts as a new one (s): it has been elsewhere."""

RIVALS = 256
"""Maximum remembered claims of others: forty vehicles at half a dozen chargers."""

MUCH_NEARER = 0.5
"""Maximum remaining fraction of the way to a charger for which a waiting vehicle changes its place."""


class Hold(Enum):
    """A vehicle's hold on a dwell point."""

    NONE = "none"
    CLAIMED = "claimed"
    STANDING = "standing"


class DwellPoints:
    """One vehicle's claim on a dwell point, at most one at a time.

    Args:
        atv: the vehicle's id.
        plant: its dwell points.
        vehicle_type: id of the vehicle's type, for its ways.
        keys: the plant's bus keys.
    """

    def __init__(self, atv: str, plant: Plant, vehicle_type: str, keys: Keys, life: Life) -> None:
        self._atv = atv
        self._plant = plant
        self._type = vehicle_type
        self._keys = keys
        self._life = life
        self._taken_until_s: dict[str, float] = {}
        self._stay_s = APPROACH_S + CHARGE_STRETCH * max(
            kind.battery_wh / kind.charge_w * 3600.0 for kind in plant.vehicle_types.values()
        )
        self._opposed_s: BoundedMap[tuple[str, str], tuple[float, float]] = BoundedMap(RIVALS)
        """By charger and rival: since when it has blocked, and when it was last heard."""
        self._doubted: set[tuple[str, str]] = set()
        """Rivals that have blocked for an impossible time."""
        self._objected_s: BoundedMap[str, float] = BoundedMap(RIVALS)
        """By rival: the last objection."""
        self._claim_battery_frac = 0.0
        """The charge that decides contests: that at the claim, less WORTH_FRAC on the way to a charger."""
        self.battery_reserve = BatteryReserve(plant, vehicle_type)
        self.reserve = Reserve(plant)
        self.dwell_point = ""
        """The claimed or occupied dwell point; empty for none."""
        self.hold = Hold.NONE

    @property
    def is_charger(self) -> bool:
        return self.dwell_point in self._plant.chargers

    def is_taken(self, dwell_point: str, now_s: float) -> bool:
        """Whether another vehicle has won this dwell point recently."""
        return self._taken_until_s.get(dwell_point, 0.0) > now_s

    def stand(self, dwell_point: str, battery_frac: float, now_s: float) -> None:
        """Claim the dwell point where the vehicle already stands."""
        self._claim(dwell_point, battery_frac, Hold.STANDING)
        self.reserve.stand(self._plant.stand_of(dwell_point), now_s)

    def seek(self, *, charger: bool, node: str, battery_frac: float, now_s: float, near: str = "") -> bool:
        """Claim the nearest dwell point that is not known to be taken.

        Args:
            charger: True for a charger, False for a parking place.
            node: the vehicle's node, or the next one.
            battery_frac: an emptier battery wins a contest.
            now_s: the present time.
            near: a node to be near to instead; empty for `node`.

        Returns:
            False if none is left.
        """
        found = self.nearest(charger=charger, node=node, battery_frac=battery_frac, now_s=now_s, near=near)
        if not found:
            return False
        self.leave(now_s)
        self._claim(found, battery_frac, Hold.CLAIMED)
        return True

    def nearest(self, *, charger: bool, node: str, battery_frac: float, now_s: float, near: str = "") -> str:
        """The dwell point that `seek` would claim; empty for none.

        A charger out of the battery's reach is excluded while another one is nearer: that one becomes free.
        """
        self._taken_until_s = {
            dwell_point: until_s for dwell_point, until_s in self._taken_until_s.items() if until_s > now_s
        }
        kind = self._plant.chargers if charger else self._plant.parkings
        routes = self._plant.routes(self._type)
        closed = self._plant.restrictions.nodes
        free = [
            dwell_point
            for dwell_point, spec in kind.items()
            if dwell_point not in self._taken_until_s and spec.node not in closed
        ]
        if open_ways := self.reached_round(node):
            free = [dwell_point for dwell_point in free if dwell_point in open_ways]
        # A vehicle in a reserve place takes no more work: use one only if there is no other.
        free = [each for each in free if not self.reserve.has(self._plant.stand_of(each))] or free
        near = near or node
        close = self._plant.closest(near, free, COMPARED)
        if not charger:
            # A parking place far from the chargers is better than none: a vehicle on a road blocks others.
            good = [
                each
                for each in close
                if self.battery_reserve.is_enough_after(node, self._plant.node_of(each), battery_frac)
            ]
            close = tuple(good) or close
        try:
            nearest, way = routes.nearest(near, close)
        except NoWay:
            return ""
        queue = self._plant.charger_queue
        is_far = charger and battery_frac < queue.way_frac(self._type, way.length_m, way.duration_s)
        return (
            ""
            if is_far and self._plant.node_of(nearest) != self.battery_reserve.nearest_charger(near)
            else nearest
        )

    def seek_nearer(self, node: str, battery_frac: float, now_s: float) -> bool:
        """Claim a parking or spare place that is much nearer to a charger; False if there is none.

        A vehicle that waits far away while all chargers are taken may lack charge for the way at its turn.
        """
        charger = self.battery_reserve.nearest_charger(node)
        if not charger:
            return False
        plant, routes = self._plant, self._plant.routes(self._type)
        stands = {each: plant.stand_of(each) for each in (*plant.parkings, *plant.spare_places.all)}
        closed = plant.restrictions.nodes
        free = [each for each, at in stands.items() if not self.is_taken(each, now_s) and at not in closed]
        there = plant.nodes[charger]

        def distance_m(each: str) -> float:
            spot = plant.nodes[stands[each]]
            return hypot(there.x_m - spot.x_m, there.y_m - spot.y_m)

        found, least_s = "", MUCH_NEARER * _way_s(routes, node, charger)
        for each in nsmallest(COMPARED, free, key=distance_m):
            way_s = _way_s(routes, stands[each], charger)
            if way_s < least_s:
                found, least_s = each, way_s
        if not found:
            return False
        self.leave(now_s)
        self._claim(found, battery_frac, Hold.CLAIMED)
        return True

    def seek_spare(
        self, among: Iterable[str], node: str, battery_frac: float, now_s: float, near: str = ""
    ) -> bool:
        """Claim the nearest of some spare road places that is not known to be taken, as `seek` does; False if none is."""
        plant = self._plant
        closed = plant.restrictions.nodes
        free = [each for each in among if not self.is_taken(each, now_s) and each not in closed]
        routes = plant.routes(self._type)
        near = near or node
        here = plant.nodes[near]

        def distance_m(spot: str) -> float:
            there = plant.nodes[spot]
            return hypot(there.x_m - here.x_m, there.y_m - here.y_m)

        found, least_s = "", float("inf")
        for spot in nsmallest(COMPARED, free, key=distance_m):
            way_s = _way_s(routes, near, spot)
            if way_s < least_s and self.battery_reserve.is_enough_after(node, spot, battery_frac):
                found, least_s = spot, way_s
        if not found:
            return False
        self.leave(now_s)
        self._claim(found, battery_frac, Hold.CLAIMED)
        return True

    def reached_round(self, node: str) -> tuple[str, ...]:
        """The dwell points that a way round all obstacles reaches from a node; none if there are no obstacles."""
        plant = self._plant
        if not plant.obstructed:
            return ()
        routes = plant.routes(self._type)
        return tuple(each for each in plant.dwell_points if routes.leads_round(node, plant.node_of(each)))

    def nearest_round(self, node: str) -> str:
        """The node of the nearest of these elsewhere; empty for none."""
        plant = self._plant
        places = [each for each in self.reached_round(node) if plant.node_of(each) != node]
        return plant.node_of(plant.routes(self._type).nearest(node, places)[0]) if places else ""

    def set_off(self) -> None:
        """Start the approach: from now on only a vehicle with WORTH_FRAC less charge can take the charger.

        Otherwise two vehicles could displace each other in turns: the one that has driven always has a little less.
        """
        if self.is_charger and self.hold is Hold.CLAIMED:
            self._claim_battery_frac = max(0.0, self._claim_battery_frac - WORTH_FRAC)

    def arrive(self, now_s: float) -> None:
        """The vehicle has arrived: credible rivals have given way."""
        self.hold = Hold.STANDING
        self.reserve.stand(self._plant.stand_of(self.dwell_point), now_s)
        for key in [key for key in self._opposed_s if key[0] == self.dwell_point]:
            if key not in self._doubted:
                del self._opposed_s[key]

    def leave(self, now_s: float) -> None:
        """Give the dwell point up; ignored without one. Silence frees it, because the vehicle objects no more."""
        self.reserve.leave(now_s)
        if self.dwell_point:
            self._life.unsubscribe(self._keys.dwell_point(self.dwell_point))
            self.dwell_point, self.hold = "", Hold.NONE

    def block(self, now_s: float) -> None:
        """The charger is of no use: leave it, and seek another."""
        self._taken_until_s[self.dwell_point] = now_s + BLOCKED_S
        self.leave(now_s)

    def on_claim(
        self, claim: DwellPointClaimed, now_s: float, *, plugged: bool = False, gives_way: bool = False
    ) -> bool:
        """Another vehicle claims a dwell point.

        Args:
            claim: the claim.
            now_s: the present time.
            plugged: whether this vehicle is charging there: no other can stand there too.
            gives_way: whether this vehicle gives its dwell point to the claimant.

        Returns:
            True if this vehicle has lost its dwell point.
        """
        if claim.dwell_point != self.dwell_point or claim.atv == self._atv:
            return False
        if not gives_way:
            if plugged or self._wins_over(claim):
                self._object_to(claim.atv, now_s)
                return False
            if self.hold is Hold.CLAIMED and self._is_doubtful(claim, now_s):
                return False
        self._taken_until_s[claim.dwell_point] = now_s + TAKEN_MEMORY_S
        self.leave(now_s)
        return True

    def _is_doubtful(self, claim: DwellPointClaimed, now_s: float) -> bool:
        """Whether a rival has kept this vehicle from a charger for an impossible time."""
        if not self.is_charger:
            return False  # A parking place may be occupied for ever.
        key = claim.dwell_point, claim.atv
        since_s, heard_s = self._opposed_s.get(key, (now_s, now_s))
        if now_s - heard_s > PAUSE_S:
            since_s = now_s
        self._opposed_s[key] = since_s, now_s
        is_doubted = now_s - since_s > (self._stay_s if claim.standing else APPROACH_S)
        if is_doubted:
            self._doubted.add(key)
        else:
            self._doubted.discard(key)
        self._doubted &= self._opposed_s.keys()
        return is_doubted

    def _wins_over(self, claim: DwellPointClaimed) -> bool:
        stands = self.hold is Hold.STANDING
        if stands != claim.standing:
            return stands
        mine = (self._claim_battery_frac, self._atv)
        return mine < (claim.battery_frac, claim.atv)

    def _object_to(self, rival: str, now_s: float) -> None:
        if now_s - self._objected_s.get(rival, -OBJECTS_AGAIN_S) >= OBJECTS_AGAIN_S:
            self._objected_s.pop(rival, None)
            self._objected_s[rival] = now_s
            self._object()

    def _claim(self, dwell_point: str, battery_frac: float, hold: Hold) -> None:
        self.dwell_point, self.hold, self._claim_battery_frac = dwell_point, hold, battery_frac
        self._life.subscribe(self._keys.dwell_point(dwell_point))
        self._object()

    def _object(self) -> None:
        claim = DwellPointClaimed(
            dwell_point=self.dwell_point,
            atv=self._atv,
            battery_frac=self._claim_battery_frac,
            standing=self.hold is Hold.STANDING,
        )
        self._life.publish(self._keys.dwell_point(self.dwell_point), claim)


def _way_s(routes: Routes, start: str, end: str) -> float:
    try:
        return routes.duration_s(start, end)
    except NoWay:
        return float("inf")

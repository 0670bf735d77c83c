"""Finding a place to charge or to park, with nobody in the middle.

    SEEKING   --claim uncontested for CONTEST_S--> DRIVING --arrived--> STANDING
       |  ^                                          |
       |  +---------------- lost to another ---------+
       +-- no berth of the kind is left: stay where you are, and try again later

See `dray.messages.berth` for the verdict that both sides of a contest reach alone.
"""

from __future__ import annotations

from enum import Enum

from dray.messages import BerthClaimed
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.events import Effect, Publish, Subscribe, Unsubscribe

CONTEST_S = 1.0
"""How long an objection is waited for: many times the latency of a good WLAN. A later one is still
heard, on the way."""

TAKEN_MEMORY_S = 60.0
"""How long a berth that was lost is not asked for again."""

COMPARED = 4
"""Berths whose ways are compared: the nearest by way is among the nearest as the crow flies."""


class Hold(Enum):
    """What a vehicle has of a berth."""

    NONE = "none"
    CLAIMED = "claimed"
    STANDING = "standing"


class Berths:
    """One vehicle's claim on a berth: at most one at a time.

    Args:
        atv: the vehicle.
        plant: where the berths are.
        vehicle_type: id of the vehicle's type, for its ways.
        keys: the plant's bus keys.
        out: where effects go.
    """

    def __init__(self, atv: str, plant: Plant, vehicle_type: str, keys: Keys, out: list[Effect]) -> None:
        self._atv = atv
        self._plant = plant
        self._routes = plant.routes(vehicle_type)
        self._keys = keys
        self._out = out
        self._taken_until_s: dict[str, float] = {}
        self._claim_battery_frac = 0.0
        self.berth = ""
        """The berth that is claimed or stood in; empty for none."""
        self.hold = Hold.NONE

    @property
    def is_charger(self) -> bool:
        return self.berth in self._plant.chargers

    def is_taken(self, berth: str, now_s: float) -> bool:
        """Whether another one has won this berth not long ago."""
        return self._taken_until_s.get(berth, 0.0) > now_s

    def stand(self, berth: str, battery_frac: float) -> None:
        """Claim the berth in which the vehicle stands already."""
        self._claim(berth, battery_frac, Hold.STANDING)

    def seek(self, *, charger: bool, node: str, battery_frac: float, now_s: float) -> bool:
        """Claim the nearest berth that is not known to be taken.

        Args:
            charger: a charger is needed; else a parking place is.
            node: where the vehicle is, or will be next.
            battery_frac: an emptier battery wins a contest.
            now_s: the present time.

        Returns:
            False when none is left to ask for.
        """
        self._taken_until_s = {
            berth: until_s for berth, until_s in self._taken_until_s.items() if until_s > now_s
        }
        kind = self._plant.chargers if charger else self._plant.parkings
        free = [berth for berth in kind if berth not in self._taken_until_s]
        if not free:
            return False
        near = self._plant.closest(node, free, COMPARED)
        nearest, _ = self._routes.nearest(node, near)
        self.leave()
        self._claim(nearest, battery_frac, Hold.CLAIMED)
        return True

    def arrive(self) -> None:
        """The vehicle stands in its berth now."""
        self.hold = Hold.STANDING

    def leave(self) -> None:
        """Give the berth up; harmless without one. Silence frees it: nobody objects any more."""
        if self.berth:
            self._out.append(Unsubscribe(self._keys.berth(self.berth)))
            self.berth, self.hold = "", Hold.NONE

    def hear(self, claim: BerthClaimed, now_s: float) -> bool:
        """Somebody wants a berth.

        Returns:
            True when this vehicle has just lost its own claim to it.
        """
        if claim.berth != self.berth or claim.atv == self._atv:
            return False
        if self._wins_over(claim):
            self._object()
            return False
        self._taken_until_s[claim.berth] = now_s + TAKEN_MEMORY_S
        self.leave()
        return True

    def _wins_over(self, claim: BerthClaimed) -> bool:
        stands = self.hold is Hold.STANDING
        if stands != claim.standing:
            return stands
        mine = (self._claim_battery_frac, self._atv)
        return mine < (claim.battery_frac, claim.atv)

    def _claim(self, berth: str, battery_frac: float, hold: Hold) -> None:
        self.berth, self.hold, self._claim_battery_frac = berth, hold, battery_frac
        self._out.append(Subscribe(self._keys.berth(berth)))
        self._object()

    def _object(self) -> None:
        claim = BerthClaimed(
            berth=self.berth,
            atv=self._atv,
            battery_frac=self._claim_battery_frac,
            standing=self.hold is Hold.STANDING,
        )
        self._out.append(Publish(self._keys.berth(self.berth), claim))

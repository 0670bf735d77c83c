"""Charging decisions: when a vehicle charges, whether it may work, and when it gives its charger to another vehicle.

    FREE --less than it must have--> NEEDY: takes no work --charged for WORTH_FRAC more--> FREE
    FREE or NEEDY --a person sends it--> SENT: takes no work --fully charged, or a person ends it--> FREE

The thresholds come from its type (`dray.plant.model.Charging`). Before a needy vehicle works again, it charges
enough to make the way worthwhile, not just for one transport. It does not charge longer than that: where chargers
are few, energy in a waiting vehicle's battery carries nothing.
"""

from __future__ import annotations

from dray.messages import CommandRefusal
from dray.plant import Plant, VehicleType
from dray.plant.charger_queue import RESERVE_FRAC, WORTH_FRAC
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.vehicle.battery_reserve import BatteryReserve

SPENT_FRAC = 0.05
"""Margin below `up_to_frac` under which a vehicle at a charger plugs in again."""

GIVES_WAY_AGAIN_S = 1800.0
"""Minimum interval between two times that a charger is given to the same vehicle (s); less where a small battery gains and
spends WORTH_FRAC sooner. A vehicle that lies about its battery gains no more than that."""

REMEMBERED = 64
"""Remembered vehicles that were given the charger: fewer want one charger in half an hour."""

HOUR_S, DAY_H = 3600.0, 24.0


class Charging:
    """One vehicle's battery in decisions about work and chargers.

    Args:
        plant: its chargers.
        vehicle_type: id of the vehicle's type.

    Attributes:
        is_sent: whether a person has sent it to charge, and it is not full yet.
    """

    def __init__(self, plant: Plant, vehicle_type: str) -> None:
        self.is_sent = False
        self._battery_frac = 1.0
        """The last noted charge."""
        self._has_charger = bool(plant.chargers)
        self._rules = plant.vehicle_types[vehicle_type].charging
        self._working_time = plant.working_time
        self._enough_frac = plant.charger_queue.enough_frac(vehicle_type)
        """Charge from which a needy vehicle takes work again."""
        self._must_below_frac = max(self._rules.must_below_frac, plant.charger_queue.base_frac(vehicle_type))
        """Charge below which a vehicle of its type must charge at any position."""
        self._again_s = min(GIVES_WAY_AGAIN_S, _worth_s(plant.vehicle_types[vehicle_type]))
        self._reserve = BatteryReserve(plant, vehicle_type)
        self._is_needy = False
        self._is_short = False
        """Whether it lacked charge for some work, and has not charged since."""
        self._gave_way_s: BoundedMap[str, float] = BoundedMap(REMEMBERED)
        """By vehicle: when this one gave it a charger."""

    def note(self, battery_frac: float, node: str) -> None:
        """Note the battery before any decision.

        Args:
            battery_frac: its charge.
            node: the vehicle's node, or the next one.
        """
        rules, self._battery_frac = self._rules, battery_frac
        if battery_frac < max(rules.must_below_frac, self._reserve.needed_frac(node)):
            self._is_needy = True
        elif battery_frac >= self._enough_frac:
            self._is_needy = False
        if battery_frac >= rules.up_to_frac:
            self._is_short = self.is_sent = False

    def send(self) -> CommandRefusal | None:
        """A person sends it to charge. Returns the refusal; None when it goes after its present work."""
        if not self._has_charger:
            return CommandRefusal.NOT_SUPPORTED
        if self._battery_frac >= self._rules.up_to_frac - SPENT_FRAC:
            return CommandRefusal.CHARGED
        self.is_sent = True
        return None

    def note_short(self) -> None:
        """Note that the battery was too low for a transport."""
        self._is_short = True

    @property
    def is_needy(self) -> bool:
        """Whether it must charge before it takes work again."""
        return self._is_needy or self.is_sent

    def why_no_work(self, battery_frac: float) -> str:
        """Why it takes no work; empty if it does."""
        if not self.is_needy:
            return ""
        enough_frac = self._rules.up_to_frac if self.is_sent else self._enough_frac
        return f"must charge: {battery_frac:.0%} left, takes work again from {enough_frac:.0%} on"

    def wants(self, battery_frac: float, now_s: float) -> bool:
        """Whether a vehicle without work goes to charge."""
        if self.is_needy:
            return True
        if self._is_short and battery_frac < self._rules.up_to_frac - WORTH_FRAC:
            return True
        # While the plant rests there is less to carry: charging now saves charging in working time.
        rests = not self._working_time.is_on(now_s)
        below_frac = self._rules.up_to_frac - WORTH_FRAC if rests else self._rules.below_frac
        return battery_frac < below_frac and self._is_opportune(now_s)

    def plugs_in(self, battery_frac: float, now_s: float) -> bool:
        """Whether a vehicle at a charger plugs in."""
        worth = battery_frac < self._rules.up_to_frac - SPENT_FRAC and self._is_opportune(now_s)
        return worth or self.wants(battery_frac, now_s)

    def is_done(self, battery_frac: float, now_s: float) -> bool:
        """Whether a charging vehicle has enough to leave."""
        rules = self._rules
        if battery_frac >= rules.up_to_frac:
            return True
        return (
            battery_frac >= rules.below_frac
            and not (self._is_short or self.is_sent)
            and self._is_quiet(now_s)
        )

    def gives_way(
        self, rival: str, rival_frac: float, *, battery_frac: float, charging: bool, now_s: float
    ) -> bool:
        """Whether a vehicle at a charger gives it to another; if so, that is noted.

        Args:
            rival: the vehicle that asks for the charger.
            rival_frac: its reported charge, which cannot be checked.
            battery_frac: this vehicle's charge.
            charging: whether this vehicle still charges; if not, it always makes room.
            now_s: the present time.
        """
        if not charging:
            return True
        if self._gave_way_s.get(rival, -self._again_s) > now_s - self._again_s:
            return False
        if rival_frac > battery_frac - WORTH_FRAC:
            return False
        rules = self._rules
        has_enough = battery_frac >= rules.below_frac
        if not has_enough and rival_frac < self._must_below_frac:
            has_enough = battery_frac >= self._enough_frac or rival_frac < RESERVE_FRAC
        if not has_enough:
            return False
        self._gave_way_s.pop(rival, None)
        self._gave_way_s[rival] = now_s
        return True

    def _is_opportune(self, now_s: float) -> bool:
        return self._rules.opportunity and not self._is_quiet(now_s)

    def _is_quiet(self, now_s: float) -> bool:
        hour = now_s / HOUR_S % DAY_H
        return any(
            each.start_h <= hour < each.end_h
            if each.start_h < each.end_h
            else hour >= each.start_h or hour < each.end_h
            for each in self._rules.quiet_hours
        )


def _worth_s(kind: VehicleType) -> float:
    """The time to charge a type of vehicle by WORTH_FRAC and to spend that driving (s)."""
    drive_w = kind.idle_w + kind.drive_wh_per_m * kind.max_speed_mps * HOUR_S
    return WORTH_FRAC * kind.battery_wh * HOUR_S * (1.0 / kind.charge_w + 1.0 / drive_w)

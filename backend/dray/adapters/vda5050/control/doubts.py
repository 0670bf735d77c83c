"""Impossible values: their replacements, and one message to people for each.

An impossible value counts as missing. Values are not clamped silently: that would turn a wrong scale into a plausible figure.
docs/vehicles.md has the table.
"""

from __future__ import annotations

from collections import Counter
from math import hypot, tau

from dray.adapters.vda5050.profile import Profile
from dray.adapters.vda5050.wire.messages import Battery, Load
from dray.adapters.vda5050.wire.timestamps import read_timestamp
from dray.messages import Pose
from dray.plant.model import VehicleType

FASTEST_TIMES, FASTEST_MPS = 3.0, 3.0
"""A speed above this multiple of the plant file's, and above these m/s, is impossible."""

LANE_TIMES, LANE_M = 2.0, 5.0
"""A distance since the last node above this multiple of the longest lane, and these metres, is impossible: it may drive a detour."""

THETA_MAX_RAD = tau + 0.1
"""A full turn, with rounding: the standard has -pi to pi, and many vehicles count from 0 to 2 pi."""

JUMP_M, JUMP_S = 2.0, 3.0
"""Localisation corrects itself by less, and states are late by less. A jump reported for longer is accepted: people, or a new
localisation, have moved the vehicle."""

YEARS = range(2020, 2101)
"""Plausible years; with another one, the clock was never set."""

CLOCK_STEP_S = 300.0
"""Plausible corrections of a clock are smaller."""

BACK_S = 1.0
"""Between two threads of a vehicle time may go back by less."""

QUOTED = 40
"""Maximum quoted characters of a vehicle's text."""

ROUNDED = 1.02
"""A battery up to this multiple of its scale is full: electronics may measure 100.4 %."""

SECONDS_PER_HOUR = 3600.0

TAPERED = 0.5
"""Mean fraction of the full charging power above `charge_taper_frac`."""

TOLD_MAX = 30
"""Maximum different doubts told to people; there are some twenty."""


class Doubts:
    """The doubts about one vehicle.

    Args:
        kind: its type in the plant.
        odd: the counter of doubted values.
        longest_m: the length of the plant's longest lane.
    """

    def __init__(self, kind: VehicleType, odd: Counter[str], longest_m: float) -> None:
        self._kind, self._odd, self._longest_m = kind, odd, longest_m
        self._told: set[str] = set()
        self._untold: list[str] = []

    def note(self, what: str, words: str) -> None:
        """Count a doubted value, and tell people the first time."""
        self._odd[what] += 1
        if what not in self._told and len(self._told) < TOLD_MAX:
            self._told.add(what)
            self._untold.append(f"{what}: {words}")

    def to_tell(self) -> list[str]:
        """The doubts not told yet."""
        told, self._untold = self._untold, []
        return told

    def speed(self, speed_mps: float) -> float | None:
        """The speed; None where it is impossible."""
        most_mps = FASTEST_TIMES * self._kind.max_speed_mps + FASTEST_MPS
        if speed_mps <= most_mps:
            return speed_mps
        self.note("an odd speed", f"{speed_mps:g} m/s is no speed of type {self._kind.id}; mm/s?")
        return None

    def heading(self, theta: float) -> float | None:
        """`theta`; None where it is impossible."""
        if abs(theta) <= THETA_MAX_RAD:
            return theta
        self.note("an odd theta", f"{theta:g} rad is more than a turn; degrees?")
        return None

    def loads(self, loads: tuple[Load, ...] | None) -> None:
        """Check the reported loads; weights are not used."""
        for load in loads or ():
            if load.weight is not None and load.weight < 0.0:
                self.note("an odd weight of a load", f"{load.weight:g} kg is less than nothing")

    def driven(self, distance_m: float | None) -> float | None:
        """`distanceSinceLastNode`; None where it is impossible."""
        most_m = LANE_TIMES * self._longest_m + LANE_M
        if distance_m is None or 0.0 <= distance_m <= most_m:
            return distance_m
        why = "less than nothing" if distance_m < 0.0 else "longer than any lane; mm, or since its start?"
        self.note("an odd distanceSinceLastNode", f"{distance_m:g} m is {why}")
        return None


class Jumps:
    """Poses farther from the previous one than the vehicle can have driven.

    Args:
        kind: its type in the plant.
        doubts: receives the doubts.
    """

    def __init__(self, kind: VehicleType, doubts: Doubts) -> None:
        self._top_mps = FASTEST_TIMES * kind.max_speed_mps
        self._doubts = doubts
        self._doubted: tuple[Pose, float, float] | None = None
        """The last refused pose, its time, and the time of the first such pose."""

    def is_one(self, before: Pose | None, before_s: float, now: Pose, now_s: float) -> bool:
        """Whether a new pose is refused; a persistent one is accepted in the end.

        Args:
            before: the last accepted pose; None for none.
            before_s: its time.
            now: the new pose.
            now_s: the present time.
        """
        if before is None or self._reaches(before, before_s, now, now_s):
            self._doubted = None
            return False
        since_s = now_s
        if self._doubted is not None and self._reaches(*self._doubted[:2], now, now_s):
            since_s = self._doubted[2]
        if now_s - since_s >= JUMP_S:
            self._doubted = None
            return False
        self._doubted = (now, now_s, since_s)
        gap_m = hypot(now.x_m - before.x_m, now.y_m - before.y_m)
        words = f"{gap_m:.1f} m within {now_s - before_s:.1f} s is farther than it can have driven"
        self._doubts.note("a pose that jumps", words)
        return True

    def _reaches(self, one: Pose, one_s: float, other: Pose, other_s: float) -> bool:
        within_m = JUMP_M + self._top_mps * (other_s - one_s + JUMP_S)
        return hypot(other.x_m - one.x_m, other.y_m - one.y_m) <= within_m


class TimeStamps:
    """The timestamps of one vehicle's states. They are checked, but not used.

    Args:
        doubts: receives the doubts.
    """

    def __init__(self, doubts: Doubts) -> None:
        self._doubts = doubts
        self._last: tuple[float, float] | None = None
        """The last time by the vehicle's clock, and by ours."""

    def look(self, said: str | None, now_s: float) -> None:
        """Check a newer state.

        Args:
            said: its `timestamp`; None where it is missing.
            now_s: the present time, by our clock.
        """
        if said is None:
            self._doubts.note("no timestamp", "a state does not say when it was")
            return
        read = read_timestamp(said)
        if read is None:
            self._doubts.note("an odd timestamp", f"{said[:QUOTED]!r} is no time of ISO 8601")
            return
        at_s, year = read
        if year not in YEARS:
            self._doubts.note("an odd timestamp", f"{said[:QUOTED]}: its clock was never set")
        last, self._last = self._last, (at_s, now_s)
        if last is None:
            return
        gone_s, ours_s = at_s - last[0], now_s - last[1]
        if abs(gone_s - ours_s) > CLOCK_STEP_S:
            self._doubts.note("a clock that jumps", f"by {gone_s - ours_s:+.0f} s, to {said[:QUOTED]}")
        elif gone_s < -BACK_S:
            self._doubts.note("a timestamp that goes back", f"by {-gone_s:.1f} s, to {said[:QUOTED]}")


class BatteryLevel:
    """The level of one battery: reported by the vehicle, or estimated by time and metres where that is impossible.

    Args:
        kind: the vehicle type's consumption and charging.
        profile: the battery's scale.
        doubts: receives the doubts.

    Attributes:
        frac: the level, from 0 to 1; half, before anything is known.
        unknown: why the level is only estimated; empty when the vehicle has reported it.
        is_plugged: whether it charges for a task of ours, regardless of its own report.
    """

    def __init__(self, kind: VehicleType, profile: Profile, doubts: Doubts) -> None:
        self._kind, self._profile, self._doubts = kind, profile, doubts
        self.frac = 0.5
        self.unknown = "it has not said it"
        self.is_plugged = False
        self._heard_s: float | None = None
        self._highest = 0.0
        """The highest plausible report: it shows whether the vehicle counts to 1 or to 100."""

    @property
    def looks_like_fraction(self) -> bool:
        """Whether its profile has percent, but it seems to count to 1."""
        return self._profile.battery_scale == "percent" and 0.0 < self._highest <= 1.0

    def on_state(self, battery: Battery | None, driven_m: float, now_s: float, *, loaded: bool) -> None:
        """Process a new state.

        Args:
            battery: the reported battery.
            driven_m: metres since the previous state.
            now_s: the present time.
            loaded: whether something is on board.
        """
        said = self._believed(battery.percent if battery is not None else None)
        is_charging = self.is_plugged or (battery is not None and battery.charging is True)
        if said is None and self._heard_s is not None:
            self.frac = self._reckoned(
                driven_m, now_s - self._heard_s, loaded=loaded, is_charging=is_charging
            )
        elif said is not None:
            self.frac, self.unknown = said, ""
        self._heard_s = now_s

    def _believed(self, said: float | None) -> float | None:
        full = 1.0 if self._profile.battery_scale == "fraction" else 100.0
        if said is None:
            self._doubt("no battery", "it does not say how full it is")
        elif not 0.0 <= said <= full * ROUNDED:
            self._doubt("an odd battery", f"{said:g} is not between 0 and {full:g}")
        else:
            self._highest = max(self._highest, said)
            if full == 1.0 or self._highest > 1.0:
                if said > full:
                    self._doubts.note("a battery above full", f"{said:g} is taken as {full:g}")
                return min(said / full, 1.0)
            self._doubt(
                "a doubtful battery",
                f"{said:g} may be of 1, not of 100; then battery_scale: fraction is right",
            )
        return None

    def _doubt(self, what: str, words: str) -> None:
        self.unknown = words
        self._doubts.note(what, f"{words}; its level is reckoned by time and metres")

    def _reckoned(self, driven_m: float, for_s: float, *, loaded: bool, is_charging: bool) -> float:
        kind = self._kind
        hours = for_s / SECONDS_PER_HOUR
        if is_charging:
            power_w = kind.charge_w * (1.0 if self.frac < kind.charge_taper_frac else TAPERED)
            return min(self.frac + power_w * hours / kind.battery_wh, 1.0)
        per_metre_wh = kind.loaded_wh_per_m if loaded else kind.drive_wh_per_m
        return max(self.frac - (kind.idle_w * hours + per_metre_wh * driven_m) / kind.battery_wh, 0.0)

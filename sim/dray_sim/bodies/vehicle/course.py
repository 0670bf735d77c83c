"""A vehicle's position in closed form, until its motion changes."""

from __future__ import annotations

from math import cos, hypot, sin

from dray.plant.floor.rectangles import Rectangle
from dray_sim.bodies.vehicle.motion import Profile


class Course:
    """One piece of a vehicle's motion: it drives straight on in one direction, or stands.

    Args:
        begin_s: time at which the piece begins.
        x_m, y_m, heading_rad: pose of the vehicle at that time.
        profile: speed profile of the piece; `STANDSTILL` for a vehicle that stands.
        profile_s: time in the profile at which the piece begins.
        reach_m: maximum length of the piece.
        length_m, width_m: size of the vehicle.
        lane: ends of the driven lane; None for a vehicle that stands.
        lifted: whether the vehicle is off the floor, where it blocks nothing.

    Attributes:
        radius_m: radius of the circle around the vehicle.
        top_mps: highest speed on this piece; 0 for a vehicle that stands.
    """

    __slots__ = (
        "_cos",
        "_profile",
        "_run_m",
        "_shift_s",
        "_sin",
        "begin_s",
        "heading_rad",
        "lane",
        "length_m",
        "lifted",
        "radius_m",
        "reach_m",
        "top_mps",
        "width_m",
        "x_m",
        "y_m",
    )

    def __init__(
        self,
        begin_s: float,
        x_m: float,
        y_m: float,
        heading_rad: float,
        profile: Profile,
        profile_s: float,
        reach_m: float,
        length_m: float,
        width_m: float,
        lane: tuple[str, str] | None = None,
        *,
        lifted: bool = False,
    ) -> None:
        self.begin_s = begin_s
        self.x_m, self.y_m, self.heading_rad = x_m, y_m, heading_rad
        self.length_m, self.width_m = length_m, width_m
        self.lane = lane
        self.lifted = lifted
        self.radius_m = hypot(length_m, width_m) / 2.0
        self._cos, self._sin = cos(heading_rad), sin(heading_rad)
        self._profile = profile
        self._shift_s = profile_s - begin_s
        self._run_m = profile.at(profile_s)[0]
        self.reach_m = max(0.0, min(reach_m, profile.length_m - self._run_m))
        self.top_mps = profile.top_mps if self.reach_m else 0.0

    def driven_m(self, at_s: float) -> float:
        """Distance driven on this piece."""
        if not self.reach_m:
            return 0.0
        return max(0.0, min(self._profile.at(at_s + self._shift_s)[0] - self._run_m, self.reach_m))

    def spot(self, at_s: float) -> tuple[float, float]:
        """Position of the vehicle's centre (x_m, y_m)."""
        run_m = self.driven_m(at_s)
        return self.x_m + run_m * self._cos, self.y_m + run_m * self._sin

    def covers(self, at_s: float) -> Rectangle:
        """The area of the floor that the vehicle covers."""
        return Rectangle(*self.spot(at_s), self.heading_rad, self.length_m, self.width_m)

    def apart_m(self, other: Course, at_s: float) -> float:
        """Distance between the circles around two vehicles; negative if the circles overlap."""
        x_m, y_m = self.spot(at_s)
        other_x_m, other_y_m = other.spot(at_s)
        return hypot(other_x_m - x_m, other_y_m - y_m) - self.radius_m - other.radius_m

    def nearing_mps(self, other: Course) -> float:
        """Highest speed at which two vehicles can approach one another."""
        one_mps, other_mps = self.top_mps, other.top_mps
        if not one_mps or not other_mps:
            return one_mps or other_mps
        across_mps = one_mps * self._sin - other_mps * other._sin
        along_mps = one_mps * self._cos - other_mps * other._cos
        # Each may drive at any speed up to its highest: the extremes are the corners of those pairs.
        return max(one_mps, other_mps, float((along_mps * along_mps + across_mps * across_mps) ** 0.5))

    @property
    def end(self) -> tuple[float, float]:
        """Farthest position of the vehicle's centre on this piece (x_m, y_m)."""
        return self.x_m + self.reach_m * self._cos, self.y_m + self.reach_m * self._sin

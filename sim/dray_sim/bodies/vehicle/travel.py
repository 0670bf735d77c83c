"""A vehicle's movement: its way, the distance it has come, and its next motion.

Closed form: between two calls the motion is a `Profile`, and every question takes the time at which it is asked. It
has no clock of its own. The vehicle looks at `next_at_s`, calls `arrive` then, and calls nothing else with a later
time.
"""

from __future__ import annotations

from typing import NamedTuple

from dray.body import SLOWEST_FRAC
from dray.errors import ProtocolViolation
from dray.messages import Pose
from dray.plant import Plant
from dray.plant.model import VehicleType
from dray_sim.bodies.obstacles import Ends, Obstacles
from dray_sim.bodies.vehicle.course import Course
from dray_sim.bodies.vehicle.motion import SHORT_M, STANDSTILL, Stretch, brake, plan
from dray_sim.bodies.vehicle.way import Way, join

NEVER_S = float("inf")


class Whereabouts(NamedTuple):
    """Where a vehicle is at one moment, and where it comes next."""

    pose: Pose
    next_node: str
    """The node where a new way may begin: the end of its lane, or the node where it stands."""
    next_node_s: float
    """Seconds to `next_node`; for a vehicle that is halted before it, those of a free run at top speed."""
    speed_mps: float


class Travel:
    """Position and movement of one vehicle. Times are of the plant's clock and never go back.

    Invariants: the driven distance never falls; the vehicle never passes the last released point; a halted vehicle
    comes to a stand and stays.

    Args:
        plant: the roads.
        vehicle_type: speeds and acceleration.
        node: where it stands at the beginning.
        now_s: when that is.
        obstacles: it stops before them, and before doors that are shut.

    Attributes:
        node: the last node that was passed.
        way: the way that it follows; None when it has ended.
        doors: on its lanes, if any.
    """

    def __init__(
        self,
        plant: Plant,
        vehicle_type: VehicleType,
        node: str,
        now_s: float,
        obstacles: Obstacles | None = None,
    ) -> None:
        self.node = node
        self.way: Way | None = None
        self._plant = plant
        self._obstacles = obstacles or Obstacles(plant)
        self.doors = self._obstacles.doors
        self._type, self._heading_rad = vehicle_type, 0.0
        self._top_mps = vehicle_type.max_speed_mps
        self._halted = False
        self._stranded = False
        self._lifted = False
        self._passed = 0
        """The index of the way's last point that was passed; it stands there or is on the lane after it."""
        self._released = 0
        """The index of the way's last point that may be driven to."""
        self._reaches = 0
        """The index of the last point that it comes to by its profile."""
        self._profile = STANDSTILL
        self._from_s = now_s
        self._from_m = 0.0
        """The profile's beginning on the way."""
        self._driven_m = 0.0
        """Metres up to the beginning of the profile."""

    # --- where it is -----------------------------------------------------------------------------

    def motion(self, now_s: float) -> tuple[float, float]:
        """Metres along the way and metres per second."""
        if self.way is None or self._passed >= self._released:
            return self._from_m if self.way is None else self.way.places_m[self._passed], 0.0
        run_m, speed_mps = self._profile.at(now_s - self._from_s)
        return self._from_m + run_m, speed_mps

    def driven_m(self, now_s: float) -> float:
        """All metres from the beginning."""
        return self._driven_m + self.motion(now_s)[0] - self._from_m

    @property
    def moves_until_s(self) -> float:
        """When it will stand, or has come to stand, unless something changes."""
        return self._from_s + self._profile.duration_s

    @property
    def waits(self) -> bool:
        """Whether it stands, or will stand, before the end of its way: for a release, or for an obstacle."""
        return self.way is not None and self._reaches < self.way.last

    @property
    def blocked(self) -> Ends | None:
        """The lane that it is on or may enter, and on which an obstacle is in its way; None for none."""
        lane = self._held_up_on
        return None if lane is None or (self._is_shut(lane) and self.is_clear(lane)) else lane

    @property
    def asks(self) -> Ends | None:
        """The lane before which it waits for a door to open; None for none."""
        lane = self._held_up_on
        return None if lane is None or self._halted or not self._is_shut(lane) else lane

    @property
    def enters(self) -> Ends | None:
        """The lane that it is on, or enters now; None for none."""
        way = self.way
        if way is None or self._passed >= self._released:
            return None
        if not self.entered and (self._profile is STANDSTILL or self._held_up_on is not None):
            return None
        return way.points[self._passed], way.points[self._passed + 1]

    @property
    def _held_up_on(self) -> Ends | None:
        """The lane that it may enter, or is on, and cannot drive to its end now."""
        way, lane = self.way, self._clear_to(self._from_m)[0]
        if way is None or lane != self._passed or lane >= self._released:
            return None
        return way.points[lane], way.points[lane + 1]

    def _is_shut(self, lane: Ends) -> bool:
        return self.doors is not None and self.doors.is_shut(lane)

    @property
    def entered(self) -> bool:
        """Whether it has left the last node that it passed."""
        return self.way is not None and self._from_m > self.way.places_m[self._passed] + SHORT_M

    def is_clear(self, lane: Ends) -> bool:
        """Whether nothing is in its way on a lane, other than a door that opens."""
        if self.doors is not None and self.doors.has_failed(lane):
            return False
        return self._obstacles.room_m(*lane, self._type) is None

    def can_stop(self, now_s: float) -> bool:
        """Whether it can brake in time before any obstacle in its way."""
        place_m, speed_mps = self.motion(now_s)
        return (
            place_m + speed_mps**2 / (2.0 * self._type.acceleration_mps2)
            <= self._clear_to(place_m)[1] + SHORT_M
        )

    @property
    def base_end(self) -> str:
        """The last node that it may drive to; empty when it has come there."""
        return "" if self.way is None or self._passed >= self._released else self.way.points[self._released]

    def on_lane(self, now_s: float) -> bool:
        """Whether it is between two nodes, or just leaving one; a way can then begin only at the next."""
        return self._is_on_lane(*self.motion(now_s))

    def next_node(self, now_s: float) -> str:
        """See `Whereabouts.next_node`."""
        if self.way is not None and self.on_lane(now_s):
            return self.way.points[self._passed + 1]
        return self.node

    def pose(self, now_s: float) -> Pose:
        """Its position and heading; it turns as it sets off into a lane."""
        return self._pose(*self.motion(now_s))

    def whereabouts(self, now_s: float) -> Whereabouts:
        """Where it is, with one look at its motion: it is asked very often."""
        place_m, speed_mps = self.motion(now_s)
        pose = self._pose(place_m, speed_mps)
        if self.way is None or not self._is_on_lane(place_m, speed_mps):
            return Whereabouts(pose, self.node, 0.0, speed_mps)
        when_s = self.next_at_s
        if when_s < NEVER_S:
            left_s = max(when_s - now_s, 0.0)
        else:
            left_s = max(self.way.places_m[self._passed + 1] - place_m, 0.0) / self._top_mps
        return Whereabouts(pose, self.way.points[self._passed + 1], left_s, speed_mps)

    def _is_on_lane(self, place_m: float, speed_mps: float) -> bool:
        if self.way is None or self._passed >= self._released:
            return False
        return speed_mps > 0.0 or place_m > self.way.places_m[self._passed] + SHORT_M

    def _pose(self, place_m: float, speed_mps: float) -> Pose:
        if self.way is not None and self._is_on_lane(place_m, speed_mps):
            return self.way.pose(self._plant, self._passed, place_m)
        here = self._plant.nodes[self.node]
        return Pose(x_m=here.x_m, y_m=here.y_m, heading_rad=self._heading_rad)

    def course(self, now_s: float) -> Course:
        """Its motion from now on, up to the next node at most, if nothing changes."""
        kind = self._type
        if self.way is None or self._passed >= self._released or now_s >= self.moves_until_s:
            here = self.pose(now_s)
            return Course(
                now_s,
                here.x_m,
                here.y_m,
                here.heading_rad,
                STANDSTILL,
                0.0,
                0.0,
                kind.length_m,
                kind.width_m,
                lifted=self._lifted,
            )
        place_m = self.motion(now_s)[0]
        here = self.way.pose(self._plant, self._passed, place_m)
        return Course(
            now_s,
            here.x_m,
            here.y_m,
            here.heading_rad,
            self._profile,
            now_s - self._from_s,
            self.way.places_m[self._passed + 1] - place_m,
            kind.length_m,
            kind.width_m,
            (self.way.points[self._passed], self.way.points[self._passed + 1]),
        )

    # --- what happens ----------------------------------------------------------------------------

    @property
    def next_at_s(self) -> float:
        """When the next point of the way is reached; `NEVER_S` when it is not."""
        if self.way is None or self._passed >= self._released:
            return NEVER_S
        return self._from_s + self._profile.time_at(self.way.places_m[self._passed + 1] - self._from_m)

    def arrive(self) -> int:
        """Pass the next point of the way.

        Returns:
            Its index in `Drive.nodes`.

        Raises:
            ProtocolViolation: there is no way.
        """
        if self.way is None:
            raise ProtocolViolation(f"the vehicle at {self.node} arrived without a way")
        self._heading_rad = self.way.heading_rad(self._passed)
        self._passed += 1
        self.node = self.way.points[self._passed]
        return self._passed - self.way.lead

    def finish(self, now_s: float) -> bool:
        """End the way if the vehicle has reached its last point; True when it has."""
        if self.way is None or self._passed < self.way.last:
            return False
        self._settle(now_s)
        self.way, self._from_m, self._profile = None, 0.0, STANDSTILL
        return True

    # --- what it is told -------------------------------------------------------------------------

    def drive(
        self,
        order: int,
        nodes: tuple[str, ...],
        released: int,
        now_s: float,
        limits_mps: tuple[float | None, ...] = (),
    ) -> str:
        """Follow a new way, after the lane that the vehicle is on. Arguments as in `dray.body.Drive`.

        Returns:
            "" when it does, else why it cannot; nothing has changed then.
        """
        start = self.next_node(now_s)
        if not nodes or nodes[0] != start:
            return f"the way must begin at {start}"
        if not 1 <= released <= len(nodes):
            return f"{released} of {len(nodes)} nodes released"
        if limits_mps and len(limits_mps) != len(nodes) - 1:
            return f"{len(limits_mps)} speed limits for {len(nodes) - 1} lanes"
        lane_m, speed_mps, lead = 0.0, 0.0, 0
        points = nodes
        if self.way is not None and self.on_lane(now_s):
            place_m, speed_mps = self.motion(now_s)
            lane_m, lead = place_m - self.way.places_m[self._passed], 1
            points = (self.way.points[self._passed], *nodes)
            # The lane that it is on is finished as it was begun.
            limits_mps = (self.way.limit_on(self._passed), *(limits_mps or (None,) * (len(nodes) - 1)))
        lanes = join(self._plant.roads_of(self._type.id), points)
        if isinstance(lanes, str):
            return lanes
        self._settle(now_s)
        self._stranded = False
        self.way = Way(order, points, lanes, lead, self._type.turn_speed_mps, limits_mps)
        self._passed, self._released, self._from_m = 0, released - 1 + lead, lane_m
        self._plan(speed_mps)
        return ""

    def release(self, order: int, released: int, now_s: float) -> None:
        """Let more of the way be driven. A smaller release, or one for another way, is late and changes nothing."""
        if self.way is None or self.way.order != order:
            return
        last = min(released - 1 + self.way.lead, self.way.last)
        if last > self._released:
            speed_mps = self._settle(now_s)
            self._released = last
            self._plan(speed_mps)

    def cut(self, now_s: float) -> None:
        """Go no farther than the next node; the way ends there."""
        if self.way is None:
            return
        on_lane = self.on_lane(now_s)
        speed_mps = self._settle(now_s)
        if not on_lane:
            self.way, self._from_m, self._profile = None, 0.0, STANDSTILL
            return
        self._released = self._passed + 1
        self.way = self.way.cut(self._released)
        self._plan(speed_mps)

    def look(self, now_s: float) -> None:
        """Something was put on a lane, or is gone."""
        self._plan(self._settle(now_s))

    def limit(self, speed_frac: float, now_s: float) -> None:
        """Keep below this part of the top speed."""
        self._top_mps = min(max(speed_frac, SLOWEST_FRAC), 1.0) * self._type.max_speed_mps
        self._plan(self._settle(now_s))

    def halt(self, now_s: float) -> None:
        """Brake at once, wherever it is, and stay until `go_on`."""
        self._halted = True
        self._plan(self._settle(now_s))

    def stop_dead(self, now_s: float) -> None:
        """Stand still in this moment, and stay until `go_on`."""
        self._halted = True
        self._settle(now_s)
        self._plan(0.0)

    def strand(self, now_s: float) -> None:
        """Stand still in this moment and forget the way; on a lane, stay there until the next way."""
        self.stop_dead(now_s)
        self.cut(now_s)
        self._stranded = True

    def place_at(self, node: str, now_s: float) -> None:
        """Move it to a node by hand, or off the floor if `node` is empty; this forgets the way, and counts no metres."""
        self._settle(now_s)
        self.node, self._lifted = node or self.node, not node
        self.way, self._from_m, self._profile = None, 0.0, STANDSTILL
        self._stranded = False

    def go_on(self, now_s: float) -> None:
        """Follow the way again; harmless when nothing has halted it."""
        if self._halted:
            self._halted = False
            self._plan(self._settle(now_s))

    # --- how it is done --------------------------------------------------------------------------

    def _settle(self, now_s: float) -> float:
        """Let the profile begin now. Returns the present speed, for the plan that must follow."""
        place_m, speed_mps = self.motion(now_s)
        self._driven_m += place_m - self._from_m
        self._from_s, self._from_m = now_s, place_m
        return speed_mps

    def _clear_to(self, place_m: float) -> tuple[int, float]:
        """How far it may drive from a place on its way: within the released part, and up to the first obstacle.

        Returns:
            The last point that it passes, and the place where it stands then, in metres from the first point.
        """
        way = self.way
        if way is None or self._passed >= self._released:
            return self._passed, place_m
        if self._obstacles.shapes or self.doors is not None:
            for lane in range(self._passed, self._released):
                driven_m = place_m - way.places_m[lane]
                ends = way.points[lane], way.points[lane + 1]
                if driven_m <= SHORT_M and self._is_shut(ends):
                    return lane, way.places_m[lane]
                room_m = self._obstacles.room_m(*ends, self._type, driven_m)
                if room_m is None:
                    continue
                if driven_m > SHORT_M:
                    return lane, way.places_m[lane] + max(room_m, driven_m)
                return lane, way.places_m[lane]
        return self._released, way.places_m[self._released]

    def _plan(self, speed_mps: float) -> None:
        """Make a new profile from where it was settled."""
        point, end_m = self._clear_to(self._from_m)
        self._reaches, room_m = point, end_m - self._from_m
        if (
            self.way is None
            or self._passed >= self._released
            or (point == self._passed and room_m <= SHORT_M)
        ):
            self._profile = STANDSTILL
        elif self._halted or self._stranded:
            self._profile = brake(speed_mps, self._type.acceleration_mps2, room_m)
        elif point == self._passed:
            lane = self.way.ahead(point, self._from_m, point + 1, self._top_mps)
            stretch = Stretch([room_m], lane.limits_mps, lane.caps_mps)
            self._profile = plan(stretch, speed_mps, self._type.acceleration_mps2)
        else:
            stretch = self.way.ahead(self._passed, self._from_m, point, self._top_mps)
            self._profile = plan(stretch, speed_mps, self._type.acceleration_mps2)

"""The master's view of a vehicle from its messages: its newest state, its pose, whether it is present.

Times are ours: the vehicle's own clock is not used. `headerId` identifies doubled and reordered states; it may restart
after a restart of the vehicle.
"""

from __future__ import annotations

import re
from collections import Counter
from math import atan2, cos, hypot, sin

import msgspec

from dray.adapters.vda5050.control.doubts import BatteryLevel, Doubts, Jumps, TimeStamps
from dray.adapters.vda5050.control.names import Names
from dray.adapters.vda5050.control.senders import Senders
from dray.adapters.vda5050.control.spelling import spelled
from dray.adapters.vda5050.profile import Profile
from dray.adapters.vda5050.wire.lenient import read
from dray.adapters.vda5050.wire.messages import (
    ActionState,
    Connection,
    Factsheet,
    Position,
    State,
    Velocity,
    Visualization,
)
from dray.messages import Pose
from dray.messages.base import METRES_MAX
from dray.plant.model import VehicleType

NEVER_S = float("-inf")

REORDERED_MAX = 20
"""A header id lower by at most this means an older message; a lower one means that the vehicle has restarted counting."""

REORDERED_S = 5.0
"""No message is overtaken by one sent so much earlier."""

STANDING_MPS = 0.02
"""Maximum speed that counts as standing: odometry is never quite still."""

STIRRED_M = 0.05
"""Minimum change of a pose that counts as movement: localisation is never quite still."""

CONTRADICTED_S = 10.0
"""Seconds after which `driving` is not believed, if the speed is 0 and the pose does not change."""

_INSTANT = re.compile(r"-i\d+$")
"""The end of ids of our instant actions (`InstantActions`); those of orders never match."""

DOUBLED, REORDERED, OTHER_MAP, NOWHERE, OTHER_TOPIC, WHICH_MAP = (
    "a doubled state",
    "an older state",
    "a pose on another map",
    "a pose that cannot be",
    "another topic",
    "a node of several maps, without a map",
)
"""Counted events, beside odd parts of a message."""


class VehicleView:
    """The state of one vehicle, by its messages.

    Args:
        profile: its type's profile.
        agent: its agent: ids of our orders and actions begin with it.
        kind: its type in the plant.
        names: its names for the plant's things.

    Attributes:
        names: its names for the plant's things.
        said_node: its last node by its own name; in `state` that has our name.
        odd: ignored things, by reason.
        doubts: about impossible values.
        battery: its battery level.
        state: the newest state.
        heard_s: the time of that state; `NEVER_S` before the first one.
        pose: in the plant's frame; None before the first one.
        speed_mps: its speed.
        map_id: its map.
        away: its own report that it is offline; empty for none.
        away_s: the time of that report.
        stirred_s: the time of its last movement, by its speed or by its pose.
        factsheet: None before the first one.
    """

    def __init__(self, profile: Profile, agent: str, kind: VehicleType, names: Names) -> None:
        self._prefix, self.names = f"{agent}-", names
        self.said_node = ""
        self.odd: Counter[str] = Counter()
        self.doubts = Doubts(kind, self.odd, names.longest_m)
        self.battery = BatteryLevel(kind, profile, self.doubts)
        self._jumps, self._stamps = Jumps(kind, self.doubts), TimeStamps(self.doubts)
        self.state = State()
        self.heard_s = NEVER_S
        self.pose: Pose | None = None
        self.speed_mps = 0.0
        self.map_id = profile.map.id
        self.is_on_map = True
        """Whether its newest pose was on the map of its profile."""
        self.away = ""
        self.away_s = NEVER_S
        self.factsheet: Factsheet | None = None
        self._posed_s = NEVER_S
        self.stirred_s = NEVER_S
        self._stirred_at: Pose | None = None
        self._senders = Senders()
        self._counts_anew = False
        """It has reconnected: its messages may be numbered from 0 again."""
        self.doubtful_s: float | None = None
        """The time of an old state, a state of a restarted vehicle, or a pose that jumps; None after a newer one."""

    def take(self, topic: str, data: bytes, now_s: float) -> State | None:
        """Process a message.

        Returns:
            A new state; None for any other message.
        """
        match topic:
            case "state":
                state = read(State, data, self.odd)
                return state if state is not None and self._take_state(state, now_s) else None
            case "visualization":
                shown = read(Visualization, data, self.odd)
                if shown is not None:
                    self._take_pose(shown.position, shown.velocity, now_s)
            case "connection":
                connection = read(Connection, data, self.odd)
                if connection is not None:
                    self.away = connection.connection_state or "" if connection.is_away else ""
                    self.away_s, self._counts_anew = now_s, True
            case "factsheet":
                self.factsheet = read(Factsheet, data, self.odd) or self.factsheet
            case _:
                self.odd[OTHER_TOPIC] += 1
        return None

    @property
    def battery_frac(self) -> float:
        """The battery level; estimated without a plausible report."""
        return self.battery.frac

    @property
    def is_posed(self) -> bool:
        """Whether its pose is that of its newest state, and not of another message or an earlier time."""
        return self._posed_s == self.heard_s

    @property
    def is_charging(self) -> bool:
        battery = self.state.battery
        return battery is not None and battery.charging is True

    @property
    def is_moving(self) -> bool:
        """Whether it moves: by its speed, else by its own report."""
        if self.state.velocity is not None or self.pose is not None:
            return self.speed_mps > STANDING_MPS
        return self.is_driving

    @property
    def driven_m(self) -> float | None:
        """Metres since its last node, for a vehicle that follows lines; None without a report."""
        return self.doubts.driven(self.state.distance_since_last_node)

    @property
    def is_driving(self) -> bool:
        """Whether it reports driving, and neither its speed nor its pose has contradicted that for a while."""
        return self.state.driving is True and not self.is_driving_denied

    @property
    def is_driving_denied(self) -> bool:
        """Whether it reports driving, but stands: its speed is 0, and its pose has not changed."""
        is_seen = self.state.velocity is not None or self.pose is not None
        last_s = max(self.heard_s, self._posed_s)
        still = is_seen and last_s - self.stirred_s >= CONTRADICTED_S
        return self.state.driving is True and still

    # --- what it has left to do ------------------------------------------------------------------

    @property
    def shows_ours(self) -> bool:
        """Whether its order is ours, of any life."""
        return (self.state.order_id or "").startswith(self._prefix)

    @property
    def is_foreign(self) -> bool:
        """Whether its order is of another master."""
        return bool(self.state.order_id) and not self.shows_ours

    @property
    def is_idle(self) -> bool:
        """Whether no work remains, by the standard: no nodes, no edges, and all counting actions are over."""
        state = self.state
        return not (self.acting or state.node_states or state.edge_states or self.is_driving)

    @property
    def acting(self) -> tuple[ActionState, ...]:
        """Actions of orders that are not over.

        Our instant actions do not count. Others' actions count only if they are of a type for orders: a lamp or a horn does not
        delay an order.
        """
        return tuple(
            action
            for action in self.state.going_on
            if (self._is_ordered(action) if self._is_ours(action) else self.is_foreign)
        )

    @property
    def foreign_actions(self) -> tuple[ActionState, ...]:
        """Actions that are not over, and belong to none of our orders or lives."""
        listed = (*self.state.going_on, *self.state.running_instant)
        return tuple(action for action in listed if not self._is_ours(action))

    def _is_ours(self, action: ActionState) -> bool:
        return (action.action_id or "").startswith(self._prefix)

    def _is_ordered(self, action: ActionState) -> bool:
        return _INSTANT.search(action.action_id or "") is None

    def _take_state(self, state: State, now_s: float) -> bool:
        is_first = self.heard_s == NEVER_S
        said, state = state.last_node_id or "", self._with_our_names(spelled(state, self.doubts))
        if not is_first and (why := self._stale(state, now_s)):
            self.odd[why] += 1
            if why == DOUBLED:
                self.heard_s = now_s  # Any message shows that it is present.
            elif self.doubtful_s is None:
                self.doubtful_s = now_s
            return False
        # Two that are known to be two stay so while their numbers go to and fro, also where one could have driven to the other's place.
        if self._counts_back(state) and (self.doubtful_s is not None or self._senders.are_two(now_s)):
            self._senders.note(now_s)
        self.doubtful_s, self._counts_anew = None, False
        self.state, self.heard_s, self.said_node = state, now_s, said
        self._stamps.look(state.timestamp, now_s)
        self.doubts.loads(state.loads)
        self.away = ""  # A message shows that it is present: `connection` is only a hint.
        before = self.pose
        self._take_pose(state.position, state.velocity, now_s)
        driven_m = 0.0
        if before is not None and self.pose is not None:
            driven_m = hypot(self.pose.x_m - before.x_m, self.pose.y_m - before.y_m)
        self.battery.on_state(state.battery, driven_m, now_s, loaded=bool(state.loads))
        if not state.driving and state.velocity is None:
            self.speed_mps = 0.0
        if is_first or self.speed_mps > STANDING_MPS:
            self.stirred_s = now_s
        return True

    def _with_our_names(self, state: State) -> State:
        """A state with our name of its last node; with none where the name is ambiguous."""
        theirs = state.last_node_id
        if not theirs:
            return state
        position = state.position
        ours = self.names.ours(theirs, (position.map_id if position else "") or self.map_id)
        if ours is None:
            self.odd[WHICH_MAP] += 1
        return state if ours == theirs else msgspec.structs.replace(state, last_node_id=ours)

    def _counts_back(self, state: State) -> bool:
        """Whether its header id is far below the last one."""
        before, now = self.state.header_id, state.header_id
        return before is not None and now is not None and before - now > REORDERED_MAX

    def has_two_senders(self, now_s: float) -> bool:
        """Whether two vehicles or programs use its name."""
        return self._senders.are_two(now_s)

    def _stale(self, state: State, now_s: float) -> str:
        before, now = self.state.header_id, state.header_id
        if before is None or now is None:
            return ""
        if now == before:
            return DOUBLED if state == self.state else ""
        is_older = (
            not self._counts_anew
            and 0 < before - now <= REORDERED_MAX
            and now_s - self.heard_s <= REORDERED_S
        )
        return REORDERED if is_older else ""

    def _take_pose(self, position: Position | None, velocity: Velocity | None, now_s: float) -> None:
        if velocity is not None:
            speed_mps = self.doubts.speed(hypot(velocity.vx or 0.0, velocity.vy or 0.0))
            velocity = None if speed_mps is None else velocity
            self.speed_mps = self.speed_mps if speed_mps is None else speed_mps
        if position is None or position.x is None or position.y is None or not position.is_localised:
            return
        map_id = position.map_id or self.map_id
        has_changed_map = map_id != self.map_id
        if not self.map_id or self.names.knows_map(map_id):
            self.map_id = map_id  # It has gone to another floor.
        frame = self.names.frame(map_id)
        if abs(position.x) > METRES_MAX or abs(position.y) > METRES_MAX:
            self.odd[NOWHERE] += 1
            return
        self.is_on_map = map_id == self.map_id and frame is not None
        if not self.is_on_map or frame is None:
            self.odd[OTHER_MAP] += 1
            return
        before, before_s = self.pose, self._posed_s
        theta = self.doubts.heading(position.theta or 0.0)
        x_m, y_m, turn = frame.to_plant(position.x, position.y, theta or 0.0)
        pose = Pose(x_m=x_m, y_m=y_m, heading_rad=atan2(sin(turn), cos(turn)))
        if self._jumps.is_one(None if has_changed_map else before, before_s, pose, now_s):
            self.doubtful_s = now_s if self.doubtful_s is None else self.doubtful_s
            return
        self.pose = pose
        if theta is None and before is not None:
            self.pose = msgspec.structs.replace(self.pose, heading_rad=before.heading_rad)
        self._posed_s = now_s
        at = self._stirred_at
        if at is None or hypot(self.pose.x_m - at.x_m, self.pose.y_m - at.y_m) > STIRRED_M:
            self._stirred_at, self.stirred_s = self.pose, now_s
        if velocity is None and before is not None and now_s > before_s and self.is_driving:
            gone_m = hypot(self.pose.x_m - before.x_m, self.pose.y_m - before.y_m)
            self.speed_mps = gone_m / (now_s - before_s)

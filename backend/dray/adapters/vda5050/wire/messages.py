"""A vehicle's messages in all versions: every field may be missing, null or odd.

There is one struct for all versions. Where versions have two names for one thing both are fields, and a property takes the
present one. Implausible values (a NaN, an unknown word) count as missing.
"""

from __future__ import annotations

import msgspec


class Said(msgspec.Struct, frozen=True, rename="camel"):
    """Base: unknown fields are ignored, known ones may be null."""


class Position(Said, frozen=True):
    """`agvPosition` of 2.x, `mobileRobotPosition` of 3.0: metres and radians in the vehicle's map."""

    x: float | None = None
    y: float | None = None
    theta: float | None = None
    map_id: str | None = None
    position_initialized: bool | None = None
    localized: bool | None = None

    @property
    def is_localised(self) -> bool:
        """Whether the vehicle knows its position; assumed when the flag is missing."""
        return self.position_initialized is not False and self.localized is not False


class Velocity(Said, frozen=True):
    """Velocity in the vehicle's frame, in metres per second."""

    vx: float | None = None
    vy: float | None = None


class Reference(Said, frozen=True):
    """The subject of an error."""

    reference_key: str | None = None
    reference_value: str | None = None


class VehicleError(Said, frozen=True):
    """One of `errors`."""

    error_type: str | None = None
    error_level: str | None = None
    error_references: tuple[Reference, ...] | None = None
    error_description: str | None = None
    error_hint: str | None = None

    def names(self, value: str) -> bool:
        """Whether it refers to this id."""
        return any(reference.reference_value == value for reference in self.error_references or ())

    @property
    def order_named(self) -> str:
        """The order that it refers to; empty for none."""
        pairs = self.error_references or ()
        return next((pair.reference_value or "" for pair in pairs if pair.reference_key == "orderId"), "")

    @property
    def key(self) -> tuple[str, str, tuple[str, ...]]:
        """The identity of an error."""
        named = tuple(f"{pair.reference_key}={pair.reference_value}" for pair in self.error_references or ())
        return self.error_type or "", self.error_description or "", named

    @property
    def text(self) -> str:
        """A text for people."""
        kind, words = self.error_type or "an error without a type", self.error_description or self.error_hint
        return f"{kind}: {words}" if words else kind


class ActionState(Said, frozen=True):
    """One of `actionStates` or `instantActionStates`."""

    action_id: str | None = None
    action_type: str | None = None
    action_status: str | None = None
    result_description: str | None = None
    action_result: str | None = None

    @property
    def result(self) -> str:
        """The result in the vehicle's words; may be empty."""
        return self.result_description or self.action_result or ""


class NodeState(Said, frozen=True):
    """One of `nodeStates`: a remaining node."""

    node_id: str | None = None
    sequence_id: int | None = None
    released: bool | None = None


class EdgeState(Said, frozen=True):
    """One of `edgeStates`."""

    edge_id: str | None = None
    sequence_id: int | None = None


class Battery(Said, frozen=True):
    """`batteryState` of 2.x, `powerSupply` of 3.0."""

    battery_charge: float | None = None
    state_of_charge: float | None = None
    charging: bool | None = None

    @property
    def percent(self) -> float | None:
        """The charge level."""
        return self.battery_charge if self.battery_charge is not None else self.state_of_charge


class Safety(Said, frozen=True):
    """`safetyState`."""

    e_stop: str | None = None
    active_emergency_stop: str | None = None
    field_violation: bool | None = None
    """Something is in its protective field."""

    @property
    def emergency_stop(self) -> str:
        """The active emergency stop; empty for none."""
        said = self.e_stop or self.active_emergency_stop or "NONE"
        return "" if said == "NONE" else said


class Load(Said, frozen=True):
    """One of `loads`."""

    load_id: str | None = None
    load_type: str | None = None
    weight: float | None = None
    """Weight in kg."""


class State(Said, frozen=True):
    """The topic `state`."""

    header_id: int | None = None
    timestamp: str | None = None
    order_id: str | None = None
    order_update_id: int | None = None
    last_node_id: str | None = None
    last_node_sequence_id: int | None = None
    distance_since_last_node: float | None = None
    """Metres, for vehicles that follow lines; None for others."""
    driving: bool | None = None
    paused: bool | None = None
    operating_mode: str | None = None
    node_states: tuple[NodeState, ...] | None = None
    edge_states: tuple[EdgeState, ...] | None = None
    agv_position: Position | None = None
    mobile_robot_position: Position | None = None
    velocity: Velocity | None = None
    loads: tuple[Load, ...] | None = None
    """None where the vehicle does not report its load."""
    action_states: tuple[ActionState, ...] | None = None
    instant_action_states: tuple[ActionState, ...] | None = None
    battery_state: Battery | None = None
    power_supply: Battery | None = None
    errors: tuple[VehicleError, ...] | None = None
    safety_state: Safety | None = None

    @property
    def position(self) -> Position | None:
        return self.agv_position or self.mobile_robot_position

    @property
    def battery(self) -> Battery | None:
        return self.battery_state or self.power_supply

    @property
    def actions(self) -> tuple[ActionState, ...]:
        """Actions of orders and instant actions: 2.x has both in one list."""
        return (*(self.action_states or ()), *(self.instant_action_states or ()))

    def action(self, action_id: str) -> ActionState | None:
        """The state of an action; of several with one id the most advanced."""
        states = [state for state in self.actions if state.action_id == action_id]
        return max(states, key=lambda state: _PROGRESS.get(state.action_status or "", -1), default=None)

    @property
    def going_on(self) -> tuple[ActionState, ...]:
        """Actions of `actionStates` that are not over; an action listed twice is over when one entry is."""
        listed = self.action_states or ()
        ended = {state.action_id for state in listed if state.action_status in OVER}
        return tuple(state for state in listed if state.action_id and state.action_id not in ended)

    @property
    def running_instant(self) -> tuple[ActionState, ...]:
        """Instant actions of `instantActionStates` that are not over."""
        return tuple(state for state in self.instant_action_states or () if state.action_status not in OVER)


FINISHED, FAILED, WAITING, RETRIABLE = "FINISHED", "FAILED", "WAITING", "RETRIABLE"
OVER = frozenset({FINISHED, FAILED})

_PROGRESS = {WAITING: 0, RETRIABLE: 1, "INITIALIZING": 2, "PAUSED": 3, "RUNNING": 4, FAILED: 5, FINISHED: 6}
"""The order of progress, since a vehicle may list an action twice; see docs/vehicles.md, behaviour 18."""


class Visualization(Said, frozen=True):
    """The topic `visualization`."""

    agv_position: Position | None = None
    mobile_robot_position: Position | None = None
    velocity: Velocity | None = None

    @property
    def position(self) -> Position | None:
        return self.agv_position or self.mobile_robot_position


class Connection(Said, frozen=True):
    """The topic `connection`: retained, and the vehicle's last will."""

    connection_state: str | None = None

    @property
    def is_away(self) -> bool:
        """Whether it reports the vehicle as offline."""
        word = (self.connection_state or "").replace("_", "")
        return word in {"OFFLINE", "CONNECTIONBROKEN", "HIBERNATING"}


class PhysicalParameters(Said, frozen=True):
    """A part of a factsheet: metres, seconds."""

    speed_max: float | None = None
    maximum_speed: float | None = None
    acceleration_max: float | None = None
    maximum_acceleration: float | None = None
    width: float | None = None
    length: float | None = None


class TypeSpecification(Said, frozen=True):
    """A part of a factsheet."""

    series_name: str | None = None
    max_load_mass: float | None = None
    maximum_load_mass: float | None = None


class FactsheetAction(Said, frozen=True):
    """An action that the vehicle supports."""

    action_type: str | None = None
    action_scopes: tuple[str, ...] | None = None


class ProtocolFeatures(Said, frozen=True):
    """A part of a factsheet."""

    agv_actions: tuple[FactsheetAction, ...] | None = None
    mobile_robot_actions: tuple[FactsheetAction, ...] | None = None

    @property
    def actions(self) -> tuple[FactsheetAction, ...]:
        return self.agv_actions or self.mobile_robot_actions or ()


class Factsheet(Said, frozen=True):
    """The topic `factsheet`."""

    version: str | None = None
    manufacturer: str | None = None
    serial_number: str | None = None
    type_specification: TypeSpecification | None = None
    physical_parameters: PhysicalParameters | None = None
    protocol_features: ProtocolFeatures | None = None

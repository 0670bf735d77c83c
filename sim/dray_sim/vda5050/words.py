"""The messages of a simulated vehicle in its version: state, connection, visualization and factsheet."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

from dray.body import VehicleState
from dray.plant.model import VehicleType
from dray_sim.vda5050.misbehaviour import Misbehaviour
from dray_sim.vda5050.order import NodeAction, Order

EPOCH_S = 1_767_225_600.0
"""The first of January 2026: a vehicle's clock at the beginning of virtual time."""

PREFIXES = {"2.0": "uagv/v2", "2.1": "uagv/v2", "3.0": "vda5050/v3"}


@dataclass
class Condition:
    """A vehicle's state beside its body and its order.

    Attributes:
        errors: (type, level, description, references).
        mode: how it is driven.
        emergency_stop: the active one.
        localised: it knows where it is.
        last_node: as `state` has it.
        last_sequence: likewise.
        past_m: driven since the last node; 0 at a node.
        instant: instant actions, the newest last.
    """

    mode: str = "AUTOMATIC"
    emergency_stop: str = "NONE"
    localised: bool = True
    last_node: str = ""
    last_sequence: int = 0
    past_m: float = 0.0
    errors: list[tuple[str, str, str, dict[str, str]]] = field(default_factory=list)
    instant: list[NodeAction] = field(default_factory=list)
    loads: list[dict[str, str]] | None = None
    """Reported loads instead of the real ones; None for the real ones."""


class Words:
    """The messages of one vehicle.

    Args:
        version: 2.0, 2.1 or 3.0.
        manufacturer: its maker.
        serial: its number.
        map_id: of its poses.
        quirks: its misbehaviour.
    """

    def __init__(
        self, version: str, manufacturer: str, serial: str, map_id: str, quirks: Misbehaviour
    ) -> None:
        self.version, self.map_id, self.quirks = version, map_id, quirks
        self.manufacturer, self.serial = manufacturer, serial
        self.numbers: dict[str, int] = {}

    @property
    def prefix(self) -> str:
        """Prefix of its topics."""
        return f"{PREFIXES[self.version]}/{self.manufacturer}/{self.serial}"

    def header(self, topic: str, now_s: float) -> dict[str, Any]:
        number = self.numbers[topic] = self.numbers.get(topic, -1) + 1
        moment = datetime.fromtimestamp(EPOCH_S + now_s + self.quirks.clock_off_s, UTC)
        time = moment.isoformat(timespec="milliseconds").replace("+00:00", "" if self.quirks.no_zone else "Z")
        return {
            "headerId": number,
            "timestamp": time,
            "version": f"{self.version}.0",
            "manufacturer": self.manufacturer,
            "serialNumber": self.serial,
        }

    def connection(self, word: str, now_s: float) -> dict[str, Any]:
        if self.version == "3.0" and word == "CONNECTIONBROKEN":
            word = "CONNECTION_BROKEN"
        return {**self.header("connection", now_s), "connectionState": word}

    def visualization(self, body: VehicleState, now_s: float) -> dict[str, Any]:
        said = {**self.header("visualization", now_s), **self._position(body, localised=True)}
        return said | (
            {"referenceStateHeaderId": self.numbers.get("state", 0)} if self.version == "3.0" else {}
        )

    def state(
        self, body: VehicleState, order: Order | None, condition: Condition, now_s: float
    ) -> dict[str, Any]:
        quirks, new = self.quirks, self.version == "3.0"
        said: dict[str, Any] = {
            **self.header("state", now_s),
            "orderId": "" if order is None else order.id,
            "orderUpdateId": 0 if order is None else order.update,
            "lastNodeId": condition.last_node,
            "lastNodeSequenceId": condition.last_sequence,
            "distanceSinceLastNode": condition.past_m,
            "driving": body.speed_mps > 0.0,
            "paused": body.held and not quirks.ignores_pause,
            "operatingMode": condition.mode,
            "nodeStates": self._nodes(order),
            "edgeStates": self._edges(order),
            "errors": [self._error(*error) for error in condition.errors],
            "information": [],
        }
        charge = round(body.battery_frac, 4) if quirks.battery_of_1 else round(100.0 * body.battery_frac, 2)
        if new:
            said["powerSupply"] = {"stateOfCharge": charge, "charging": body.charging}
            said["safetyState"] = {"activeEmergencyStop": condition.emergency_stop, "fieldViolation": False}
        else:
            said["batteryState"] = {"batteryCharge": charge, "charging": body.charging}
            said["safetyState"] = {"eStop": condition.emergency_stop, "fieldViolation": False}
        actions = [self._action(action) for action in (order.actions if order is not None else [])]
        if quirks.actions_twice:
            actions += [{**action, "actionStatus": "WAITING"} for action in actions]
        instant = [self._action(action) for action in condition.instant]
        said["actionStates"] = actions if new else actions + instant
        if new:
            said["instantActionStates"] = instant
        if not quirks.no_loads:
            truth = [{"loadType": body.load, "loadId": f"{body.load}-1"}] if body.load else []
            said["loads"] = truth if condition.loads is None else condition.loads
        if not quirks.no_pose_in_state:
            said |= self._position(body, localised=condition.localised)
        if quirks.numbers_as_text:
            said["orderUpdateId"] = str(said["orderUpdateId"])
            said["information"] = None
            said["unheardOf"] = {"x": [1, 2, None]}
        return said

    def factsheet(self, kind: VehicleType, now_s: float) -> dict[str, Any]:
        new = self.version == "3.0"
        robot = "mobileRobot" if new else "agv"
        actions = []
        for name in ("pick", "waitForTrigger", "drop", "startCharging"):
            action: dict[str, Any] = {"actionType": name, "actionScopes": ["NODE"]}
            actions.append(action | ({"pauseAllowed": True, "cancelAllowed": True} if new else {}))
        limits = {
            "minimumSpeed" if new else "speedMin": 0.05,
            "maximumSpeed" if new else "speedMax": kind.max_speed_mps,
            "maximumAcceleration" if new else "accelerationMax": kind.acceleration_mps2,
            "maximumDeceleration" if new else "decelerationMax": kind.acceleration_mps2,
            "minimumHeight" if new else "heightMin": 0.3,
            "maximumHeight" if new else "heightMax": 0.5,
        }
        return {
            **self.header("factsheet", now_s),
            "typeSpecification": {
                "seriesName": kind.name,
                f"{robot}{'Kinematics' if new else 'Kinematic'}": "DIFFERENTIAL" if new else "DIFF",
                f"{robot}Class": "CARRIER",
                "maximumLoadMass" if new else "maxLoadMass": 50.0,
                "localizationTypes": ["NATURAL"],
                "navigationTypes": ["VIRTUAL_LINE_GUIDED"],
            },
            "physicalParameters": {**limits, "width": kind.width_m, "length": kind.length_m},
            "protocolLimits": {
                "maximumStringLengths" if new else "maxStringLens": {},
                "maximumArrayLengths" if new else "maxArrayLens": {},
                "timing": {
                    "minimumOrderInterval" if new else "minOrderInterval": 0.1,
                    "minimumStateInterval" if new else "minStateInterval": 0.1,
                },
            },
            "protocolFeatures": {"optionalParameters": [], f"{robot}Actions": actions},
            f"{robot}Geometry": {},
            "loadSpecification": {},
        }

    def _position(self, body: VehicleState, *, localised: bool) -> dict[str, Any]:
        pose, new = body.pose, self.version == "3.0"
        position = {"x": pose.x_m, "y": pose.y_m, "theta": pose.heading_rad, "mapId": self.map_id}
        position["localized" if new else "positionInitialized"] = localised
        velocity = {"vx": body.speed_mps, "vy": 0.0, "omega": 0.0}
        return {"mobileRobotPosition" if new else "agvPosition": position, "velocity": velocity}

    def _nodes(self, order: Order | None) -> list[dict[str, Any]]:
        if order is None:
            return []
        left = [] if order.cancelled else order.points[order.reached + 1 :]
        if self.quirks.keeps_node_states and not left:
            left = order.points[-1:]
        return [
            {"nodeId": point.id, "sequenceId": point.sequence, "released": point.released} for point in left
        ]

    def _edges(self, order: Order | None) -> list[dict[str, Any]]:
        if order is None or order.cancelled:
            return []
        here = order.points[order.reached].sequence if order.reached >= 0 else -1
        return [
            {"edgeId": name, "sequenceId": sequence, "released": released}
            for name, sequence, released in order.edges
            if sequence > here
        ]

    def _action(self, action: NodeAction) -> dict[str, Any]:
        said = {"actionId": action.id, "actionType": action.type, "actionStatus": action.status}
        if action.result:
            said["actionResult" if self.version == "3.0" else "resultDescription"] = action.result
        return said

    def _error(self, kind: str, level: str, text: str, references: dict[str, str]) -> dict[str, Any]:
        pairs = [{"referenceKey": key, "referenceValue": value} for key, value in references.items()]
        return {
            "errorType": kind,
            "errorLevel": level,
            "errorDescription": text,
            "errorReferences": pairs,
        }

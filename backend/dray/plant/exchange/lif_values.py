"""The values of a LIF document, read leniently: missing, wrong or unknown ones are reported with their JSON pointers."""

from __future__ import annotations

from math import isfinite
from typing import Any

from dray.plant.exchange.notes import Notes
from dray.plant.exchange.track_layout import Spot
from dray.plant.file.reasons import Reason

Json = dict[str, Any]

NODE_USED = frozenset({"nodeId", "nodePosition"})
EDGE_USED = frozenset({"edgeId", "startNodeId", "endNodeId"})
STATION_USED = frozenset({"stationId", "stationName", "interactionNodeIds"})
TYPE_PROPERTIES = ("vehicleTypeNodeProperties", "vehicleTypeEdgeProperties")
NEW_TYPE_PROPERTIES = ("mobileRobotTypeNodeProperties", "mobileRobotTypeEdgeProperties")
TYPES = ("vehicleTypeIds", "vehicleTypeId", "mobileRobotTypes", "mobileRobotTypeIds", "mobileRobotTypeId")
"""Names of the versions for the types of vehicles of a property. A file has one of them."""
ACTIONS = ("actions", "requiredActions", "feasibleActions")
"""Names of the actions of vehicles there: `actions` until 2.0.0, which distinguishes required and possible ones."""

NAMED = {
    "metaInformation": {"projectIdentification", "lifId", "creator", "exportTimestamp", "lifVersion"},
    "origin": {"originId", "originDescriptor", "originDescription", "layouts"},
    "layout": {
        *(
            "layoutId",
            "layoutName",
            "layoutVersion",
            "layoutLevelId",
            "layoutDescription",
            "layoutDescriptor",
        ),
        *("nodes", "edges", "stations"),
    },
    "node": {
        *NODE_USED,
        *("nodeName", "nodeDescription", "nodeDescriptor", "mapId", "vehicleTypeNodeProperties"),
        "mobileRobotTypeNodeProperties",
    },
    "edge": {
        *EDGE_USED,
        *("edgeName", "edgeDescription", "edgeDescriptor", "vehicleTypeEdgeProperties"),
        "mobileRobotTypeEdgeProperties",
    },
    "station": {
        *STATION_USED,
        *("stationDescription", "stationDescriptor", "stationHeight", "stationPosition", "stationType"),
    },
    "node property": {
        *(*TYPES, *ACTIONS, "theta", "loadRestriction", "forbiddenActionTypes"),
        *("maximumAllowedDeviation", "allowedDeviationXY", "allowedDeviationTheta"),
    },
    "edge property": {
        *(*TYPES, *ACTIONS, "vehicleOrientation", "mobileRobotOrientations", "forbiddenActionTypes"),
        *("orientationType", "rotationAllowed", "rotationAtStartNodeAllowed", "rotationAtEndNodeAllowed"),
        *("maxSpeed", "maximumSpeed", "maxRotationSpeed", "maximumRotationSpeed", "minHeight", "maxHeight"),
        *("loadRestriction", "trajectory", "physicalLineGuidedProperty", "reentryAllowed"),
        *("reachOrientationBeforeEntering", "corridor", "minimumLoadHandlingDeviceHeight"),
        *("maximumMobileRobotHeight", "direction"),
    },
}
"""Names of the standard, by kind of object. All others are unknown."""

NOT_IN_A_PLANT = {
    "theta": "how a vehicle stands at a node",
    "loadRestriction": "who may drive there with or without a load",
    "vehicleOrientation": "how a vehicle is turned on a lane",
    "mobileRobotOrientations": "how a vehicle is turned on a lane",
    "rotationAtStartNodeAllowed": "where a vehicle may turn",
    "rotationAtEndNodeAllowed": "where a vehicle may turn",
    "maxRotationSpeed": "the speed of turning",
    "maximumRotationSpeed": "the speed of turning",
    "rotationAllowed": "where a vehicle may turn",
    "orientationType": "how a vehicle is turned on a lane",
    "reachOrientationBeforeEntering": "where a vehicle may turn",
    "direction": "how a guided vehicle leaves a fork",
    "maximumAllowedDeviation": "how exactly a vehicle stands at a node",
    "allowedDeviationXY": "how exactly a vehicle stands at a node",
    "allowedDeviationTheta": "how exactly a vehicle stands at a node",
    "minimumLoadHandlingDeviceHeight": "heights",
    "maximumMobileRobotHeight": "heights",
    "minHeight": "heights",
    "maxHeight": "heights",
    "stationHeight": "heights",
    **dict.fromkeys(ACTIONS, "actions, other than to tell chargers and parking places"),
    "physicalLineGuidedProperty": "guide lines",
    "reentryAllowed": "where vehicles are taken in",
    "corridor": "corridors",
    "forbiddenActionTypes": "actions that are forbidden",
    "stationType": "what a station is called to vehicles",
}
"""Known values that are kept in the mapping, and not in a plant file, with their meanings. Names and descriptions are
left out."""


class Admitted:
    """The types of vehicles that the properties of a node or an edge name; all, where a property names none."""

    def __init__(self) -> None:
        self._types: dict[str, None] = {}
        self._all = False

    def add(self, types: list[str]) -> None:
        """Add the types of one entry."""
        self._types.update(dict.fromkeys(types))
        self._all = self._all or not types

    @property
    def listed(self) -> list[str]:
        """Empty for all."""
        return [] if self._all else list(self._types)


class LifValues:
    """Reads values, and reports oddities."""

    def __init__(self, notes: Notes) -> None:
        self._notes = notes

    def _actions(self, each: Json, at: str) -> list[str]:
        return [
            str(action.get("actionType", action.get("actionName", ""))).lower()
            for key in ACTIONS
            for _, action in self._objects(each, key, at, quiet=True)
        ]

    def _properties(self, of: Json, old: str, new: str, at: str) -> list[tuple[str, Json]]:
        key = new if new in of else old
        if key not in of:
            self._notes.add(at, Reason("note_missing_types_vehicles_may_use", old=old))
            return []
        if of[key] == []:
            self._notes.add(
                f"{at}/{key}",
                Reason("note_empty_types_vehicles_may_use", key=key),
            )
        return self._objects(of, key, at)

    def _strange(self, of: Json, kind: str, at: str) -> None:
        for key in of:
            if key not in NAMED[kind] and key.strip() in NAMED[kind]:
                self._notes.add(at, Reason("note_blank_its_name_not_read", key=key, of=_a(kind)))
            elif key not in NAMED[kind]:
                self._notes.add(
                    f"{at}/{key}", Reason("note_not_understood_kept_mapping_2", key=key, of=_a(kind))
                )
            elif key in NOT_IN_A_PLANT and of[key] not in (None, []):
                text = Reason(
                    "note_no_field_plant_kept_mapping", key=key, of=_a(kind), about=NOT_IN_A_PLANT[key]
                )
                self._notes.add(f"{at}/{key}", text)

    def _rest(self, of: Json, used: frozenset[str] | set[str]) -> Json:
        return {key: value for key, value in of.items() if key not in used}

    def _object(self, of: Json, key: str, at: str) -> Json:
        value = of.get(key)
        if isinstance(value, dict):
            return value
        self._notes.add(f"{at}/{key}", Reason("note_missing_or_no_object", key=key))
        return {}

    def _objects(self, of: Json, key: str, at: str, *, quiet: bool = False) -> list[tuple[str, Json]]:
        """The objects of a list, each with its pointer."""
        value = of.get(key)
        if value is None and (quiet or key in of):
            return []
        if not isinstance(value, list):
            if not quiet:
                self._notes.add(f"{at}/{key}", Reason("note_missing_or_no_list", key=key))
            return []
        found = []
        for index, each in enumerate(value):
            if isinstance(each, dict):
                found.append((f"{at}/{key}/{index}", each))
            elif not quiet:
                self._notes.add(f"{at}/{key}/{index}", Reason("note_entry_no_object_left_out", key=key))
        return found

    def _id(self, of: Json, key: str, at: str) -> str:
        name = key_of(of.get(key))
        if not name:
            self._notes.add(f"{at}/{key}", Reason("note_missing", key=key))
        elif not isinstance(of[key], str):
            self._notes.add(f"{at}/{key}", Reason("note_number_where_text_belongs", key=key))
        return name

    def _number(self, of: Json, key: str, at: str) -> float | None:
        value = of.get(key)
        if value is None:
            return None
        number = number_of(value)
        if number is None:
            self._notes.add(f"{at}/{key}", Reason("note_no_number", key=key, value=str(value)[:40]))
        elif isinstance(value, str):
            self._notes.add(f"{at}/{key}", Reason("note_number_written_as_text", key=key))
        return number

    def _raw_spot(self, position: object) -> Spot | None:
        if not isinstance(position, dict):
            return None
        x, y = number_of(position.get("x")), number_of(position.get("y"))
        return None if x is None or y is None else (x, y)


def key_of(value: object) -> str:
    """An id as text; empty where there is none."""
    return str(value) if isinstance(value, str | int) and not isinstance(value, bool) else ""


def number_of(value: object) -> float | None:
    """A finite number, also one that is written as text; None for anything else."""
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        return None
    try:
        number = float(value)
    except (ValueError, OverflowError):
        return None
    return number if isfinite(number) else None


def _a(kind: str) -> str:
    return f"an {kind}" if kind.startswith(("e", "o")) else f"a {kind}"

"""Reading LIF, the Layout Interchange Format of VDMA: 1.0.0 of March 2024, its drafts before, and 2.0.0 of September 2026 with origins.

Few files keep to the format, so reading is lenient. Numbers may be text, types of vehicles may have the names of any
version, and missing values are reported. Metres; a file that can only be in millimetres is read so, and that is said.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from math import hypot, inf

import msgspec

from dray.plant.exchange import curves
from dray.plant.exchange.curves import CurveError
from dray.plant.exchange.lif_units import FASTEST_MPS, scales
from dray.plant.exchange.lif_values import (
    EDGE_USED,
    NEW_TYPE_PROPERTIES,
    NODE_USED,
    STATION_USED,
    TYPE_PROPERTIES,
    TYPES,
    Admitted,
    Json,
    LifValues,
    key_of,
    number_of,
)
from dray.plant.exchange.notes import Notes
from dray.plant.exchange.track_layout import (
    Spot,
    TrackEdge,
    TrackLayout,
    TrackNode,
    TrackStation,
    TrackVehicleType,
)
from dray.plant.file.reasons import Reason

CREATOR = "Dray"
"""The creator in files of `lif_export`."""

MAJORS = frozenset({"0", "1", "2"})
"""Of the versions that are read: drafts call themselves 0.11.0, for example."""

KNOWN_VERSIONS = "0.x, 1.x, 2.x"

TOLD_TWICE_M = 0.05
"""A node that two layouts have under one id at one spot is one node."""

SNAP_M = 0.5
"""A trajectory that begins or ends nearer to its node is moved there; another one belongs to something else."""


def read_lif(data: Json, notes: Notes, *, unit: str = "", layouts: tuple[str, ...] = ()) -> TrackLayout:
    """A LIF document as a layout.

    Args:
        data: the decoded JSON.
        notes: takes reports of oddities.
        unit: `m`, `cm` or `mm`; found out if it is empty.
        layouts: the ids of the wanted ones; empty for all.

    Raises:
        ValueError: its speeds are impossible for vehicles, and nothing tells its unit.
    """
    return _Reader(data, notes, unit, layouts).read()


class _Reader(LifValues):
    def __init__(self, data: Json, notes: Notes, unit: str, layouts: tuple[str, ...]) -> None:
        super().__init__(notes)
        self._data, self._unit, self._wanted = data, unit, layouts
        self._types: dict[str, TrackVehicleType] = {}
        self._scale, self._speed_scale, self._fastest_mps = 1.0, 1.0, FASTEST_MPS
        self._own: dict[str, dict[str, str]] = {}
        """Pointer of a layout -> its names of nodes -> ids that no other layout has."""

    def read(self) -> TrackLayout:
        meta = self._object(self._data, "metaInformation", "")
        self._strange(meta, "metaInformation", "/metaInformation")
        version = str(meta.get("lifVersion") or "")
        if not version:
            self._notes.add("/metaInformation", Reason("note_does_not_say_its_lifversion"))
        elif version.partition(".")[0] not in MAJORS:
            self._notes.add(
                "/metaInformation/lifVersion",
                Reason("note_lif_version_none_read_as", version=version[:32], known=KNOWN_VERSIONS),
            )
        name = str(meta.get("projectIdentification") or meta.get("lifId") or "Imported layout")
        for key in self._data.keys() - {"metaInformation", "layouts", "origins"}:
            self._notes.add(f"/{key}", Reason("note_not_understood_kept_mapping", key=key))
        found = TrackLayout(
            f"LIF {version}".strip(),
            name,
            meta.get("creator") == CREATOR,
            kept=self._rest(self._data, {"layouts", "origins"}),
        )
        layouts = list(self._layouts(found))
        if found.ours:
            self._fastest_mps = inf
        else:
            self._scale, self._speed_scale = scales(*self._measures(layouts), self._unit, self._notes)
        for level, pointer, layout in layouts:
            self._nodes(layout, pointer, level, found)
        for _, pointer, layout in layouts:
            self._edges(layout, pointer, found)
            self._stations(layout, pointer, found)
        found.vehicle_types = list(self._types.values())
        return found

    # --- layouts -----------------------------------------------------------------------------------

    def _origins(self, found: TrackLayout) -> Iterator[tuple[str, str, Json]]:
        """Id, pointer and content of every origin; before 2.0.0 all layouts have one, which has no id."""
        if "origins" not in self._data:
            yield "", "", self._data
            return
        for at, origin in self._objects(self._data, "origins", ""):
            self._strange(origin, "origin", at)
            found.kept.setdefault("origins", []).append(self._rest(origin, {"layouts"}))
            # An origin without an id is a separate one: its layouts must not overlap those of another.
            yield f"{self._id(origin, 'originId', at) or at}/", at, origin

    def _layouts(self, found: TrackLayout) -> Iterator[tuple[str, str, Json]]:
        """Level, pointer and content of every layout that is wanted."""
        seen = set()
        for origin_id, origin_at, origin in self._origins(found):
            for at, layout in self._objects(origin, "layouts", origin_at):
                name = str(layout.get("layoutId") or "")
                seen.add(name)
                if self._wanted and name not in self._wanted:
                    self._notes.add(at, Reason("note_layout_left_out_as_asked", name=name))
                    continue
                self._strange(layout, "layout", at)
                found.kept.setdefault("layouts", []).append(
                    self._rest(layout, {"nodes", "edges", "stations"})
                )
                first = next((node for _, node in self._objects(layout, "nodes", at, quiet=True)), {})
                level = str(layout.get("layoutLevelId") or first.get("mapId") or "")
                yield f"{origin_id}{level}", at, layout
        for name in self._wanted:
            if name not in seen:
                self._notes.add("/layouts", Reason("note_there_no_layout", name=name))

    def _measures(self, layouts: list[tuple[str, str, Json]]) -> tuple[list[float], list[float]]:
        """The lengths of edges and the speeds on them, as the file has them."""
        lengths, speeds = [], []
        for _, at, layout in layouts:
            spots = {
                key_of(node.get("nodeId")): spot
                for _, node in self._objects(layout, "nodes", at, quiet=True)
                if (spot := self._raw_spot(node.get("nodePosition"))) is not None
            }
            for _, edge in self._objects(layout, "edges", at, quiet=True):
                start, end = (spots.get(key_of(edge.get(key))) for key in ("startNodeId", "endNodeId"))
                if start and end and start != end:
                    lengths.append(hypot(end[0] - start[0], end[1] - start[1]))
                for key in (NEW_TYPE_PROPERTIES[1], TYPE_PROPERTIES[1]):
                    for _, each in self._objects(edge, key, at, quiet=True):
                        speed = number_of(each.get("maxSpeed", each.get("maximumSpeed")))
                        if speed is not None and speed > 0.0:
                            speeds.append(speed)
        return lengths, speeds

    # --- nodes, edges, stations ------------------------------------------------------------------------

    def _nodes(self, layout: Json, pointer: str, level: str, found: TrackLayout) -> None:
        known = {node.original: node for node in found.nodes}
        own = self._own[pointer] = {}
        for at, node in self._objects(layout, "nodes", pointer):
            name, spot = self._id(node, "nodeId", at), self._spot(node, "nodePosition", at)
            if not name or spot is None:
                continue
            if name in own:
                self._notes.add(at, Reason("note_node_there_already_left_out", name=name))
                continue
            other = known.get(name)
            if other is not None and other.level == level and _near(other, spot):
                self._notes.add(at, Reason("note_node_stands_two_layouts_spot", name=name))
                own[name] = name
                continue
            key = name if other is None else self._another(name, layout, known)
            if other is not None:
                self._notes.add(at, Reason("note_node_stands_another_layout_too", name=name))
            own[name] = key
            self._strange(node, "node", at)
            actions, types = [], Admitted()
            for where, each in self._properties(node, TYPE_PROPERTIES[0], NEW_TYPE_PROPERTIES[0], at):
                self._strange(each, "node property", where)
                types.add(self._types_of(each, where))
                actions += self._actions(each, where)
                theta = self._number(each, "theta", where)
                if theta is not None and abs(theta) > 6.3:
                    self._notes.add(f"{where}/theta", Reason("note_theta_more_than_turn_radians"))
            known[key] = TrackNode(
                key,
                at,
                *spot,
                level,
                parks=any("park" in action for action in actions),
                charges=any("charg" in action for action in actions),
                types=types.listed,
                kept={"layoutId": layout.get("layoutId"), **self._rest(node, NODE_USED)},
                called="" if key == name else name,
                map=key_of(node.get("mapId"))[:200],
            )
            found.nodes.append(known[key])

    def _another(self, name: str, layout: Json, known: dict[str, TrackNode]) -> str:
        """An id for a node whose own one is another node's."""
        key = f"{name}-{layout.get('layoutId') or 'other'}"
        while key in known:
            key += "'"
        return key

    def _node_of(self, name: str, pointer: str, at: str) -> str:
        """The node of a name in a layout: its own one, else that of the only other layout with one."""
        own = self._own[pointer]
        if name in own:
            return own[name]
        others = list(dict.fromkeys(names[name] for names in self._own.values() if name in names))
        if len(others) > 1:
            self._notes.add(at, Reason("note_node_stands_several_other_layouts", name=name))
        return others[0] if others else ""

    def _edges(self, layout: Json, pointer: str, found: TrackLayout) -> None:
        spots = {node.original: (node.x_m, node.y_m) for node in found.nodes}
        for at, edge in self._objects(layout, "edges", pointer):
            start, end = key_of(edge.get("startNodeId")), key_of(edge.get("endNodeId"))
            name = self._id(edge, "edgeId", at) or f"{start} to {end}"
            self._strange(edge, "edge", at)
            meant = [(named, self._node_of(named, pointer, at)) for named in (start, end)]
            if missing := [named for named, key in meant if not key]:
                self._notes.add(at, Reason("note_edge_left_out_there_no", name=name, node=missing[0]))
                continue
            (_, start), (_, end) = meant
            limits: dict[str, float] = {}
            admitted = Admitted()
            corners: list[Spot] | None = None
            for where, each in self._properties(edge, TYPE_PROPERTIES[1], NEW_TYPE_PROPERTIES[1], at):
                self._strange(each, "edge property", where)
                types = self._types_of(each, where)
                admitted.add(types)
                key = "maxSpeed" if "maxSpeed" in each else "maximumSpeed"
                limit = self._number(each, key, where)
                if limit is not None and limit <= 0.0:
                    self._notes.add(f"{where}/{key}", Reason("note_speed_none_no_limit_taken", limit=limit))
                elif limit is not None and limit * self._speed_scale > self._fastest_mps:
                    self._notes.add(
                        f"{where}/{key}",
                        Reason("note_speed_cannot_no_limit_taken", limit_mps=limit * self._speed_scale),
                    )
                elif limit is not None:
                    limit = limit if self._speed_scale == 1.0 else round(limit * self._speed_scale, 6)
                    for kind in types or [""]:
                        limits[kind] = limit
                        if kind and (self._types[kind].max_speed_mps or 0.0) < limit:
                            self._types[kind].max_speed_mps = limit
                if each.get("trajectory") is not None and each.get("physicalLineGuidedProperty") is not None:
                    self._notes.add(where, Reason("note_lane_trajectory_or_guide_line"))
                if each.get("trajectory") is not None:
                    own = self._curve(each["trajectory"], f"{where}/trajectory", spots[start], spots[end])
                    if corners is not None and own is not None and own != corners:
                        self._notes.add(where, Reason("note_types_vehicles_have_trajectories_their"))
                    corners = own if corners is None else corners
            kept = self._rest(edge, EDGE_USED)
            found.edges.append(
                TrackEdge(name, at, start, end, corners or [], limits, admitted.listed, kept=kept)
            )

    def _curve(self, curve: object, at: str, start: Spot, end: Spot) -> list[Spot] | None:
        """The corners of a trajectory between its ends; None for an unusable one."""
        if not isinstance(curve, dict):
            self._notes.add(at, Reason("note_trajectory_no_object_lane_taken"))
            return None
        points = []
        for where, point in self._objects(curve, "controlPoints", at):
            x, y = self._number(point, "x", where), self._number(point, "y", where)
            weight = self._number(point, "weight", where)
            if x is None or y is None:
                self._notes.add(where, Reason("note_control_point_no_place_lane"))
                return None
            points.append((x * self._scale, y * self._scale, 1.0 if weight is None else weight))
        degree = self._number(curve, "degree", at)
        told = curve.get("knotVector")
        knots = [number_of(knot) for knot in told] if isinstance(told, list) else []
        try:
            corners = curves.nurbs(
                1 if degree is None else int(degree), [knot for knot in knots if knot is not None], points
            )
        except CurveError as error:
            self._notes.add(at, Reason("note_trajectory_no_curve_lane_taken", error=error))
            return None
        gaps_m = [hypot(a[0] - b[0], a[1] - b[1]) for a, b in ((corners[0], start), (corners[-1], end))]
        if max(gaps_m) > SNAP_M:
            self._notes.add(at, Reason("note_trajectory_off_its_node_lane", gap_m=max(gaps_m)))
            return None
        if max(gaps_m) > 0.01:
            self._notes.add(at, Reason("note_trajectory_little_off_its_nodes"))
        if degree not in (None, 1.0) and curves.is_straight([start, *corners[1:-1], end]):
            return []
        return corners[1:-1]

    def _stations(self, layout: Json, pointer: str, found: TrackLayout) -> None:
        if "stations" not in layout:
            self._notes.add(pointer, Reason("note_layout_no_stations"))
            return
        nodes = {node.original: node for node in found.nodes}
        for at, station in self._objects(layout, "stations", pointer):
            name = self._id(station, "stationId", at)
            if not name:
                continue
            self._strange(station, "station", at)
            self._number(station, "stationHeight", at)
            at_nodes = station.get("interactionNodeIds")
            listed = at_nodes if isinstance(at_nodes, list) else [] if at_nodes is None else [at_nodes]
            served = []
            for one in map(key_of, listed):
                if key := self._node_of(one, pointer, at):
                    served.append(key)
                else:
                    self._notes.add(
                        f"{at}/interactionNodeIds", Reason("note_station_there_no_node", name=name, one=one)
                    )
            if not served:
                self._notes.add(at, Reason("note_station_left_out_no_node", name=name))
                continue
            found.stations.append(
                TrackStation(
                    name,
                    at,
                    str(station.get("stationName") or name),
                    served,
                    charges=any(nodes[one].charges for one in served),
                    parks=any(nodes[one].parks for one in served),
                    kept=self._rest(station, STATION_USED),
                )
            )

    def _types_of(self, each: Json, at: str) -> list[str]:
        """The types of vehicles that something is for, by any of the names that versions of LIF have for it."""
        named = next((each[key] for key in TYPES if key in each), None)
        types = []
        for one in named if isinstance(named, list) else [named]:
            parts = (
                [one.get(key) for key in ("manufacturer", "seriesName")] if isinstance(one, dict) else [one]
            )
            if name := ".".join(filter(None, map(key_of, parts))):
                types.append(name)
        if not types:
            self._notes.add(at, Reason("note_not_said_type_vehicle_taken"))
        for kind in types:
            self._types.setdefault(kind, TrackVehicleType(kind))
        return types

    def _spot(self, of: Json, key: str, at: str) -> Spot | None:
        position = of.get(key)
        if not isinstance(position, dict):
            self._notes.add(f"{at}/{key}", Reason("note_node_without_left_out", key=key))
            return None
        x, y = (self._number(position, axis, f"{at}/{key}") for axis in ("x", "y"))
        if x is None or y is None:
            self._notes.add(f"{at}/{key}", Reason("note_node_whose_no_x_y", key=key))
            return None
        if max(abs(x), abs(y)) * self._scale > curves.FAR_M:
            self._notes.add(
                f"{at}/{key}", Reason("note_node_further_than_km_away", far_km=curves.FAR_M / 1000)
            )
            return None
        return x * self._scale, y * self._scale


def _near(node: TrackNode, spot: Spot) -> bool:
    return hypot(node.x_m - spot[0], node.y_m - spot[1]) <= TOLD_TWICE_M


def decode(text: str) -> Json:
    """The document of a JSON text.

    Raises:
        ValueError: it is none.
    """
    if not text:
        raise ValueError("it is empty: choose a LIF file (JSON) or a plant model of openTCS (XML)")
    try:
        data = msgspec.json.decode(text.encode())
    except UnicodeEncodeError:
        raise ValueError("not JSON: half of a character stands in it") from None
    except RecursionError:
        raise ValueError("not JSON of a layout: nested too deep") from None
    except msgspec.DecodeError as error:
        if text[:1] not in ("{", "["):
            raise ValueError(
                "it is neither JSON, as a LIF file is, nor XML, as a plant model of openTCS is"
            ) from None
        raise ValueError(f"not JSON: {_where(text, str(error))}") from None
    if not isinstance(data, dict) or not {"layouts", "origins"} & data.keys():
        raise ValueError("no LIF file: there is no `layouts` in it; nor is it XML of openTCS")
    return data


def _where(text: str, error: str) -> str:
    """The place of an error of the decoder, which tells it in bytes, as line and column."""
    found = re.search(r"\(byte (\d+)\)", error)
    if found is None:
        return "it ends too soon" if "truncated" in error else "it cannot be read"
    before = text.encode()[: int(found[1])].decode(errors="ignore")
    line, column = before.count("\n") + 1, len(before) - before.rfind("\n")
    rest = text[len(before) :]
    odd = next((word for word in ("NaN", "Infinity", "-Infinity", "nan", "inf") if rest.startswith(word)), "")
    what = f"{odd} is no number of JSON: write null" if odd else "a character stands where none may"
    return f"line {line}, column {column}: {what}"

"""Makes an unfinished plant file of a layout of another system, and a mapping that keeps the other system's data."""

from __future__ import annotations

from math import hypot
from typing import Any

import msgspec

from dray.plant.exchange import curves
from dray.plant.exchange.admission import Admission
from dray.plant.exchange.names import Ids, shown
from dray.plant.exchange.notes import Note, Notes
from dray.plant.exchange.one_spot import merge_spots
from dray.plant.exchange.original_names import OriginalNames
from dray.plant.exchange.track_layout import TrackEdge, TrackLayout, TrackNode, TrackStation
from dray.plant.file.check import RESERVED
from dray.plant.file.reasons import Reason

EDGE_M = 2.0
"""Free floor around the outermost nodes."""

GAP_M = 5.0
"""Distance between layouts of different levels, which are laid side by side."""

SAME_M = 0.001
"""Ways there and back that differ by less are one road: systems write numbers with three digits."""

USUAL_MPS = 1.5
"""Limit of a lane without a given one, as in a plant file."""

OPEN = ("materials", "products", "warehouses", "storages", "stations", "machines", "areas")
"""Sections that no layout has."""

Data = dict[str, Any]


class Imported(msgspec.Struct):
    """The result of an import."""

    data: Data
    """A plant file, in which open values are null (`dray.plant.file.unfinished`)."""
    mapping: Data
    """Original ids beside ours, and data without a field in a plant."""
    notes: tuple[Note, ...]


def assemble(layout: TrackLayout, notes: Notes, *, plant: str, name: str) -> Imported:
    """A plant file of a layout.

    Args:
        layout: as it was read.
        notes: takes reports of rejected data.
        plant: the id of the plant.
        name: of the plant, for people.
    """
    if not layout.ours:
        merge_spots(layout, notes)
    return _Assembly(layout, notes).make(plant, name)


class _Assembly:
    def __init__(self, layout: TrackLayout, notes: Notes) -> None:
        self._layout, self._notes = layout, notes
        ids = Ids("n-")
        self._node = {node.original: ids.give(node.original) for node in layout.nodes}
        self._level = {node.original: node.level for node in layout.nodes}
        self._places = Ids("s-", frozenset(RESERVED))
        kinds = Ids("t-")
        self._kind = {kind.original: kinds.give(kind.original) for kind in layout.vehicle_types}
        self._admission = Admission(layout, notes)
        self._shift_m = self._side_by_side()

    def make(self, plant: str, name: str) -> Imported:
        layout = self._layout
        data: Data = {"plant": plant, "name": shown(name), "width_m": 0.0, "height_m": 0.0}
        names = OriginalNames(layout, self._node, self._shift_m, self._notes)
        data["nodes"] = [
            {
                "id": self._node[node.original],
                **self._spot(node.original, node.x_m, node.y_m),
                **names.node(node),
                **_largest(node),
            }
            for node in layout.nodes
        ]
        lanes, lane_map = self._lanes()
        names.name_lanes(lanes, lane_map)
        data["lanes"] = lanes
        spots = [*data["nodes"], *(corner for lane in lanes for corner in lane.get("shape", ()))]
        data["width_m"] = round(max((spot["x_m"] for spot in spots), default=0.0) + EDGE_M, 3)
        data["height_m"] = round(max((spot["y_m"] for spot in spots), default=0.0) + EDGE_M, 3)
        data.update(dict.fromkeys(OPEN))
        places, place_map = self._stations()
        data["chargers"] = places["chargers"] or None
        data["parkings"] = places["parkings"]
        data["unassigned"] = places["unassigned"]
        kinds, kind_map = self._vehicle_types()
        data["vehicle_types"] = kinds or None
        fleet, fleet_map = self._fleet()
        data["fleet"] = fleet or None
        if maps := names.maps():
            data["maps"] = maps
        mapping = {
            "format": layout.format,
            "name": layout.name,
            "moved_m": [
                {"level": level, "x_m": x_m, "y_m": y_m} for level, (x_m, y_m) in self._shift_m.items()
            ],
            "nodes": [
                {"id": self._node[node.original], "original": node.name, "kept": node.kept}
                for node in layout.nodes
            ],
            "lanes": lane_map,
            "places": place_map,
            "vehicle_types": kind_map,
            "fleet": fleet_map,
            "kept": layout.kept,
        }
        return Imported(data, mapping, self._notes.all())

    # --- the floor -----------------------------------------------------------------------------------

    def _side_by_side(self) -> dict[str, tuple[float, float]]:
        """Offset of each level, so that no coordinate is below 0 and levels do not overlap."""
        shifts: dict[str, tuple[float, float]] = {}
        right_m = 0.0
        levels = dict.fromkeys(node.level for node in self._layout.nodes)
        ends = {node.original: node for node in self._layout.nodes}
        for level in levels:
            spots = [(node.x_m, node.y_m) for node in self._layout.nodes if node.level == level]
            for edge in self._layout.edges:
                if ends[edge.start].level == level:
                    spots += edge.corners
            xs_m, ys_m = zip(*spots, strict=True)
            alone = len(levels) == 1
            x_m = _shift_m(min(xs_m), max(xs_m)) if alone else right_m + EDGE_M - min(xs_m)
            y_m = _shift_m(min(ys_m), max(ys_m)) if alone else EDGE_M - min(ys_m)
            shifts[level] = round(x_m, 6), round(y_m, 6)
            right_m = max(xs_m) + x_m + GAP_M
            if not alone:
                text = Reason(
                    "note_level_laid_beside_others_moved", level=level or "(none)", x_m=x_m, y_m=y_m
                )
                self._notes.add("", text)
            elif x_m or y_m:
                self._notes.add("", Reason("note_moved_by_so_floor_begins", x_m=x_m, y_m=y_m))
        return shifts

    def _spot(self, node: str, x_m: float, y_m: float) -> Data:
        """A spot on our floor, of the level of a node."""
        by_x_m, by_y_m = self._shift_m[self._level[node]]
        return {
            "x_m": round(x_m + by_x_m, 6) if by_x_m else x_m,
            "y_m": round(y_m + by_y_m, 6) if by_y_m else y_m,
        }

    def _lanes(self) -> tuple[list[Data], list[Data]]:
        """Lanes, both directions of one road as one where they are alike, and the mapping of them."""
        levels = self._level
        lanes: dict[tuple[str, str], Data] = {}
        told: dict[tuple[str, str], Data] = {}
        for edge, others in self._roads(told):
            ends, back = (edge.start, edge.end), (edge.end, edge.start)
            entries = [
                {
                    "original": one.original,
                    "limits_mps": one.limits_mps,
                    "kept": one.kept,
                    "start": self._node[one.start],
                }
                for one in (edge, *others)
            ]
            if levels[edge.start] != levels[edge.end]:
                self._notes.add(
                    edge.place,
                    Reason("note_edge_leads_another_level_its", edge=edge.original),
                )
                edge.corners = []
            limits = self._admission.limits(edge, others)
            lane = self._lane(edge, limits)
            other = lanes.get(back)
            if other is not None and not other.get("both_ways") and _one_road(other, lane):
                other["both_ways"] = True
                told[ends] = told[back]
                told[back]["original"] += entries
                continue
            lanes[ends] = lane
            told[ends] = {"start": lane["start"], "end": lane["end"], "original": entries}
        mapping = list({id(entry): entry for entry in told.values()}.values())
        return list(lanes.values()), mapping

    def _roads(self, told: dict[tuple[str, str], Data]) -> list[tuple[TrackEdge, list[TrackEdge]]]:
        """The edges that become lanes, each with those that lead beside it from the same node to the same."""
        found: dict[tuple[str, str], tuple[TrackEdge, list[TrackEdge]]] = {}
        for edge in self._layout.edges:
            if edge.start == edge.end:
                self._notes.add(edge.place, Reason("note_edge_leads_back_its_own", edge=edge.original))
                entry = {"original": edge.original, "limits_mps": edge.limits_mps, "kept": edge.kept}
                told[edge.original, ""] = {"original": [entry]}
            elif (first := found.get((edge.start, edge.end))) is not None:
                more = self._admission.beside(first[0], edge)
                text = Reason(
                    "note_edge_second_from_first_taken",
                    edge=edge.original,
                    start=edge.start,
                    end=edge.end,
                    also=Reason("also_for", types=tuple(more)) if more else "",
                )
                self._notes.add(edge.place, text)
                first[1].append(edge)
            else:
                found[edge.start, edge.end] = edge, []
        return list(found.values())

    def _lane(self, edge: TrackEdge, limits: dict[str, float | None]) -> Data:
        lane: Data = {"start": self._node[edge.start], "end": self._node[edge.end]}
        speeds = [limit for limit in limits.values() if limit is not None]
        if not speeds:
            self._notes.add(edge.place, Reason("note_no_speed_told_taken", speed_mps=USUAL_MPS))
        lane["speed_limit_mps"] = top_mps = max(speeds, default=USUAL_MPS)
        if edge.corners:
            lane["shape"] = [self._spot(edge.start, *corner) for corner in edge.corners]
        own = {kind: limit for kind, limit in limits.items() if limit is not None and limit < top_mps}
        if own or self._admission.only_some(limits):
            lane["types"] = [
                {"type": self._kind[kind], **({"speed_limit_mps": own[kind]} if kind in own else {})}
                for kind in limits
            ]
        return lane

    # --- what stands on it --------------------------------------------------------------------------

    def _stations(self) -> tuple[dict[str, list[Data]], list[Data]]:
        places: dict[str, list[Data]] = {"chargers": [], "parkings": [], "unassigned": []}
        mapping: list[Data] = []
        for station in self._layout.stations:
            self._station(station, places, mapping)
        served = {
            node
            for station in self._layout.stations
            for node in (station.nodes if station.parks or station.charges else station.nodes[:1])
        }
        for node in self._layout.nodes:
            if node.original in served or not (node.parks or node.charges):
                continue
            kind = "chargers" if node.charges else "parkings"
            name = self._places.give(f"{'CH' if node.charges else 'P'}-{node.original}")
            place: Data = {"id": name, "node": self._node[node.original]}
            if node.charges:
                place["box"] = None
            places[kind].append(place)
            mapping.append({"id": name, "original": node.original, "section": kind})
        return places, mapping

    def _station(self, station: TrackStation, places: dict[str, list[Data]], mapping: list[Data]) -> None:
        """A place at each node of a station: vehicles of Dray dock at a place at one node."""
        kind = "chargers" if station.charges else "parkings" if station.parks else "unassigned"
        first = self._places.give(station.original)
        count = len(station.nodes)
        for number, node in enumerate(station.nodes, 1):
            name = first if number == 1 else self._places.give(f"{station.original}.{number}")
            place: Data = {"id": name, "node": self._node[node]}
            if kind == "chargers":
                place["box"] = None
            elif kind == "unassigned":
                place["name"] = shown(station.name) or name
                if number > 1:
                    place["name"] = f"{shown(station.name, 70)} ({number} of {count})"
                    place["part_of"] = first
            places[kind].append(place)
            if name != station.original and not self._layout.ours:
                place["original"] = station.original[:200]
            entry = {"id": name, "original": station.original, "section": kind, "node": self._node[node]}
            mapping.append(entry if number > 1 else {**entry, "kept": station.kept})
        if count > 1:
            named = ", ".join(station.nodes)
            text = Reason(
                "note_station_served_from_nodes_place",
                station=station.original,
                count=count,
                named=named,
                also=Reason("remove_some") if kind == "unassigned" else "",
            )
            self._notes.add(station.place, text)

    def _vehicle_types(self) -> tuple[list[Data], list[Data]]:
        kinds, mapping = [], []
        for kind in self._layout.vehicle_types:
            name = self._kind[kind.original]
            made: Data = {
                "id": name,
                "name": shown(kind.original),
                "length_m": kind.length_m,
                "width_m": kind.width_m,
                "max_speed_mps": kind.max_speed_mps,
                "load_s": None,
                "unload_s": None,
                "battery_wh": None,
                "charge_w": None,
            }
            if kind.charging:
                made["charging"] = kind.charging
            kinds.append(made)
            mapping.append({"id": name, "original": kind.original})
        return kinds, mapping

    def _fleet(self) -> tuple[list[Data], list[Data]]:
        fleet, mapping = [], []
        for vehicle in self._layout.vehicles:
            name = self._places.give(vehicle.original)
            node = self._node[vehicle.node] if vehicle.node is not None else None
            fleet.append({"id": name, "type": self._kind[vehicle.kind], "node": node})
            mapping.append({"id": name, "original": vehicle.original, "kept": vehicle.kept})
        return fleet, mapping


def _largest(node: TrackNode) -> Data:
    """The largest vehicle in a node's entry."""
    if node.max_m is None:
        return {}
    return {"max_vehicle": {"length_m": node.max_m[0], "width_m": node.max_m[1]}}


def _shift_m(low_m: float, high_m: float) -> float:
    """Offset of a layout whose nodes are between these; 0 where it lies well."""
    if low_m < 0.0:
        return EDGE_M - low_m
    # Coordinates of a map that begins far away would make a floor that is mostly empty.
    return EDGE_M - low_m if low_m > max(50.0, high_m - low_m) else 0.0


def _one_road(lane: Data, back: Data) -> bool:
    """Whether two lanes are the directions of one road: alike in speed, and in shape to a millimetre."""
    there = [(spot["x_m"], spot["y_m"]) for spot in lane.get("shape", ())]
    here = [(spot["x_m"], spot["y_m"]) for spot in reversed(back.get("shape", ()))]
    if _limits(lane) != _limits(back) or bool(there) != bool(here):
        return False
    if len(there) == len(here):
        return all(hypot(a[0] - b[0], a[1] - b[1]) <= SAME_M for a, b in zip(there, here, strict=True))
    # A curve that is cut elsewhere: its corners lie on the other one, as exactly as corners follow a curve.
    within_m = curves.TOLERANCE_M + SAME_M
    return curves.apart_m(there, here) <= within_m and curves.apart_m(here, there) <= within_m


def _limits(lane: Data) -> tuple[object, ...]:
    types = sorted((each["type"], each.get("speed_limit_mps")) for each in lane.get("types", ()))
    return lane["speed_limit_mps"], tuple(types)

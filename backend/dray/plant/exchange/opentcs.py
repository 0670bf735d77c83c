"""Reading plant models of openTCS: 0.0.4, 0.0.5, 6.0.0 and 7.0.0; for older ones, the parts in common with these.

Millimetres, and millimetres in a second. A path is driven forwards from its source to its destination
(`maxVelocity`). It is driven backwards, with the back of the vehicle ahead, from there to its source
(`maxReverseVelocity`). A speed of 0 forbids a direction. Control points are in units of the drawing, its y axis
downwards.
"""

from __future__ import annotations

from math import isfinite
from typing import Any

from dray.plant.exchange import curves
from dray.plant.exchange.curves import CurveError
from dray.plant.exchange.lif_values import number_of
from dray.plant.exchange.notes import Notes
from dray.plant.exchange.opentcs_drawing import RECHARGE, Drawing, properties_of, scale_by_lengths
from dray.plant.exchange.track_layout import (
    Spot,
    TrackEdge,
    TrackLayout,
    TrackNode,
    TrackStation,
    TrackVehicle,
    TrackVehicleType,
)
from dray.plant.exchange.xml_tree import Element
from dray.plant.file.reasons import Reason

MODELS = ("0.0.4", "0.0.5", "6.0.0", "7.0.0")
"""Versions of openTCS whose files were read."""

M = 0.001
"""A millimetre."""

LENGTH_OFF_FRAC = 0.05
"""Largest difference between a path's length and its drawn shape without a note."""

INITIAL = ("tcs:initialPosition", "loopback:initialPosition", "initialPosition")
"""Properties of a vehicle that name the point where it begins."""

READ = {
    "model": {"version", "name"},
    "point": {
        *("name", "xPosition", "yPosition", "zPosition", "positionX", "positionY", "positionZ", "type", "id"),
        *("vehicleOrientationAngle",),
    },
    "path": {
        *("name", "sourcePoint", "destinationPoint", "length", "maxVelocity", "maxReverseVelocity", "locked"),
        *("routingCost", "id"),
    },
    "location": {
        *(
            "name",
            "xPosition",
            "yPosition",
            "zPosition",
            "positionX",
            "positionY",
            "positionZ",
            "locked",
            "type",
        ),
        *("id",),
    },
    "vehicle": {
        *("name", "length", "energyLevelCritical", "energyLevelGood", "energyLevelFullyRecharged", "id"),
        *("energyLevelSufficientlyRecharged", "maxVelocity", "maxReverseVelocity", "envelopeKey", "type"),
    },
}
"""Attributes that are known, by element."""

CHILDREN = {
    "model": {"point", "path", "vehicle", "locationType", "location", "block", "visualLayout", "property"},
    "point": {"outgoingPath", "property", "pointLayout", "vehicleEnvelope", "maxVehicleBoundingBox"},
    "path": {"property", "pathLayout", "vehicleEnvelope", "peripheralOperation"},
    "location": {"link", "property", "locationLayout"},
    "vehicle": {"property", "vehicleLayout", "boundingBox"},
}


def read_opentcs(model: Element, notes: Notes) -> TrackLayout:
    """A model as a layout; oddities are reported in the notes.

    Raises:
        ValueError: it is no model.
    """
    if model.name != "model":
        raise ValueError(f"an XML file of <{model.name}>: a plant model of openTCS begins with <model>")
    return _Reader(model, notes).read()


class _Reader:
    def __init__(self, model: Element, notes: Notes) -> None:
        self._model, self._notes = model, notes
        self._points: dict[str, Spot] = {}
        self._drawing = Drawing(model)
        self._stretch = 1.0
        """Scale of the drawing, where points are taken from it."""

    def read(self) -> TrackLayout:
        model = self._model
        version = model.attributes.get("version", "")
        if version not in MODELS:
            known = ", ".join(MODELS)
            self._notes.add(
                _at(model),
                Reason("note_model_version_none_read_as", version=version or "(none)", known=known),
            )
        found = TrackLayout(f"openTCS {version}".strip(), model.attributes.get("name") or "Imported layout")
        self._strange(model)
        found.kept = {"properties": properties_of(model)}
        spots = self._spots()
        for point, spot in zip(model.all("point"), spots, strict=True):
            self._point(point, spot, found)
        scales = self._scales(model.first("visualLayout"))
        for path in model.all("path"):
            self._path(path, scales, found)
        self._locations(found)
        self._vehicles(found)
        for block in model.all("block"):
            self._notes.add(_at(block), Reason("note_block_no_place_plant_vehicles"))
            kept = found.kept.setdefault("blocks", [])
            members = [member.attributes.get("name") for member in block.all("member")]
            kept.append({**block.attributes, "members": members})
        return found

    def _spots(self) -> list[Spot | None]:
        """Positions of the points; from the drawing in a model without coordinates."""
        points = self._model.all("point")
        told = [self._spot(point) for point in points]
        drawn = [self._drawing.spot(point) for point in points]
        if len(points) < 2 or len(set(told)) > 1 or len({*drawn} - {None}) < 2:
            return told
        names = [point.attributes.get("name", "") for point in points]
        shown = {name: spot for name, spot in zip(names, drawn, strict=True) if spot is not None}
        self._stretch = scale_by_lengths(self._model, shown)
        times = Reason("stretched", times=self._stretch) if self._stretch != 1.0 else ""
        text = Reason("note_no_point_coordinates_its_own", times=times)
        self._notes.add(_at(points[0]), text)
        far_m = curves.FAR_M / self._stretch
        return [
            None
            if spot is None or max(map(abs, spot)) > far_m
            else (round(spot[0] * self._stretch, 6), round(spot[1] * self._stretch, 6))
            for spot in drawn
        ]

    def _scales(self, drawing: Element | None) -> Spot:
        if drawing is None:
            return 50.0, 50.0
        scales = [self._number(drawing, key) for key in ("scaleX", "scaleY")]
        return (scales[0] or 50.0), (scales[1] or 50.0)

    def _point(self, point: Element, spot: Spot | None, found: TrackLayout) -> None:
        self._strange(point)
        name = point.attributes.get("name", "")
        if not name or spot is None:
            self._notes.add(_at(point), Reason("note_point_without_name_or_position"))
            return
        if name in self._points:
            self._notes.add(_at(point), Reason("note_point_there_already_left_out", name=name))
            return
        kind = point.attributes.get("type", "HALT_POSITION")
        if kind == "REPORT_POSITION":
            self._notes.add(_at(point), Reason("note_vehicles_only_pass_report_position"))
        elif kind not in ("HALT_POSITION", "PARK_POSITION"):
            self._notes.add(_at(point), Reason("note_type_not_understood_taken_as", kind=kind))
        if self._number(point, "positionZ", "zPosition"):
            self._notes.add(_at(point), Reason("note_heights_have_no_field_plant"))
        if (self._number(point, "vehicleOrientationAngle") or 0.0) != 0.0:
            self._notes.add(
                _at(point),
                Reason("note_how_vehicle_stands_point_no"),
            )
        self._points[name] = spot
        kept: dict[str, Any] = {key: value for key, value in point.attributes.items() if key != "name"}
        found.nodes.append(
            TrackNode(
                name,
                _at(point),
                *spot,
                parks=kind == "PARK_POSITION",
                kept={**kept, **_kept(point, self._notes)},
                max_m=self._largest(point),
            )
        )

    def _largest(self, point: Element) -> Spot | None:
        """Length and width of the largest vehicle that may be at a point; None where the model does not give them."""
        box = point.first("maxVehicleBoundingBox")
        if box is None:
            return None
        length, width = self._number(box, "length"), self._number(box, "width")
        if length is None or width is None or min(length, width) <= 0.0:
            self._notes.add(_at(point), Reason("note_maxvehicleboundingbox_without_length_width_all"))
            return None
        if any(self._number(box, key) for key in ("referenceOffsetX", "referenceOffsetY")):
            self._notes.add(
                _at(point),
                Reason("note_maxvehicleboundingbox_taken_about_middle_vehicles"),
            )
        return round(length * M, 6), round(width * M, 6)

    def _path(self, path: Element, scales: Spot, found: TrackLayout) -> None:
        self._strange(path)
        of = path.attributes
        start, end = of.get("sourcePoint", ""), of.get("destinationPoint", "")
        name = of.get("name") or f"{start} --- {end}"
        if missing := [point for point in (start, end) if point not in self._points]:
            self._notes.add(_at(path), Reason("note_path_left_out_there_no", name=name, node=missing[0]))
            return
        kept = {**of, **_kept(path, self._notes)}
        if of.get("locked") == "true":
            self._notes.add(_at(path), Reason("note_locked_path_left_out_lanes"))
            found.kept.setdefault("locked", []).append(kept)
            return
        corners = self._corners(path, scales, self._points[start], self._points[end])
        told_m, drawn_m = (
            self._number(path, "length"),
            curves.length_m([self._points[start], *corners, self._points[end]]),
        )
        if told_m is not None and drawn_m > 0.0 and abs(told_m * M / drawn_m - 1.0) > LENGTH_OFF_FRAC:
            self._notes.add(
                _at(path),
                Reason("note_path_long_by_its_length", name=name, told_m=told_m * M, drawn_m=drawn_m),
            )
        speeds = [(self._number(path, key) or 0.0) * M for key in ("maxVelocity", "maxReverseVelocity")]
        if not any(speeds):
            self._notes.add(_at(path), Reason("note_path_left_out_nobody_may", name=name))
            found.kept.setdefault("locked", []).append(kept)
        if speeds[0] > 0.0:
            found.edges.append(
                TrackEdge(name, _at(path), start, end, corners, {"": round(speeds[0], 6)}, kept=kept)
            )
        if speeds[1] > 0.0:
            self._notes.add(_at(path), Reason("note_path_driven_backwards_lane_other"))
            found.edges.append(
                TrackEdge(name, _at(path), end, start, corners[::-1], {"": round(speeds[1], 6)}, kept=kept)
            )

    def _corners(self, path: Element, scales: Spot, start: Spot, end: Spot) -> list[Spot]:
        kind, drawn = self._drawing.path(path)
        if kind == "DIRECT":
            return []
        points: list[Spot] = []
        for pair in drawn:
            x, y = map(number_of, pair)
            if x is None or y is None:
                self._notes.add(_at(path), Reason("note_control_point_without_place_path"))
                return []
            points.append((x * scales[0] * M * self._stretch, -y * scales[1] * M * self._stretch))
        chain = [start, *points, end]
        try:
            if kind == "POLYPATH":
                return [(round(x, 6), round(y, 6)) for x, y in points]
            if kind == "BEZIER" and len(points) in (1, 2):
                corners = curves.bezier(chain)
            elif kind == "BEZIER_3" and len(points) == 5:
                corners = [*curves.bezier(chain[:4]), *curves.bezier(chain[3:])[1:]]
            else:
                about = f" with {len(points)} control points" if points else ""
                self._notes.add(_at(path), Reason("note_path_drawn_as_taken_as", kind=kind, about=about))
                return []
        except CurveError as error:
            self._notes.add(_at(path), Reason("note_path_no_curve_taken_as", error=error))
            return []
        return [] if curves.is_straight(corners) else [(round(x, 6), round(y, 6)) for x, y in corners[1:-1]]

    def _locations(self, found: TrackLayout) -> None:
        charging = set()
        named = {
            value.lower()
            for vehicle in self._model.all("vehicle")
            for key, value in properties_of(vehicle).items()
            if key.endswith(RECHARGE) and value
        }
        for kind in self._model.all("locationType"):
            symbol = self._drawing.symbol(kind)
            words = [each.attributes.get("name", "") for each in kind.all("allowedOperation")] + [symbol]
            if any(_charges(word) or word.lower() in named for word in words):
                charging.add(kind.attributes.get("name", ""))
            found.kept.setdefault("location_types", []).append({**kind.attributes, "operations": words})
        for location in self._model.all("location"):
            self._strange(location)
            name, kind_name = location.attributes.get("name", ""), location.attributes.get("type", "")
            links = [link.attributes.get("point", "") for link in location.all("link")]
            at_points = [point for point in links if point in self._points]
            for point in links:
                if point not in self._points:
                    self._notes.add(
                        _at(location), Reason("note_location_there_no_point", name=name, point=point)
                    )
            kept = {**location.attributes, "links": links, **_kept(location, self._notes)}
            if location.attributes.get("locked") == "true":
                self._notes.add(_at(location), Reason("note_location_locked_taken_all_same", name=name))
            if not name or not at_points:
                self._notes.add(_at(location), Reason("note_location_left_out_no_link", name=name))
                found.kept.setdefault("locations", []).append(kept)
                continue
            found.stations.append(
                TrackStation(
                    name,
                    _at(location),
                    name,
                    at_points,
                    charges=kind_name in charging or _charges(self._drawing.symbol(location)),
                    kept=kept,
                )
            )

    def _vehicles(self, found: TrackLayout) -> None:
        kinds: dict[tuple[Any, ...], TrackVehicleType] = {}
        for vehicle in self._model.all("vehicle"):
            self._strange(vehicle)
            name = vehicle.attributes.get("name", "")
            if not name:
                self._notes.add(_at(vehicle), Reason("note_vehicle_without_name_left_out"))
                continue
            box = vehicle.first("boundingBox") or vehicle
            length, width = self._number(box, "length"), self._number(box, "width")
            top = self._number(vehicle, "maxVelocity")
            charging = self._charging(vehicle)
            key = (length, width, top, *sorted(charging.items()))
            if key not in kinds:
                kinds[key] = TrackVehicleType(
                    f"type-{len(kinds) + 1}",
                    length * M if length else None,
                    width * M if width else None,
                    top * M if top else None,
                    charging,
                )
            properties = properties_of(vehicle)
            node = next((properties[key] for key in INITIAL if key in properties), None)
            if node is not None and node not in self._points:
                self._notes.add(
                    _at(vehicle), Reason("note_vehicle_begins_there_no_such", name=name, node=node)
                )
                node = None
            kept = {**vehicle.attributes, "properties": properties}
            found.vehicles.append(TrackVehicle(name, kinds[key].original, node, kept))
        found.vehicle_types = list(kinds.values())

    def _charging(self, vehicle: Element) -> dict[str, float]:
        levels = {
            field: level / 100.0
            for field, key in (
                ("must_below_frac", "energyLevelCritical"),
                ("below_frac", "energyLevelGood"),
                ("up_to_frac", "energyLevelFullyRecharged"),
            )
            if (level := self._number(vehicle, key)) is not None
        }
        values = list(levels.values())
        if len(values) < 3:
            return {}
        if not 0.0 <= values[0] <= values[1] - 0.05 <= values[2] - 0.1 <= 0.9:
            self._notes.add(
                _at(vehicle),
                Reason("note_energy_levels_too_near_another"),
            )
            return {}
        return levels

    # --- small things ----------------------------------------------------------------------------------

    def _spot(self, of: Element) -> Spot | None:
        x, y = self._number(of, "positionX", "xPosition"), self._number(of, "positionY", "yPosition")
        if x is None or y is None or max(abs(x), abs(y)) * M > curves.FAR_M:
            return None
        return round(x * M, 6), round(y * M, 6)

    def _number(self, of: Element, *keys: str) -> float | None:
        """The first existing attribute of these; NaN stands for none in openTCS."""
        key = next((key for key in keys if key in of.attributes), None)
        if key is None:
            return None
        try:
            number = float(of.attributes[key])
        except ValueError:
            self._notes.add(_at(of), Reason("note_no_number", key=key, value=of.attributes[key][:40]))
            return None
        return number if isfinite(number) else None

    def _strange(self, of: Element) -> None:
        for key in of.attributes.keys() - READ[of.name]:
            self._notes.add(_at(of), Reason("note_not_understood_kept_mapping_3", key=key, of=of.name))
        for child in of.children:
            if child.name not in CHILDREN[of.name]:
                self._notes.add(
                    _at(child), Reason("note_not_understood_left_out", child=child.name, of=of.name)
                )


def _at(of: Element) -> str:
    name = of.attributes.get("name")
    return f"line {of.line}, <{of.name}{f' {name}' if name else ''}>"


def _charges(word: str) -> bool:
    """Whether an operation or a symbol is one of charging, as `RECHARGE_GENERIC` or `ChargingStation20.png`."""
    return "charg" in word.lower()


def _kept(of: Element, notes: Notes) -> dict[str, Any]:
    """Data without a field in a plant, for the mapping; reported once."""
    kept: dict[str, Any] = {}
    if properties := properties_of(of):
        kept["properties"] = properties
    for name in ("vehicleEnvelope", "maxVehicleBoundingBox", "peripheralOperation"):
        if those := of.all(name):
            kept[name] = [
                {
                    **each.attributes,
                    **({"points": [p.attributes for p in each.children]} if each.children else {}),
                }
                for each in those
            ]
            if name != "maxVehicleBoundingBox":
                notes.add(_at(of), Reason("note_no_place_plant_kept_mapping", name=name))
    return kept

"""An unfinished plant file: its open values, and its drawable part.

A value is open if it is null (`~`, or nothing after the colon) although the plant needs it; so is a station without a
purpose (`Unassigned`). Imported layouts and drafts of the editor are such files. `dray plant check` names all open
values.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from types import NoneType, UnionType
from typing import Annotated, Any, Union, get_args, get_origin

import msgspec

from dray.plant.file.reasons import PART_TEXTS, Reason
from dray.plant.model import Box, Node, PlantFile
from dray.plant.plant import Plant

Fault = tuple[str, str]
"""Field and reason."""

AT_LEAST_M = 1.0
"""Margin of an unmeasured floor beyond its last node, and sides of an unmeasured box."""

HINTED = frozenset(code.removeprefix("hint_") for code in PART_TEXTS if code.startswith("hint_"))
"""Names of fields for which there is a hint."""

BOXED = ("warehouses", "storages", "chargers", "machines")
"""Sections whose entries stand somewhere on the floor."""

PLACEHOLDERS: Mapping[str, object] = {"bill": (), "kind": "source", "makes": (), "name": "", "stocks": ()}
"""Placeholders in a picture for open or wrong fields. An entry is left out if a field of it has neither a placeholder
nor a default."""


def open_points(data: Mapping[str, object]) -> Iterator[Fault]:
    """The open values of a file: nulls in place of values, and unassigned stations."""
    yield from _nulls("", data, PlantFile)
    stations = data.get("unassigned")
    if isinstance(stations, list):
        for index, station in enumerate(stations):
            if isinstance(station, dict) and isinstance(station.get("id"), str):
                yield unassigned_fault(index, station["id"], str(station.get("node")))


def unassigned_fault(index: int, name: str, node: str) -> Fault:
    """The fault of a station without a purpose."""
    return f"unassigned[{index}]", Reason("unassigned", name=name, node=node)


def has_null(value: object) -> bool:
    """Whether something is, or holds, a null."""
    if isinstance(value, dict):
        return any(map(has_null, value.values()))
    return value is None or (isinstance(value, list) and any(map(has_null, value)))


def drawable(data: Mapping[str, object]) -> tuple[Plant, PlantFile | None]:
    """A plant of the drawable part of a file, to be looked at and not to be run.

    Args:
        data: the file, of any shape.

    Returns:
        The plant, without broken references; and the file with its open fields replaced, to check the relations of
            the rest. The file is None where an entry had to be left out, since then its indexes differ.
    """
    whole = True
    sections: dict[str, Any] = {}
    for section in struct_fields(PlantFile):
        kind = entry_type(section.type)
        if kind is None:
            continue
        value = data.get(section.name)
        entries = value if isinstance(value, list) else []
        # A section that is open leaves nothing out.
        whole &= isinstance(value, list) or value is None
        made = [_filled(entry, kind) for entry in entries]
        sections[section.name] = tuple(one for one in made if one is not None)
        whole &= len(sections[section.name]) == len(entries)
    spots = {node.id: node for node in sections["nodes"]}
    for name in BOXED:
        sections[name] = tuple(_boxed(place, spots.get(place.node)) for place in sections[name])
    plain = _plain(data, sections)
    if not sections["vehicle_types"]:
        # The width of a two-lane road is unknown.
        plain["two_lanes"] = False
        sections["lanes"] = tuple(msgspec.structs.replace(lane, two_lanes=None) for lane in sections["lanes"])
    file = PlantFile(**plain, **sections)
    return Plant(PlantFile(**plain, **_connected(sections))), file if whole else None


def bare(kind: object) -> object:
    """A type without its annotations."""
    while get_origin(kind) is Annotated:
        kind = get_args(kind)[0]
    return kind


def entry_type(section: object) -> Any:
    """The type of the entries of a list, as X of ``tuple[X, ...]``, annotated or not; None for anything else."""
    section = bare(section)
    if get_origin(section) is not tuple:
        return None
    entry = bare(get_args(section)[0])
    return entry if _is_struct(entry) else None


@cache
def struct_fields(kind: type[msgspec.Struct]) -> tuple[msgspec.structs.FieldInfo, ...]:
    """The fields of a struct; msgspec evaluates its annotations anew each time."""
    return msgspec.structs.fields(kind)


def _is_struct(kind: object) -> bool:
    return isinstance(kind, type) and issubclass(kind, msgspec.Struct)


def _nulls(where: str, value: object, kind: object) -> Iterator[Fault]:
    kind = bare(kind)
    if get_origin(kind) in (Union, UnionType):
        if value is None and NoneType in get_args(kind):
            return
        kind = next(one for one in get_args(kind) if one is not NoneType)
    if value is None:
        name = where.rpartition(".")[2]
        yield where, Reason("open", hint=Reason(f"hint_{name}" if name in HINTED else "hint"))
    elif isinstance(value, dict) and _is_struct(kind):
        types = {field.name: field.type for field in struct_fields(kind)}
        for name, inner in value.items():
            if name in types:
                yield from _nulls(f"{where}.{name}" if where else name, inner, types[name])
    elif isinstance(value, list) and (entry := entry_type(kind)) is not None:
        for index, inner in enumerate(value):
            yield from _nulls(f"{where}[{index}]", inner, entry)


def _filled(entry: object, kind: Any) -> Any:
    """An entry with its open or wrong values replaced; None where that is impossible."""
    if not isinstance(entry, dict):
        return None
    values: dict[str, object] = {}
    for field in struct_fields(kind):
        if field.name in entry:
            try:
                values[field.name] = msgspec.convert(entry[field.name], field.type)
                continue
            except msgspec.ValidationError:
                pass
        if field.name in PLACEHOLDERS:
            values[field.name] = PLACEHOLDERS[field.name]
        elif field.name in ("station", "type"):
            values[field.name] = ""
        elif field.name == "box" and field.required:
            values[field.name] = None
        elif field.required:
            return None
    return kind(**values)


def _plain(data: Mapping[str, object], sections: Mapping[str, Any]) -> dict[str, Any]:
    """The fields of a file that are no lists."""
    far_m = {
        side: max((getattr(node, axis) for node in sections["nodes"]), default=0.0) + AT_LEAST_M
        for side, axis in (("width_m", "x_m"), ("height_m", "y_m"))
    }
    plain = {
        name: _value(data.get(name), kind, usual)
        for name, kind, usual in (
            ("plant", str, "draft"),
            ("name", str, "Draft"),
            ("width_m", float, far_m["width_m"]),
            ("height_m", float, far_m["height_m"]),
            ("two_lanes", bool, False),
        )
    }
    for side in ("width_m", "height_m"):
        plain[side] = max(plain[side], AT_LEAST_M)
    plain["cell_m"] = max(20.0, plain["width_m"] / 50.0, plain["height_m"] / 50.0)
    return plain


def _connected(sections: Mapping[str, Any]) -> dict[str, Any]:
    """The sections without broken references."""
    nodes = {node.id: node for node in sections["nodes"]}
    types = {kind.id for kind in sections["vehicle_types"]}
    kept: dict[str, Any] = {**sections, "nodes": tuple(nodes.values())}
    ends: set[tuple[str, str]] = set()
    lanes = []
    for lane in sections["lanes"]:
        own = {(lane.start, lane.end), *(((lane.end, lane.start),) if lane.both_ways else ())}
        if lane.start in nodes and lane.end in nodes and lane.start != lane.end and not ends & own:
            ends |= own
            lanes.append(lane)
    kept["lanes"] = tuple(lanes)
    for section in (*BOXED, "unassigned", "parkings", "fleet"):
        kept[section] = tuple(one for one in sections[section] if one.node in nodes)
    joined = ends | {(end, start) for start, end in ends}
    kept["doors"] = tuple(
        door for door in sections["doors"] if all((lane.start, lane.end) in joined for lane in door.lanes)
    )
    products = {product.id for product in sections["products"]}
    kept["machines"] = tuple(
        msgspec.structs.replace(
            machine, makes=tuple(each for each in machine.makes if each.product in products)
        )
        for machine in kept["machines"]
    )
    kept["fleet"] = tuple(one for one in kept["fleet"] if one.type in types)
    return kept


def _boxed(place: Any, node: Node | None) -> Any:
    if place.box is not None:
        return place
    at = (node.x_m, node.y_m) if node is not None else (AT_LEAST_M, AT_LEAST_M)
    return msgspec.structs.replace(place, box=Box(*at, AT_LEAST_M / 2.0, AT_LEAST_M / 2.0))


def _value(value: object, kind: type, usual: Any) -> Any:
    try:
        return msgspec.convert(value, kind)
    except msgspec.ValidationError:
        return usual

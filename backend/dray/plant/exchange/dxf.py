"""A floor plan that an architect drew, as a picture to draw a plant on: DXF as SVG, in metres.

`ezdxf` reads the file; it is in the extra `dxf`. Only lines are drawn: lines, polylines, arcs, circles, ellipses and
splines, also in blocks. Texts, hatches, dimensions and solids are left out, and counted. A floor plan is input: how
much of it is read is bounded.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from math import hypot, isfinite
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from dray.errors import PlantError, UnavailableError
from dray.plant.file.reasons import Reason

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.entities.dxfentity import DXFEntity
    from ezdxf.path import Path as Outline

MAX_BYTES = 32 * 1024 * 1024
"""Largest file; the plan of a hall has a few megabytes."""

MAX_ENTITIES = 200_000
"""Most entities that are read; those of blocks count each time that they are placed."""

MAX_CORNERS = 60_000
"""Most corners of all lines together; some 500 kB of SVG."""

FINENESS = 4000.0
"""Smallest drawn part, as a fraction of the longer side: 1 in this number."""

METRES = {1: 0.0254, 2: 0.3048, 4: 0.001, 5: 0.01, 6: 1.0, 14: 0.1}
"""Metres by `$INSUNITS`: inches, feet, millimetres, centimetres, metres, decimetres."""

CURVE_PARTS = 400.0
"""Largest deviation of a curve's corners, as a fraction of its own size: 1 in this number."""

LARGE = 1000.0
"""Longer without a unit: millimetres; no hall is a kilometre long."""

SAVE_LESS = "hide layers that are not needed, as furniture and hatching, and save what is seen"

LINES = frozenset({"LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE"})

Spot = tuple[float, float]


class FloorPlan(msgspec.Struct, frozen=True):
    """The result of reading a file."""

    svg: str
    width_m: float
    height_m: float
    notes: tuple[Reason, ...]
    """Parts that were left out, and assumptions."""


def read_dxf(file: Path) -> FloorPlan:
    """A DXF file, text or binary, as a picture.

    Raises:
        PlantError: it is none, or too much, or nothing in it is a line.
        UnavailableError: `ezdxf` is not installed.
    """
    size = file.stat().st_size
    if size > MAX_BYTES:
        raise PlantError(file.name, "", f"it has {size} bytes, {MAX_BYTES} at most: {SAVE_LESS}")
    with file.open("rb") as stream:
        begins = stream.read(6)
    if begins.startswith(b"AC10"):
        raise PlantError(file.name, "", "it is DWG: save it as DXF")
    document = _document(file, binary=begins.startswith(b"AutoCA"))
    notes: list[Reason] = []
    lines = list(_lines(document, file.name, notes))
    spots = [spot for line in lines for spot in line]
    if not spots:
        raise PlantError(
            file.name,
            "",
            "no line is in its model space: is the plan in a layout, or in a file that it refers to?",
        )
    low_x, high_x = min(x for x, _ in spots), max(x for x, _ in spots)
    low_y, high_y = min(y for _, y in spots), max(y for _, y in spots)
    longest = max(high_x - low_x, high_y - low_y)
    if longest <= 0.0:
        raise PlantError(file.name, "", "all its lines are in one spot")
    scale = _metres(document, longest, notes)
    least = longest / FINENESS
    paths = [path for line in lines if (path := _path(line, low_x, high_y, least, scale))]
    corners = sum(len(path) for path in paths)
    if corners > MAX_CORNERS:
        raise PlantError(file.name, "", f"it has {corners} corners, {MAX_CORNERS} at most: {SAVE_LESS}")
    width_m, height_m = (high_x - low_x) * scale, (high_y - low_y) * scale
    return FloorPlan(_svg(paths, width_m, height_m), round(width_m, 3), round(height_m, 3), tuple(notes))


def _document(file: Path, *, binary: bool) -> Drawing:
    try:
        from ezdxf import filemanagement, recover  # noqa: PLC0415  It need not be installed.
    except ModuleNotFoundError:
        raise UnavailableError(
            "reading DXF", "ezdxf is not installed", "install dray[dxf], or save the plan as SVG"
        ) from None
    try:
        return filemanagement.readfile(file) if binary else recover.readfile(file)[0]
    except Exception as error:  # noqa: BLE001  What a library raises on a file that is none is its own affair.
        reason = str(error).splitlines()[0][:120] if str(error) else type(error).__name__
        raise PlantError(file.name, "", f"it is no DXF that can be read: {reason}") from None


def _lines(document: Drawing, name: str, notes: list[Reason]) -> Iterator[list[Spot]]:
    """All that is drawn in the model space, on layers that are shown, each as its corners."""
    from ezdxf.disassemble import recursive_decompose  # noqa: PLC0415
    from ezdxf.path import make_path  # noqa: PLC0415

    hidden = {layer.dxf.name.lower() for layer in document.layers if layer.is_off() or layer.is_frozen()}
    hidden_count = 0
    left_out: Counter[str] = Counter()
    shapeless: Counter[str] = Counter()
    for seen, entity in enumerate(_ending(recursive_decompose(document.modelspace()), name)):
        if seen == MAX_ENTITIES:
            raise PlantError(
                name, "", f"it has more than {MAX_ENTITIES} entities, those of blocks counted: {SAVE_LESS}"
            )
        if str(entity.dxf.get("layer", "0")).lower() in hidden or entity.dxf.get("invisible", 0):
            hidden_count += 1
            continue
        kind = entity.dxftype()
        if kind not in LINES:
            left_out[kind] += 1
            continue
        if corners := _corners(make_path, entity):
            yield corners
        else:
            shapeless[kind] += 1
    notes += [
        Reason("note_plan_left_out", kind=kind, count=count) for kind, count in sorted(left_out.items())
    ]
    notes += [
        Reason("note_plan_shapeless_left_out", kind=kind, count=count)
        for kind, count in sorted(shapeless.items())
    ]
    if hidden_count:
        notes.append(Reason("note_plan_hidden_left_out", count=hidden_count))


def _ending(entities: Iterable[DXFEntity], name: str) -> Iterator[DXFEntity]:
    """The same; a block that contains itself has no end."""
    try:
        yield from entities
    except RecursionError:
        raise PlantError(
            name, "", "one of its blocks contains itself: draw what is in it anew, and save it again"
        ) from None


def _corners(make_path: Callable[[DXFEntity], Outline], entity: DXFEntity) -> list[Spot]:
    """The corners of one line, its curves as fine as its size demands; none where it has no shape."""
    try:
        path = make_path(entity)
        controls = [(point.x, point.y) for point in path.control_vertices()]
        size = max((max(axis) - min(axis) for axis in zip(*controls, strict=True)), default=0.0)
        if not (isfinite(size) and size > 0.0):
            return []
        spots = [(float(point.x), float(point.y)) for point in path.flattening(size / CURVE_PARTS)]
    except Exception:  # noqa: BLE001  Likewise one line of it; it is counted.
        return []
    return spots if len(spots) > 1 and all(isfinite(x) and isfinite(y) for x, y in spots) else []


def _metres(document: Drawing, longest: float, notes: list[Reason]) -> float:
    """Metres in one unit of the drawing."""
    unit = document.header.get("$INSUNITS", 0)
    if unit in METRES:
        return METRES[unit]
    code, scale = ("note_plan_in_millimetres", 0.001) if longest > LARGE else ("note_plan_in_metres", 1.0)
    notes.append(Reason(code, length=longest))
    return scale


def _path(line: list[Spot], low_x: float, high_y: float, least: float, scale: float) -> list[tuple[int, int]]:
    """A line in whole millimetres from the upper left corner, y down, without invisibly small parts."""
    kept = [line[0]]
    for x, y in line[1:-1]:
        if hypot(x - kept[-1][0], y - kept[-1][1]) >= least:
            kept.append((x, y))
    kept.append(line[-1])
    path = [(round((x - low_x) * scale * 1000), round((high_y - y) * scale * 1000)) for x, y in kept]
    seen_mm = least * scale * 1000
    too_small = all(hypot(x - path[0][0], y - path[0][1]) < seen_mm for x, y in path[1:])
    return [] if too_small else path


def _svg(paths: Iterable[list[tuple[int, int]]], width_m: float, height_m: float) -> str:
    """One path of all lines, in millimetres, each line relative to its beginning; it sits at the lower left of its frame."""
    wide, high = max(round(width_m * 1000), 1), max(round(height_m * 1000), 1)
    drawn = []
    for path in paths:
        (x, y), *rest = path
        steps = [f"M{x} {y}l"]
        for to_x, to_y in rest:
            steps.append(f"{to_x - x} {to_y - y}")
            x, y = to_x, to_y
        drawn.append(f"{steps[0]}{' '.join(steps[1:])}")
    stroke = max(wide, high) / 600
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {wide} {high}" width="{wide}" height="{high}" '
        f'preserveAspectRatio="xMinYMax meet">'
        f'<path fill="none" stroke="#5b6b7b" stroke-width="{stroke:.0f}" d="{"".join(drawn)}"/></svg>\n'
    )

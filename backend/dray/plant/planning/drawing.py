"""A plant as a picture: an SVG of the floor with lanes, places and vehicles. Pure: a plant in, text out.

One unit is one metre, y up as in the file. Every place has a label where there is room for one, and a title with all
its data, which browsers show under the pointer.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from xml.sax.saxutils import escape, quoteattr

from dray.plant.model import Box, Node
from dray.plant.plant import Plant

Spot = tuple[float, float, float, float]
"""Left, low, right and high (m)."""

WIDTH_PX = 1200
"""Width of the picture at first; it can be enlarged without loss."""

HEAD_M, FOOT_M = 3.0, 3.2
"""Room for the title and for the legend, in letters of one metre."""

LETTER = 0.68
"""Mean width of a letter over its height, a little on the safe side."""

LETTERS_PER_WIDTH = 110.0
"""A label is as high as the floor's width over this: legible where the picture fills a page."""

KINDS = {
    "machine": ("Machine", "#cfe3f7", "#1f5f99"),
    "storage": ("Storage", "#f9e3b8", "#8a5a00"),
    "source": ("Goods in", "#d9efcf", "#2f6b1a"),
    "delivery": ("Goods out", "#f3d3d9", "#94263b"),
    "charger": ("Charger", "#e5d8f5", "#5b2c91"),
    "parking": ("Parking", "#e8e8e8", "#555555"),
}
"""Label, fill and line of every kind of place; lines are dark enough to be read on their fill and on white."""

UNASSIGNED = ("Nobody has said", "#ffffff", "#7a1f1f")
"""Label, fill and line of stations without a purpose; in the legend only where there are any."""

VEHICLE = "#c2410c"

FORBIDDEN = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that no XML may hold, escaped or not."""


def draw(plant: Plant) -> str:
    """The picture of a plant: a whole SVG document, the same for the same plant."""
    return "\n".join(_Picture(plant).lines()) + "\n"


def _text(text: str) -> str:
    return escape(FORBIDDEN.sub("\ufffd", text))


class _Picture:
    """The parts of a picture, from the back to the front."""

    def __init__(self, plant: Plant) -> None:
        self._plant = plant
        self._letter_m = max(plant.width_m, plant.height_m) / LETTERS_PER_WIDTH
        self._taken = list(self._things())
        """Areas of things and labels, as (left, low, right, high): no label is put over them."""

    def lines(self) -> Iterator[str]:
        """The document, line by line."""
        plant, letter_m = self._plant, self._letter_m
        head_m, foot_m = HEAD_M * letter_m, FOOT_M * letter_m
        high_m = head_m + plant.height_m + foot_m
        yield (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {plant.width_m:g} {high_m:g}" width="{WIDTH_PX}" '
            f'height="{WIDTH_PX * high_m / plant.width_m:.0f}" font-family="system-ui, sans-serif" role="img">'
        )
        yield f"<title>{_text(plant.name)} ({plant.id})</title>"
        yield (
            '<defs><marker id="way" viewBox="0 0 10 10" refX="5" refY="5" markerWidth="5" markerHeight="5" '
            'orient="auto"><path d="M1 1 9 5 1 9Z" fill="#444"/></marker></defs>'
        )
        yield f'<rect width="100%" height="{high_m:g}" fill="#fff"/>'
        yield self._label(
            plant.width_m / 2,
            1.9 * letter_m,
            f"{plant.name} ({plant.id})",
            size_m=1.6 * letter_m,
            weight="bold",
        )
        yield f'<g transform="translate(0 {head_m:g})">'
        yield f'<rect width="{plant.width_m:g}" height="{plant.height_m:g}" fill="#fafafa" stroke="#333" stroke-width="{letter_m / 8:.3g}"/>'
        yield from self._areas()
        yield from self._lanes()
        yield from self._stops()
        yield from self._places()
        yield from self._vehicles()
        yield "</g>"
        yield from self._legend(head_m + plant.height_m + 1.3 * letter_m)
        yield "</svg>"

    def _things(self) -> Iterator[Spot]:
        """Boxes, docks and vehicles."""
        plant, half_m = self._plant, self._letter_m / 2
        boxes = [
            spec.box
            for specs in (plant.warehouses, plant.storages, plant.machines, plant.chargers)
            for spec in specs.values()
        ]
        for box in boxes:
            half_x, half_y = box.width_m / 2, box.depth_m / 2
            yield box.x_m - half_x, box.y_m - half_y, box.x_m + half_x, box.y_m + half_y
        for vehicle in plant.fleet.values():
            node = plant.nodes[vehicle.node]
            yield node.x_m - half_m, node.y_m - half_m, node.x_m + half_m, node.y_m + half_m

    # --- the floor ---

    def _areas(self) -> Iterator[str]:
        for area in self._plant.areas.values():
            points = " ".join(f"{corner.x_m:g},{self._y(corner.y_m):g}" for corner in area.polygon)
            yield (
                f'<polygon points="{points}" fill="none" stroke="#999" stroke-width="{self._letter_m / 10:.3g}" '
                f'stroke-dasharray="{self._letter_m:.3g}"><title>{_text(area.name)} ({area.id})</title></polygon>'
            )

    def _lanes(self) -> Iterator[str]:
        """One line for a lane that runs both ways, one with an arrow for another, a thin one for a way over a crossing."""
        roads, nodes, drawn = self._plant.roads, self._plant.nodes, set[tuple[str, str]]()
        crossed = {
            lane: each.id for each in self._plant.crossings.values() if each.nodes for lane in each.lanes
        }
        for lane in self._plant.lanes:
            back = roads.lane(lane.end, lane.start)
            if (lane.end, lane.start) in drawn:
                continue
            drawn.add((lane.start, lane.end))
            a, b = nodes[lane.start], nodes[lane.end]
            middle = f"{(a.x_m + b.x_m) / 2:.6g} {self._y((a.y_m + b.y_m) / 2):.6g}"
            width_m = self._letter_m * (0.32 if back else 0.2)
            arrow = "" if back else ' marker-mid="url(#way)"'
            both = "both ways" if back else "one way"
            if not back and (crossing := crossed.get((lane.start, lane.end))):
                arrow, both, width_m = "", f"over crossing {crossing}", self._letter_m * 0.08
            title = f"{lane.start} to {lane.end}, {both}, {lane.length_m:.1f} m, {lane.speed_limit_mps:g} m/s"
            yield (
                f'<path d="M{a.x_m:g} {self._y(a.y_m):g} L{middle} L{b.x_m:g} {self._y(b.y_m):g}" fill="none" '
                f'stroke="{"#b5b5b5" if back else "#777"}" stroke-width="{width_m:.3g}"{arrow}><title>{title}</title></path>'
            )

    def _stops(self) -> Iterator[str]:
        """The stop points of two-lane roads."""
        waits = {
            stop
            for each in self._plant.crossings.values()
            if each.nodes
            for stop in (*each.entries, *each.exits)
        }
        docks = {self._plant.node_of(place) for place in self._plant.places}
        for stop in self._plant.stops:
            if stop in waits and stop not in docks:
                spot = self._plant.nodes[stop]
                yield (
                    f'<circle cx="{spot.x_m:g}" cy="{self._y(spot.y_m):g}" r="{self._letter_m / 5:.3g}" fill="#fff" '
                    f'stroke="#777" stroke-width="{self._letter_m / 8:.3g}"><title>{stop}</title></circle>'
                )

    # --- places ---

    def _places(self) -> Iterator[str]:
        plant = self._plant
        for warehouse in plant.warehouses.values():
            yield from self._place(
                warehouse.kind, warehouse.id, warehouse.name, warehouse.node, warehouse.box
            )
        for storage in plant.storages.values():
            kept = ", ".join(f"{stock.material} {stock.capacity}" for stock in storage.stocks)
            yield from self._place(
                "storage", storage.id, f"{storage.name}: {kept}", storage.node, storage.box
            )
        for machine in plant.machines.values():
            makes = ", ".join(f"{making.product} in {making.cycle_s:g} s" for making in machine.makes)
            yield from self._place(
                "machine", machine.id, f"{machine.name}: {makes}", machine.node, machine.box
            )
        for charger in plant.chargers.values():
            yield from self._place("charger", charger.id, "Charger", charger.node, charger.box)
        for parking in plant.parkings.values():
            spot = plant.nodes[parking.node]
            box = Box(spot.x_m, spot.y_m, 1.1 * self._letter_m, 1.1 * self._letter_m)
            yield from self._place("parking", parking.id, "Parking place", parking.node, box)

        for station in plant.file.unassigned:
            spot = plant.nodes.get(station.node) or Node(station.node, 0.0, 0.0)
            side_m = 1.6 * self._letter_m
            box = station.box or Box(spot.x_m, spot.y_m, side_m, side_m)
            title = f"{station.name}: nobody has said what it is"
            yield from self._place("unassigned", station.id, title, station.node, box)

    def _place(self, kind: str, name: str, title: str, node: str, box: Box) -> Iterator[str]:
        _, fill, line = UNASSIGNED if kind == "unassigned" else KINDS[kind]
        dock = self._plant.nodes[node]
        thin_m = self._letter_m / 8
        yield (
            f'<path d="M{dock.x_m:g} {self._y(dock.y_m):g} L{box.x_m:g} {self._y(box.y_m):g}" stroke="{line}" '
            f'stroke-width="{thin_m:.3g}" stroke-dasharray="{2 * thin_m:.3g}"/>'
        )
        yield (
            f'<rect x="{box.x_m - box.width_m / 2:.6g}" y="{self._y(box.y_m + box.depth_m / 2):.6g}" '
            f'width="{box.width_m:g}" height="{box.depth_m:g}" rx="{thin_m:.3g}" fill="{fill}" stroke="{line}" '
            f'stroke-width="{thin_m:.3g}"><title>{_text(f"{name}: {title}")}</title></rect>'
        )
        yield f'<circle cx="{dock.x_m:g}" cy="{self._y(dock.y_m):g}" r="{2 * thin_m:.3g}" fill="{line}"/>'
        free = abs(dock.x_m - box.x_m) > box.width_m / 2 or abs(dock.y_m - box.y_m) > box.depth_m / 2
        yield from self._name_in(box, name, line, free=free)

    def _name_in(self, box: Box, name: str, colour: str, *, free: bool) -> Iterator[str]:
        """The label of a box: within it where it is free and large enough, else beside it where no other label stands."""
        size_m = self._letter_m
        wide_m = LETTER * size_m * len(name)
        if free and wide_m <= box.width_m and size_m <= box.depth_m:
            yield self._label(box.x_m, self._y(box.y_m) + 0.35 * size_m, name, colour=colour)
            return
        if free and wide_m <= box.depth_m and size_m <= box.width_m:
            turned = f"translate({box.x_m + 0.35 * size_m:.6g} {self._y(box.y_m):.6g}) rotate(-90)"
            yield f'<g transform="{turned}">{self._label(0.0, 0.0, name, colour=colour)}</g>'
            return
        half_x, half_y = box.width_m / 2, box.depth_m / 2
        for gap_m in (0.15 * size_m, 1.3 * size_m, 2.5 * size_m):
            beside = half_x + wide_m / 2 + gap_m
            above = half_y + size_m / 2 + gap_m
            for x_m, y_m in (
                (box.x_m, box.y_m + above),
                (box.x_m, box.y_m - above),
                (box.x_m + beside, box.y_m),
                (box.x_m - beside, box.y_m),
            ):
                if self._is_free(x_m, y_m, wide_m):
                    yield self._label(x_m, self._y(y_m) + 0.35 * size_m, name, colour=colour, halo=True)
                    return
        # Nowhere: the title has the name.

    def _is_free(self, x_m: float, y_m: float, wide_m: float) -> bool:
        """Whether a label may stand here; then it does."""
        half_m = self._letter_m / 2
        spot = (x_m - wide_m / 2, y_m - half_m, x_m + wide_m / 2, y_m + half_m)
        if spot[0] < 0 or spot[2] > self._plant.width_m or spot[1] < 0 or spot[3] > self._plant.height_m:
            return False
        if any(_overlap(spot, other) for other in self._taken):
            return False
        self._taken.append(spot)
        return True

    def _vehicles(self) -> Iterator[str]:
        for vehicle in self._plant.fleet.values():
            spot = self._plant.nodes[vehicle.node]
            box = Box(spot.x_m, spot.y_m, 0.8 * self._letter_m, 0.8 * self._letter_m)
            title = f"{vehicle.id}: {vehicle.type}, battery {vehicle.battery_frac:.0%}"
            yield (
                f'<circle cx="{spot.x_m:g}" cy="{self._y(spot.y_m):g}" r="{0.5 * self._letter_m:.3g}" fill="{VEHICLE}" '
                f'stroke="#fff" stroke-width="{self._letter_m / 10:.3g}"><title>{_text(title)}</title></circle>'
            )
            yield from self._name_in(box, vehicle.id, VEHICLE, free=False)

    # --- beside the floor ---

    def _legend(self, y_m: float) -> Iterator[str]:
        """The meanings of the colours, and a scale."""
        letter_m = self._letter_m
        x_m = letter_m
        kinds = [*KINDS.values(), *([UNASSIGNED] if self._plant.file.unassigned else [])]
        for label, fill, line in kinds:
            yield (
                f'<rect x="{x_m:.4g}" y="{y_m - 0.8 * letter_m:.6g}" width="{letter_m:.3g}" height="{letter_m:.3g}" '
                f'fill="{fill}" stroke="{line}" stroke-width="{letter_m / 8:.3g}"/>'
            )
            yield self._label(x_m + 1.4 * letter_m, y_m, label, anchor="start")
            x_m += (3.2 + LETTER * len(label)) * letter_m
        yield f'<circle cx="{x_m + letter_m / 2:.4g}" cy="{y_m - 0.3 * letter_m:.6g}" r="{letter_m / 2:.3g}" fill="{VEHICLE}"/>'
        yield self._label(x_m + 1.4 * letter_m, y_m, "Vehicle at the start", anchor="start")
        x_m += 14.5 * letter_m
        scale_m = _round_down(self._plant.width_m / 10)
        yield (
            f'<path d="M{x_m:.4g} {y_m - 0.3 * letter_m:.6g} h{scale_m:g}" stroke="#333" stroke-width="{letter_m / 5:.3g}"/>'
        )
        yield self._label(x_m + scale_m + 0.5 * letter_m, y_m, f"{scale_m:g} m", anchor="start")

    def _label(
        self,
        x_m: float,
        y_m: float,
        text: str,
        *,
        size_m: float = 0.0,
        colour: str = "#222",
        anchor: str = "middle",
        weight: str = "normal",
        halo: bool = False,
    ) -> str:
        around = (
            f' stroke="#fff" stroke-width="{self._letter_m / 4:.3g}" paint-order="stroke"' if halo else ""
        )
        return (
            f'<text x="{x_m:.6g}" y="{y_m:.6g}" font-size="{size_m or self._letter_m:.3g}" fill={quoteattr(colour)} '
            f'text-anchor="{anchor}" font-weight="{weight}"{around}>{_text(text)}</text>'
        )

    def _y(self, y_m: float) -> float:
        """Down the picture."""
        return round(self._plant.height_m - y_m, 3)


def _overlap(a: Spot, b: Spot) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _round_down(length_m: float) -> float:
    """Round down to 1, 2 or 5 times a power of ten."""
    power = 1.0
    while power * 10 <= length_m:
        power *= 10
    while power > length_m:
        power /= 10
    return max(factor * power for factor in (1, 2, 5) if factor * power <= length_m)

"""The drawing of an openTCS model: where the editor shows points, how paths bend, which symbols locations have.

Since 0.0.4 it stands in each element (`pointLayout`, `pathLayout`, `locationLayout`), before that in `modelLayoutElement`s of the
`visualLayout`, as properties. Spots are millimetres as in the model, control points units of the drawing.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import hypot
from statistics import median

from dray.plant.exchange.lif_values import number_of
from dray.plant.exchange.track_layout import Spot
from dray.plant.exchange.xml_tree import Element

M = 0.001
"""A millimetre."""

SAME_FRAC = 0.05
"""Lengths of paths agree about a scale when they differ by so much at most."""

AGREEING_FRAC = 0.8
"""Fraction of the paths that must agree before a drawing is scaled by their lengths."""

SYMBOLS = ("tcs:defaultLocationTypeSymbol", "tcs:defaultLocationSymbol")
"""Properties that name the symbol of a location or its type."""

RECHARGE = "rechargeOperation"
"""End of the name of a vehicle's property for its charging operation."""


class Drawing:
    """An editor's data of a model.

    Args:
        model: the root element.
    """

    def __init__(self, model: Element) -> None:
        self._told = {
            each.attributes.get("visualizedObjectName", ""): properties_of(each)
            for layout in model.all("visualLayout")
            for each in layout.all("modelLayoutElement")
        }

    def spot(self, point: Element) -> Spot | None:
        """Position of a point in the drawing (m)."""
        layout = point.first("pointLayout")
        told = {} if layout is None else layout.attributes
        old = self._told.get(point.attributes.get("name", ""), {})
        x, y = (
            number_of(told.get(new, told.get(newer, old.get(before))))
            for new, newer, before in (
                ("xPosition", "positionX", "POSITION_X"),
                ("yPosition", "positionY", "POSITION_Y"),
            )
        )
        return None if x is None or y is None else (x * M, y * M)

    def path(self, path: Element) -> tuple[str, list[tuple[str, str]]]:
        """The connection type of a path, and its control points as they are written."""
        layout = path.first("pathLayout")
        if layout is not None:
            points = [
                (each.attributes.get("x", ""), each.attributes.get("y", ""))
                for each in layout.all("controlPoint")
            ]
            return layout.attributes.get("connectionType", "DIRECT"), points
        old = self._told.get(path.attributes.get("name", ""), {})
        pairs = (pair.partition(",") for pair in old.get("CONTROL_POINTS", "").split(";") if pair.strip())
        return old.get("CONN_TYPE", "") or "DIRECT", [(x, y) for x, _, y in pairs]

    def symbol(self, of: Element) -> str:
        """The symbol of a location or of its type; empty for none."""
        layout = of.first(f"{of.name}Layout")
        shown = "" if layout is None else layout.attributes.get("locationRepresentation", "")
        properties = properties_of(of)
        return shown or next((properties[key] for key in SYMBOLS if key in properties), "")


def properties_of(of: Element) -> dict[str, str]:
    """The properties of an element, by name."""
    return {each.attributes.get("name", ""): each.attributes.get("value", "") for each in of.all("property")}


def scale_by_lengths(model: Element, drawn: Mapping[str, Spot]) -> float:
    """Scale of a drawing by which its paths get their given lengths; 1 where they do not agree."""
    found = []
    for path in model.all("path"):
        start, end = (drawn.get(path.attributes.get(key, "")) for key in ("sourcePoint", "destinationPoint"))
        told = number_of(path.attributes.get("length"))
        # The editor writes a length of 1 where none is known.
        if start and end and told is not None and told > 1.0:
            length_m = hypot(end[0] - start[0], end[1] - start[1])
            if length_m > 0.0:
                found.append(told * M / length_m)
    if not found:
        return 1.0
    middle = median(found)
    agreeing = sum(abs(each / middle - 1.0) <= SAME_FRAC for each in found)
    return middle if agreeing >= AGREEING_FRAC * len(found) and abs(middle - 1.0) > SAME_FRAC else 1.0

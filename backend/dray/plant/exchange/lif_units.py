"""The unit of a LIF file: metres, unless its lengths or speeds cannot be."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import median

from dray.plant.exchange.notes import Notes
from dray.plant.file.reasons import Reason

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001}
"""Units of length in metres."""

WORDS = {"m": "metres", "cm": "centimetres", "mm": "millimetres"}

LONGEST = 500.0
"""Largest median length of edges; longer ones are not in metres. No lane is half a kilometre long."""

DOUBTED_M = 100.0
"""Median length of edges from which a note says that another unit is possible."""

FASTEST_MPS = 20.0
"""Faster than any vehicle of a plant; AGVs drive 0.3 to 3 m/s."""

USUAL_MPS = (0.2, 5.0)
"""Range of the limits of most lanes."""


def scales(lengths: Sequence[float], speeds: Sequence[float], unit: str, notes: Notes) -> tuple[float, float]:
    """Metres in one unit of length, and metres per second in one unit of speed.

    Args:
        lengths: of the edges, as the file has them.
        speeds: of the edges, in the file's unit.
        unit: given by the user; empty for none.
        notes: takes reports of assumptions.

    Raises:
        ValueError: the speeds cannot be in metres a second, and the lengths could be in metres; or several units are possible.
    """
    length = median(lengths) if lengths else 0.0
    speed = median(speeds) if speeds else 0.0
    too_fast = speed > FASTEST_MPS
    if not unit and not too_fast:
        if length < LONGEST:
            if length >= DOUBTED_M:
                text = Reason("note_edge_long_median_say_unit", length=length)
                notes.add("", text)
            return 1.0, 1.0
        unit = "mm"
    elif not unit:
        fitting = [each for each in ("cm", "mm") if USUAL_MPS[0] <= speed * UNITS[each] <= USUAL_MPS[1]]
        if len(fitting) != 1 or length < LONGEST:
            raise ValueError(_question(length, speed, fitting))
        unit = fitting[0]
    else:
        if too_fast and unit != "m":
            notes.add("", Reason("note_speeds_cannot_they_read_as", speed=speed, unit=unit))
        return UNITS[unit], UNITS[unit] if too_fast else 1.0
    notes.add("", Reason("note_edge_long_read_as_although", length=length, unit_name=WORDS[unit]))
    if too_fast:
        notes.add("", Reason("note_speeds_cannot_they_read_as", speed=speed, unit=unit))
    return UNITS[unit], UNITS[unit] if too_fast else 1.0


def _question(length: float, speed: float, fitting: Sequence[str]) -> str:
    """The question about the unit that must be answered before the file can be read."""
    choices = " or ".join(
        f"{each} (times {UNITS[each]:g}: edges of {length * UNITS[each]:.3g} m, {speed * UNITS[each]:.3g} m/s)"
        for each in fitting or ("cm", "mm")
    )
    return f"speeds of {speed:g} m/s cannot be, so it is not in metres: say its unit, {choices}; or m, and such limits are left out"

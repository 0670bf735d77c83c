"""A layout of any system: nodes, directed edges, stations and vehicles, in metres, with the ids of the system."""

from __future__ import annotations

from typing import Any

import msgspec

Spot = tuple[float, float]
"""x and y (m)."""


class TrackNode(msgspec.Struct):
    """A point of a layout."""

    original: str
    """Its id, which is unique in the layout."""
    place: str
    """Its place in the file, for notes."""
    x_m: float
    y_m: float
    level: str = ""
    """Layouts of one level lie in one plane."""
    map: str = ""
    """The map of vehicles that it lies on; empty where the file does not say that."""
    max_m: tuple[float, float] | None = None
    """Length and width of the largest vehicle that may be there; None for any."""
    parks: bool = False
    charges: bool = False
    types: list[str] = []
    """The types of vehicles that may be there; empty for all."""
    kept: dict[str, Any] = {}
    """Data of the file without a field in a plant."""
    called: str = ""
    """Its name in the file, where several of its layouts use the same one."""

    @property
    def name(self) -> str:
        """Its name in the file."""
        return self.called or self.original


class TrackEdge(msgspec.Struct):
    """A lane in one direction."""

    original: str
    place: str
    start: str
    end: str
    corners: list[Spot] = []
    """Between its ends; empty for a straight one."""
    limits_mps: dict[str, float] = {}
    """Type of vehicle -> its highest speed, as far as the file says it; the empty type is for all."""
    types: list[str] = []
    """The types of vehicles that may drive there; empty for all."""
    kept: dict[str, Any] = {}


class TrackStation(msgspec.Struct):
    """A place where vehicles do something."""

    original: str
    place: str
    name: str
    nodes: list[str]
    charges: bool = False
    parks: bool = False
    kept: dict[str, Any] = {}


class TrackVehicleType(msgspec.Struct):
    """A make of vehicles; None stands for an unknown value."""

    original: str
    length_m: float | None = None
    width_m: float | None = None
    max_speed_mps: float | None = None
    charging: dict[str, float] = {}
    """Thresholds as in `dray.plant.Charging`."""


class TrackVehicle(msgspec.Struct):
    """A vehicle."""

    original: str
    kind: str
    node: str | None = None
    kept: dict[str, Any] = {}


class TrackLayout(msgspec.Struct):
    """All of a file."""

    format: str
    """`LIF 1.0.0`, say."""
    name: str
    ours: bool = False
    """Whether Dray has written it: then it is in metres, and each of its nodes is a separate place."""
    nodes: list[TrackNode] = []
    edges: list[TrackEdge] = []
    stations: list[TrackStation] = []
    vehicle_types: list[TrackVehicleType] = []
    vehicles: list[TrackVehicle] = []
    kept: dict[str, Any] = {}

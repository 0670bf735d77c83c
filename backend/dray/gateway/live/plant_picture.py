"""A picture of the plant for visibility and stream scopes: the live projection, or a moment of the past."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any, Protocol

from dray.gateway.live.frames import Snapshot
from dray.gateway.live.projection.site import Site
from dray.gateway.live.views import OrderView, TaskView


class Kind(Protocol):
    """Entities of one kind."""

    def views(self) -> Sequence[Any]:
        """All of them."""
        ...


class Agents(Kind, Protocol):
    """Agents of one kind."""

    def view(self, agent: str, /) -> Any:
        """One of them, if it is there; else None."""
        ...


class Vehicles(Agents, Protocol):
    """The vehicles."""

    def __contains__(self, atv: object) -> bool:
        """Whether there is a vehicle of this name."""
        ...

    def place_m(self, atv: str) -> tuple[float, float] | None:
        """The place of a vehicle; None for an unknown one."""
        ...


class Many(Kind, Protocol):
    """Entities of a kind that may have thousands."""

    def ids(self) -> Collection[str]:
        """The ids of all of them, in the order of `views`."""
        ...


class Ordered(Many, Protocol):
    """The orders."""

    def view(self, order: str) -> OrderView | None:
        """One order, if it is there."""
        ...


class Transports(Many, Protocol):
    """The tasks."""

    def view(self, task: str) -> TaskView | None:
        """One task, if it is there."""
        ...


class Given(Kind, Protocol):
    """People's commands to vehicles."""

    def areas_of(self, command: str) -> frozenset[str]:
        """The areas of its vehicle when the command was given."""
        ...


class PlantPicture(Protocol):
    """A picture of the plant."""

    @property
    def plant(self) -> str:
        """Its id."""
        ...

    @property
    def speed(self) -> float:
        """Factory seconds per real second."""
        ...

    @property
    def site(self) -> Site:
        """The places of everything in the plant."""
        ...

    def plant_at_s(self, wall_s: float) -> float | None:
        """When the plant became as it is; None where nobody knows it.

        Args:
            wall_s: the wall clock.
        """
        ...

    @property
    def atvs(self) -> Vehicles: ...
    @property
    def orders(self) -> Ordered: ...
    @property
    def tasks(self) -> Transports: ...
    @property
    def commands(self) -> Given: ...
    @property
    def machines(self) -> Agents: ...
    @property
    def stations(self) -> Agents: ...
    @property
    def closures(self) -> Kind: ...
    @property
    def kinds(self) -> Mapping[str, Kind]:
        """All kinds of entities, by their field in a frame (`dray.gateway.live.frames.Entities`)."""
        ...

    def snapshot(self, number: int, wall_s: float, most: int | None = None) -> Snapshot:
        """The complete state; at most `most` entities of each collection in `MANY`, if given."""
        ...

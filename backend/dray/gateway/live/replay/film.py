"""The film: plays pieces of a recording into the picture of a moment and the changes after it. Pure.

A recording holds what panels were sent, so a moment is rebuilt as a panel does it: a snapshot, then every
frame up to the moment. Later frames go through the same updates as live ones.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator, KeysView, Sequence
from typing import Any

import msgspec

from dray.gateway.live.frames import COLLECTIONS, MANY, VIEWS, Delta, Snapshot
from dray.gateway.live.projection.site import Site
from dray.gateway.live.views import CommandView, FactoryView
from dray.store.replay.recordings import Piece

Line = dict[str, Any]


class _Shelf:
    """Entities of one kind in their last recorded state."""

    def __init__(self, shape: Any) -> None:
        self._shape = shape
        self._told: dict[str, Line] = {}
        self._made: dict[str, Any] = {}
        """The same entities as views, made on demand."""

    def put(self, patches: Iterable[Line]) -> None:
        for patch in patches:
            entity = patch["id"]
            known = self._told.get(entity)
            self._told[entity] = patch if known is None else known | patch
            self._made.pop(entity, None)

    def __contains__(self, entity: object) -> bool:
        return entity in self._told

    def ids(self) -> KeysView[str]:
        return self._told.keys()

    def drop(self, entity: str) -> None:
        self._told.pop(entity, None)
        self._made.pop(entity, None)

    def view(self, entity: str) -> Any:
        if entity not in self._made and entity in self._told:
            self._made[entity] = msgspec.convert(self._told[entity], self._shape)
        return self._made.get(entity)

    def views(self) -> tuple[Any, ...]:
        return tuple(self.view(entity) for entity in self._told)

    def place_m(self, entity: str) -> tuple[float, float] | None:
        told = self._told.get(entity)
        return None if told is None else (told["x_m"], told["y_m"])


class _Commands(_Shelf):
    def __init__(self) -> None:
        super().__init__(CommandView)
        self._areas: dict[str, frozenset[str]] = {}

    def note_areas(self, areas: dict[str, list[str]]) -> None:
        self._areas |= {command: frozenset(given) for command, given in areas.items()}

    def areas_of(self, command: str) -> frozenset[str]:
        return self._areas.get(command, frozenset())


class _Orders(_Shelf):
    """Orders. Earlier versions have not recorded whether a machine works at one, and showed each as in production."""

    def put(self, patches: Iterable[Line]) -> None:
        super().put(patch if patch["id"] in self else {"begun": True, **patch} for patch in patches)


class Picture:
    """The plant as panels showed it at a moment; a `PlantPicture` like the live projection.

    Args:
        first: a snapshot's line.
        site: the places of everything in the plant.
    """

    def __init__(self, first: Line, site: Site) -> None:
        self.site, self.plant = site, str(first["plant"])
        self.at_s = 0.0
        """Time of the last frame played."""
        self._fault_injection = bool(first.get("fault_injection", False))
        self._factory: Any = first["factory"]
        self.kinds: dict[str, _Shelf] = {name: _Shelf(view) for name, view in VIEWS.items()}
        self.kinds["commands"] = self.commands = _Commands()
        self.kinds["orders"] = _Orders(VIEWS["orders"])
        self.atvs, self.machines, self.stations = (
            self.kinds[name] for name in ("atvs", "machines", "stations")
        )
        self.tasks, self.orders, self.closures = (
            self.kinds[name] for name in ("tasks", "orders", "closures")
        )
        self.play(first)

    @property
    def speed(self) -> float:
        """See `PlantPicture.speed`."""
        return float(self._factory["speed"])

    def plant_at_s(self, wall_s: float) -> float | None:
        """See `PlantPicture.plant_at_s`."""
        at_s: float | None = self._factory.get("plant_at_s")
        return at_s

    def play(self, line: Line) -> None:
        """Play one frame; in a snapshot, mark missing entities as gone."""
        if line.get("whole"):
            line["gone"] = [
                f"{kind}:{entity}"
                for kind, name in COLLECTIONS.items()
                for entity in self.kinds[name].ids() - {each["id"] for each in line.get(name, ())}
            ]
        self.at_s = line["at_s"]
        self._factory = line.get("factory") or self._factory
        for name, shelf in self.kinds.items():
            if name in line:
                shelf.put(line[name])
        for name in line.get("gone", ()):
            kind, _, entity = name.partition(":")
            if kind in COLLECTIONS:
                self.kinds[COLLECTIONS[kind]].drop(entity)
        if "areas" in line:
            self.commands.note_areas(line["areas"])

    def told(self, line: Line) -> Delta:
        """The content of a frame just played, as whole entities."""
        views: dict[str, Any] = {}
        for name, shelf in self.kinds.items():
            if name in line:
                found = (shelf.view(patch["id"]) for patch in line[name])
                views[name] = tuple(view for view in found if view is not None)
        factory = msgspec.convert(line["factory"], FactoryView) if line.get("factory") else None
        return Delta(number=0, at_s=line["at_s"], factory=factory, gone=tuple(line.get("gone", ())), **views)

    def snapshot(self, number: int, wall_s: float, most: int | None = None) -> Snapshot:
        """See `PlantPicture.snapshot`."""
        told: dict[str, Any] = {
            name: shelf.views()[:most] if name in MANY else shelf.views()
            for name, shelf in self.kinds.items()
        }
        return Snapshot(
            number=number,
            at_s=wall_s,
            plant=self.plant,
            factory=msgspec.convert(self._factory, FactoryView),
            fault_injection=self._fault_injection,
            **told,
        )


def lines_of(pieces: Sequence[Piece]) -> Iterator[Line]:
    """The frames of pieces, oldest first; `whole` marks snapshots.

    Ends at a missing piece, because later frames build on it.
    """
    recorder = ""
    for piece in pieces:
        if not piece.is_whole and piece.recorder != recorder:
            return
        recorder = piece.recorder
        for number, line in enumerate(zlib.decompress(piece.frames).split(b"\n")):
            frame: Line = msgspec.json.decode(line)
            frame["whole"] = piece.is_whole and number == 0
            yield frame


class Film:
    """Plays pieces.

    Args:
        pieces: from a snapshot on, oldest first.
        site: the places of everything in the plant.
    """

    def __init__(self, pieces: Sequence[Piece], site: Site) -> None:
        self._lines, self._site = lines_of(pieces), site
        self._next: Line | None = next(self._lines, None)
        self.picture: Picture | None = None

    def play_until(self, at_s: float) -> Picture | None:
        """The picture of a moment; None where nothing was recorded before it."""
        while self._next is not None and self._next["at_s"] <= at_s:
            self._step()
        return self.picture

    def frames(self, until_s: float) -> Iterator[Delta]:
        """The changes from the picture up to a moment; the picture advances too."""
        while (line := self._next) is not None and line["at_s"] <= until_s:
            self._step()
            if self.picture is not None:
                yield self.picture.told(line)

    def _step(self) -> None:
        line = self._next
        if line is None:
            return
        if self.picture is None:
            self.picture = Picture(line, self._site)
        else:
            self.picture.play(line)
        self._next = next(self._lines, None)

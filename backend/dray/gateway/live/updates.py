"""Updates: what the clients of one room know, what has changed since they were told, and the difference as a frame.

Of an entity that was told before, a frame tells its id and the fields that are different now: of a vehicle's 30 fields a
heartbeat changes five. What the clients know is kept by entity, as the view that was told last.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice
from typing import Any

import msgspec

from dray.gateway.live.frames import COLLECTIONS, MANY, Delta, Snapshot
from dray.gateway.live.views import FactoryView

_encoder = msgspec.json.Encoder()


class Updates:
    """Gathers what has changed until it is told."""

    def __init__(self) -> None:
        self._told: dict[str, dict[str, Any]] = {collection: {} for collection in COLLECTIONS.values()}
        """Per collection and id, the view as it was told last, by field."""
        self._changed: dict[str, dict[str, Any]] = {collection: {} for collection in COLLECTIONS.values()}
        """The same of what is to be told."""
        self._gone: dict[str, None] = {}
        """Names, as in `Delta.gone`; a dict for its order."""
        self._factory: FactoryView | None = None
        self._is_whole = False
        """The next frame tells whole entities: somebody may know something that `_told` does not say."""

    @property
    def waiting(self) -> bool:
        """Whether there is anything to tell."""
        return self._factory is not None or bool(self._gone) or any(self._changed.values())

    def note(self, delta: Delta) -> None:
        """Something has changed."""
        if delta.factory is not None:
            self._factory = delta.factory
        for name in delta.gone:
            kind, _, entity = name.partition(":")
            self._changed[COLLECTIONS[kind]].pop(entity, None)
            self._gone[name] = None
        for kind, collection in COLLECTIONS.items():
            views = getattr(delta, collection)
            if not views:
                continue
            self._changed[collection] |= {view.id: view for view in views}
            if self._gone:
                for view in views:
                    self._gone.pop(f"{kind}:{view.id}", None)

    def tell(self, collection: str, views: Iterable[Any]) -> None:
        """Tell these in the next frame, whole: somebody does not know them."""
        self._changed[collection] |= {view.id: view for view in views}
        self._is_whole = True

    def begin(self, snapshot: Snapshot) -> None:
        """All clients know this snapshot, and nothing else."""
        for collection in COLLECTIONS.values():
            views = getattr(snapshot, collection)
            self._told[collection] = {view.id: _fields(view) for view in views}

    def known(self) -> dict[str, list[dict[str, Any]]]:
        """What the clients know, per collection: entities by field, as `whole` encodes them. They are never changed: others take their places."""
        return {collection: list(told.values()) for collection, told in self._told.items()}

    def tell_whole(self) -> None:
        """Somebody was given a snapshot, which may be newer than what the others know."""
        self._is_whole = True

    def frame(self, number: int, at_s: float, most: int | None = None) -> dict[str, Any]:
        """The next frame; from here on its content is known.

        Args:
            number: of the frame.
            at_s: the wall clock.
            most: so many of each of `MANY`, those that changed first; the others wait for the frame after it. None for all.
        """
        frame: dict[str, Any] = {"type": "delta", "number": number, "at_s": at_s, "factory": self._factory}
        are_left = False
        for collection, views in self._changed.items():
            told = self._told[collection]
            these = tuple(islice(views, most if collection in MANY else None))
            # Views go on changing in place: what was told is kept as it was.
            now = {entity: _fields(views.pop(entity)) for entity in these}
            are_left |= bool(views)
            frame[collection] = [
                _raw(
                    view
                    if self._is_whole or (before := told.get(entity)) is None
                    else _difference(before, view)
                )
                for entity, view in now.items()
            ]
            told |= now
        frame["gone"] = list(self._gone)
        for name in self._gone:
            kind, _, entity = name.partition(":")
            self._told[COLLECTIONS[kind]].pop(entity, None)
        self._gone.clear()
        # Whoever knows more than was told here may know more of those that are left, too.
        self._factory, self._is_whole = None, self._is_whole and are_left
        return frame


def _fields(view: Any) -> dict[str, Any]:
    """A view as it is told, by field: what has parts as JSON, else what is kept of thousands of bids keeps the collector of garbage busy."""
    fields: dict[str, Any] = msgspec.to_builtins(view)
    for field, value in fields.items():
        if isinstance(value, list | tuple | dict):
            fields[field] = _encoder.encode(value)
    return fields


def whole(head: dict[str, Any], known: dict[str, list[dict[str, Any]]]) -> bytes:
    """A snapshot as JSON, entity by entity: made in another thread, it holds the loop's up no longer than one of them takes.

    Args:
        head: what it says beside its entities.
        known: see `Updates.known`.
    """
    return _encoder.encode(
        head | {collection: array(map(_raw, entities)) for collection, entities in known.items()}
    )


def array(entities: Iterable[Any]) -> msgspec.Raw:
    """Entities as JSON, one after the other."""
    return msgspec.Raw(b"[" + b",".join(map(_encoder.encode, entities)) + b"]")


def plain(fields: dict[str, Any]) -> dict[str, Any]:
    """An entity of `Updates.known` as it is decoded from a frame."""
    return {
        field: msgspec.json.decode(value) if type(value) is bytes else value
        for field, value in fields.items()
    }


def _raw(fields: dict[str, Any]) -> dict[str, Any]:
    return {field: msgspec.Raw(value) if type(value) is bytes else value for field, value in fields.items()}


def _difference(before: dict[str, Any], view: dict[str, Any]) -> dict[str, Any]:
    """What of an entity is different from before, and its id."""
    return {"id": view["id"]} | {field: value for field, value in view.items() if value != before[field]}

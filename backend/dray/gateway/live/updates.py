"""Updates: the difference between what a room's clients know and the present, as a frame.

For a known entity, a frame has its id and the changed fields: a heartbeat changes five of a vehicle's 30
fields. The last view sent is kept per entity.
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
    """Gathers changes until they are sent."""

    def __init__(self) -> None:
        self._told: dict[str, dict[str, Any]] = {collection: {} for collection in COLLECTIONS.values()}
        """Per collection and id, the last view sent, by field."""
        self._changed: dict[str, dict[str, Any]] = {collection: {} for collection in COLLECTIONS.values()}
        """Per collection and id, the changed view to send."""
        self._gone: dict[str, None] = {}
        """Names, as in `Delta.gone`; a dict for its order."""
        self._factory: FactoryView | None = None
        self._is_whole = False
        """Whether the next frame sends whole entities, because a client may know another state than
        `_told`."""

    @property
    def waiting(self) -> bool:
        """Whether there are changes to send."""
        return self._factory is not None or bool(self._gone) or any(self._changed.values())

    def note(self, delta: Delta) -> None:
        """Take in changes."""
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
        """Send these whole in the next frame, because some client does not know them."""
        self._changed[collection] |= {view.id: view for view in views}
        self._is_whole = True

    def begin(self, snapshot: Snapshot) -> None:
        """Start: all clients know exactly this snapshot."""
        for collection in COLLECTIONS.values():
            views = getattr(snapshot, collection)
            self._told[collection] = {view.id: _fields(view) for view in views}

    def known(self) -> dict[str, list[dict[str, Any]]]:
        """What the clients know: entities by field, as `whole` encodes them.

        They never change in place; new ones replace them.
        """
        return {collection: list(told.values()) for collection, told in self._told.items()}

    def tell_whole(self) -> None:
        """Send whole entities next: a client got a snapshot that may be newer than what others know."""
        self._is_whole = True

    def frame(self, number: int, at_s: float, most: int | None = None) -> dict[str, Any]:
        """The next frame; its content counts as known from here on.

        Args:
            number: the frame's number.
            at_s: the wall clock.
            most: maximum entities of each collection in `MANY`, first changed first; the others wait for the
                next frame. None for all.
        """
        frame: dict[str, Any] = {"type": "delta", "number": number, "at_s": at_s, "factory": self._factory}
        are_left = False
        for collection, views in self._changed.items():
            told = self._told[collection]
            these = tuple(islice(views, most if collection in MANY else None))
            # Views go on changing in place, so a copy of what was sent is kept.
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
        # A client with a newer snapshot may also know more of the entities left over.
        self._factory, self._is_whole = None, self._is_whole and are_left
        return frame


def _fields(view: Any) -> dict[str, Any]:
    """A view by field, nested fields as JSON: kept bids as objects would burden the garbage collector."""
    fields: dict[str, Any] = msgspec.to_builtins(view)
    for field, value in fields.items():
        if isinstance(value, list | tuple | dict):
            fields[field] = _encoder.encode(value)
    return fields


def whole(head: dict[str, Any], known: dict[str, list[dict[str, Any]]]) -> bytes:
    """A snapshot as JSON, entity by entity: in another thread, it blocks the loop for one entity at most.

    Args:
        head: its fields other than entities.
        known: see `Updates.known`.
    """
    return _encoder.encode(
        head | {collection: array(map(_raw, entities)) for collection, entities in known.items()}
    )


def array(entities: Iterable[Any]) -> msgspec.Raw:
    """Entities as a JSON array."""
    return msgspec.Raw(b"[" + b",".join(map(_encoder.encode, entities)) + b"]")


def joined(arrays: Iterable[msgspec.Raw]) -> msgspec.Raw:
    """One JSON array of several."""
    return msgspec.Raw(b"[" + b",".join(inner for each in arrays if (inner := bytes(each)[1:-1])) + b"]")


def plain(fields: dict[str, Any]) -> dict[str, Any]:
    """An entity of `Updates.known` as it is decoded from a frame."""
    return {
        field: msgspec.json.decode(value) if type(value) is bytes else value
        for field, value in fields.items()
    }


def _raw(fields: dict[str, Any]) -> dict[str, Any]:
    return {field: msgspec.Raw(value) if type(value) is bytes else value for field, value in fields.items()}


def _difference(before: dict[str, Any], view: dict[str, Any]) -> dict[str, Any]:
    """The changed fields of an entity, and its id."""
    return {"id": view["id"]} | {field: value for field, value in view.items() if value != before[field]}

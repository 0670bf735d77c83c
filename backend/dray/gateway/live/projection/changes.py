"""Entities that changed or left since the last call."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice


class Changes:
    """Ids of one kind of entity."""

    __slots__ = ("_changed", "_gone", "_kind")

    def __init__(self, kind: str) -> None:
        self._kind = kind
        # Dicts for their order: the first one that changed comes first.
        self._changed: dict[str, None] = {}
        self._gone: dict[str, None] = {}

    def __bool__(self) -> bool:
        return bool(self._changed or self._gone)

    def mark(self, entity: str) -> None:
        """Mark an entity as changed or new."""
        self._changed[entity] = None
        if self._gone:
            self._gone.pop(entity, None)

    def drop(self, entity: str) -> None:
        """Mark an entity as gone."""
        self._changed.pop(entity, None)
        self._gone[entity] = None

    def take_changed(self, most: int | None = None) -> Iterable[str]:
        """The changed entities; forgets them.

        Args:
            most: maximum entities, first changed first; None for all.
        """
        if most is not None and len(self._changed) > most:
            taken = tuple(islice(self._changed, most))
            for entity in taken:
                del self._changed[entity]
            return taken
        changed, self._changed = self._changed, {}
        return changed

    def take_gone(self) -> Iterable[str]:
        """The entities that left, as `kind:id`; forgets them."""
        gone, self._gone = self._gone, {}
        return (f"{self._kind}:{entity}" for entity in gone)

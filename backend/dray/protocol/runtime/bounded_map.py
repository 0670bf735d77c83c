"""A bounded history."""

from __future__ import annotations

from typing import TypeVar

K = TypeVar("K")
V = TypeVar("V")


class BoundedMap(dict[K, V]):
    """A mapping that drops its oldest entry when it is full; an entry that is set again keeps its age.

    Args:
        kept: maximum number of entries. `update` does not check it.
    """

    __slots__ = ("_kept",)

    def __init__(self, kept: int) -> None:
        super().__init__()
        self._kept = kept

    def __setitem__(self, key: K, value: V) -> None:
        super().__setitem__(key, value)
        if len(self) > self._kept:
            del self[next(iter(self))]

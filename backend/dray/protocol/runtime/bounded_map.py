"""A history that cannot grow for ever."""

from __future__ import annotations

from typing import TypeVar

K = TypeVar("K")
V = TypeVar("V")


class BoundedMap(dict[K, V]):
    """A mapping that forgets its oldest entry when one too many is set; one that is set again keeps its age.

    Args:
        kept: so many entries at most. What `update` brings in is believed to be no more.
    """

    __slots__ = ("_kept",)

    def __init__(self, kept: int) -> None:
        super().__init__()
        self._kept = kept

    def __setitem__(self, key: K, value: V) -> None:
        super().__setitem__(key, value)
        if len(self) > self._kept:
            del self[next(iter(self))]

"""Ids of a plant from the names of another system, which may be anything."""

from __future__ import annotations

import re

from dray.plant.layout import short_name
from dray.plant.model import is_id

FOREIGN = re.compile(r"[^A-Za-z0-9_.]+")

UNSEEN = re.compile(r"[\x00-\x1f\x7f\u202a-\u202e\u2066-\u2069]")
"""Characters that a name may not have (`dray.plant.model.Name`)."""


def shown(name: str, most: int = 80) -> str:
    """A name of another system for display: without invisible characters, and cut."""
    return UNSEEN.sub("", name)[:most]


class Ids:
    """Ids in one space: each name gets one, and none is given twice.

    Args:
        prefix: precedes a name that does not begin with a letter.
        taken: ids that must not be given, in small letters.
    """

    def __init__(self, prefix: str, taken: frozenset[str] = frozenset()) -> None:
        self._prefix, self._reserved = prefix, taken
        self._taken: set[str] = set()

    def give(self, name: str) -> str:
        """An id for a name: the name itself where it may be one."""
        wanted = name
        if not is_id(wanted):
            wanted = FOREIGN.sub("-", name).strip("-.")
            if not wanted or not wanted[0].isalpha() or not wanted[0].isascii():
                wanted = f"{self._prefix}{wanted}"
            wanted = short_name(wanted)
        given, number = wanted, 1
        while given in self._taken or given.lower() in self._reserved:
            number += 1
            given = short_name(f"{wanted}-{number}")
        self._taken.add(given)
        return given

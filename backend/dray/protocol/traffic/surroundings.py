"""What a vehicle knows of others on the floor around it: hints for prices and refuges, and never a right to anything.

The leader of each table tells who holds something in its district (`FloorReported`). A vehicle listens to the districts in which it holds
something, and to those beside them; one that rests where it is in nobody's way need not know, and does not listen.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import msgspec

from dray.messages.floor.traffic import FloorReported, OnFloor
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.places import Places

COUNTS_S = 10.0
"""So long a word counts: three of them are lost, and a replica that died was replaced."""

AGAIN_S = 4.0
"""So long a word counts that was heard before the vehicle rested: until those have spoken that it listens to again."""


class _Word(msgspec.Struct, frozen=True, gc=False):
    """The newest word about one district."""

    told: FloorReported
    at_s: float
    until_s: float


class Surroundings:
    """Of one vehicle.

    Args:
        me: the vehicle: what is said of itself is no traffic.
        places: which districts there are, which lie side by side, and who keeps their reservation tables.
        key_of: the bus key on which a district is told.
    """

    def __init__(self, me: str, places: Places, key_of: Callable[[str], str], life: Life) -> None:
        self._me = me
        self._places = places
        self._key_of = key_of
        self._life = life
        self._words: dict[str, _Word] = {}
        self._inside: frozenset[str] = frozenset()
        self._heard: tuple[str, ...] = ()
        """The districts that it listens to."""

    def listen(self, inside: Iterable[str], now_s: float) -> None:
        """Listen to some districts and to those beside them from now on; to none where it rests."""
        inside = frozenset(inside)
        if inside == self._inside:
            return
        self._inside = inside
        heard = tuple(dict.fromkeys(near for one in sorted(inside) for near in self._places.around(one)))
        before, self._heard = self._heard, heard
        for district in before:
            if district not in heard:
                self._life.unsubscribe(self._key_of(district))
        for district in heard:
            if district in before:
                continue
            self._life.subscribe(self._key_of(district))
            if district in self._words:
                word = self._words[district]
                self._words[district] = msgspec.structs.replace(
                    word, until_s=max(word.until_s, now_s + AGAIN_S)
                )

    def on_floor(self, sender: str, told: FloorReported, now_s: float) -> bool:
        """A replica has told of a district; False when it is not believed, or is old."""
        if sender not in self._places.replicas_of.get(told.district, ()):
            return False
        before = self._words.get(told.district)
        if before is not None and now_s < before.at_s + COUNTS_S and _age(told) <= _age(before.told):
            return False
        self._words[told.district] = _Word(told, now_s, now_s + COUNTS_S)
        return True

    def silent_at(self, now_s: float) -> frozenset[str]:
        """Places that are held by somebody of whom nobody knows when it moves again."""
        words = (word for word in self._words.values() if now_s < word.until_s)
        return frozenset(
            place
            for word in words
            for vehicle in word.told.vehicles
            if vehicle.silent and vehicle.atv != self._me
            for place in vehicle.holds
        )

    def others(self, now_s: float) -> dict[str, OnFloor]:
        """The other vehicles, each as it was told last, with all that it holds in the districts that were told."""
        others: dict[str, OnFloor] = {}
        words = [word for word in self._words.values() if now_s < word.until_s]
        for word in sorted(words, key=lambda one: (one.at_s, one.told.district)):
            for vehicle in word.told.vehicles:
                if vehicle.atv == self._me:
                    continue
                known = others.get(vehicle.atv)
                held = () if known is None else known.holds
                others[vehicle.atv] = (
                    msgspec.structs.replace(vehicle, holds=(*held, *vehicle.holds)) if held else vehicle
                )
        return others


def _age(told: FloorReported) -> tuple[int, int]:
    return told.epoch, told.number

"""A vehicle's knowledge of others around it: hints for prices and refuges, which grant no rights.

Each table's leader reports the vehicles that hold places in its district (`FloorReported`). A vehicle listens to the districts in
which it holds places, and to their neighbours. A vehicle that rests in nobody's way does not listen.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import msgspec

from dray.messages.floor.traffic import FloorReported, OnFloor
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.places import Places

COUNTS_S = 10.0
"""Time for which a report counts: long enough to lose three of them, or to replace a leader that died."""

AGAIN_S = 4.0
"""Time for which a report from before a rest counts, until the districts have reported again."""


class _Word(msgspec.Struct, frozen=True, gc=False):
    """The newest report of one district."""

    told: FloorReported
    at_s: float
    until_s: float


class Surroundings:
    """The surroundings of one vehicle.

    Args:
        me: the vehicle; reports of itself are left out.
        places: the districts, their neighbours and their replicas.
        key_of: the bus key on which a district is reported.
    """

    def __init__(self, me: str, places: Places, key_of: Callable[[str], str], life: Life) -> None:
        self._me = me
        self._places = places
        self._key_of = key_of
        self._life = life
        self._words: dict[str, _Word] = {}
        self._inside: frozenset[str] = frozenset()
        self._heard: tuple[str, ...] = ()
        """The districts to which it listens."""

    def listen(self, inside: Iterable[str], now_s: float) -> None:
        """Listen to these districts and their neighbours from now on; a resting vehicle passes none."""
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
        """Note a report of a district; False when its sender is no replica, or it is old."""
        if sender not in self._places.replicas_of.get(told.district, ()):
            return False
        before = self._words.get(told.district)
        if before is not None and now_s < before.at_s + COUNTS_S and _age(told) <= _age(before.told):
            return False
        self._words[told.district] = _Word(told, now_s, now_s + COUNTS_S)
        return True

    def silent_at(self, now_s: float) -> frozenset[str]:
        """Places that silent vehicles hold."""
        words = (word for word in self._words.values() if now_s < word.until_s)
        return frozenset(
            place
            for word in words
            for vehicle in word.told.vehicles
            if vehicle.silent and vehicle.atv != self._me
            for place in vehicle.holds
        )

    def others(self, now_s: float) -> dict[str, OnFloor]:
        """The other vehicles by their newest reports, with all places that they hold in the reported districts."""
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

"""The book of a district: by whom each place is held. Nothing in it depends on time.

Safety in two sentences. A place is granted to one vehicle only while no line of the book names another one for it, and the grant is said
only when a majority of the copies has the line. A line is struck out only on the vehicle's own word, said after it has seen that very
grant: so whatever is late, lost, doubled or out of order, a place that a vehicle may believe to hold is in the book.
Only a person who has carried a vehicle away speaks in its place; what it says itself counts again when it knows of that.
"""

from __future__ import annotations

from collections.abc import Iterable

from dray.errors import ProtocolViolation
from dray.messages.floor.traffic import AllRemoved, PlaceBooking, PlaceWished, Removed


class Book:
    """Lines by place. Numbers of grants only grow, whoever keeps the book.

    Args:
        bookings: what it begins with.
        version: the highest number that was given.
        removed: vehicles that were carried away.

    Attributes:
        lives: vehicle -> its newest life that is known.
    """

    def __init__(
        self,
        bookings: Iterable[PlaceBooking] = (),
        version: int = 0,
        removed: Iterable[Removed] = (),
    ) -> None:
        self._lines: dict[str, PlaceBooking] = {}
        self._by_atv: dict[str, dict[str, PlaceBooking]] = {}
        self.version = version
        self.lives: dict[str, int] = {}
        self._removed = {one.atv: one.number for one in removed}
        for booking in bookings:
            self._write(booking)

    def holder(self, place: str) -> str:
        """Who holds a place; empty for nobody."""
        line = self._lines.get(place)
        return line.atv if line is not None else ""

    def of(self, atv: str) -> tuple[PlaceBooking, ...]:
        """All lines of one vehicle."""
        return tuple(self._by_atv.get(atv, {}).values())

    @property
    def atvs(self) -> tuple[str, ...]:
        """All that hold something."""
        return tuple(atv for atv, lines in self._by_atv.items() if lines)

    @property
    def bookings(self) -> tuple[PlaceBooking, ...]:
        """All lines."""
        return tuple(self._lines.values())

    def grant(self, atv: str, places: Iterable[str]) -> None:
        """Write some places down for a vehicle, under a number of their own; all of them must be free, or its own."""
        self.version += 1
        for place in places:
            self._write(PlaceBooking(place=place, number=self.version, atv=atv))

    def strike(self, wish: PlaceWished, atv: str) -> bool:
        """Strike out what a vehicle has given back; True when there was something."""
        gone = [
            line.place for line in self.of(atv) if line.number <= wish.seen and line.place not in wish.holds
        ]
        self._rub_out(atv, gone)
        return bool(gone)

    def claim(self, atv: str, places: Iterable[str]) -> bool:
        """Write down what a vehicle tells in a roll call that it holds, as far as nobody does; True when there was something."""
        unknown = [place for place in places if not self.holder(place)]
        if unknown:
            self.grant(atv, unknown)
        return bool(unknown)

    def tell_late(self, atv: str, wish: PlaceWished) -> None:
        """A vehicle of which nobody knew was not asked in the roll call from which this book was made, and tells now."""
        self.version = max(self.version, wish.seen)
        self.claim(atv, wish.holds)

    def begin_life(self, atv: str, wish: PlaceWished) -> bool:
        """Note a vehicle's life. What a new one has not seen is granted anew, under a number that only a majority can make count.

        So whoever keeps an outdated book cannot tell a vehicle that has forgotten everything of grants that are void.
        """
        if wish.life <= self.lives.get(atv, 0):
            return False
        self.lives[atv] = wish.life
        lines = self.of(atv)
        if all(line.number <= wish.seen for line in lines):
            return False
        self.grant(atv, [line.place for line in lines])
        return True

    def removal_of(self, atv: str) -> int:
        """The number of the newest removal of a vehicle that the book knows of; 0 for none."""
        return self._removed.get(atv, 0)

    @property
    def removed(self) -> AllRemoved:
        """All of them."""
        return tuple(Removed(atv=atv, number=number) for atv, number in self._removed.items())

    def remove(self, atv: str, number: int) -> tuple[str, ...]:
        """A vehicle was carried away: strike out what it holds, once for each number.

        Returns:
            The places that are free now; none when that was known.
        """
        if number <= self.removal_of(atv):
            return ()
        self.version += 1
        self._removed[atv] = number
        places = tuple(line.place for line in self.of(atv))
        self._rub_out(atv, places)
        return places

    def _write(self, line: PlaceBooking) -> None:
        """Write a line down.

        Raises:
            ProtocolViolation: another vehicle holds the place; our own bug.
        """
        before = self._lines.get(line.place)
        if before is not None and before.atv != line.atv:
            raise ProtocolViolation(f"{line.place} is held by {before.atv} and was granted to {line.atv}")
        self._lines[line.place] = line
        self._by_atv.setdefault(line.atv, {})[line.place] = line

    def _rub_out(self, atv: str, places: Iterable[str]) -> None:
        for place in places:
            del self._lines[place], self._by_atv[atv][place]

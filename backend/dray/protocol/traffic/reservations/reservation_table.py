"""The reservation table of a district: by whom each place is held. Nothing in it depends on time.

Safety in two sentences. A place is granted to one vehicle only while no line of the table names another one for it, and the grant is said
only when a majority of the copies has the line. A line is struck out only on the vehicle's own word, said after it has seen that very
grant: so whatever is late, lost, doubled or out of order, a place that a vehicle may believe to hold is in the table.
Only a person who has carried a vehicle away speaks in its place; what it says itself counts again when it knows of that.

A vehicle is its name and its key (`PlaceRequested.key`). Whoever has stolen its certificate, and not its key, is another vehicle of that name:
it gives nothing back but its own.
"""

from __future__ import annotations

from collections.abc import Iterable

from dray.errors import ProtocolViolation
from dray.messages.floor.traffic import UNSIGNED, AllRemoved, PlaceRequested, PlaceReservation, Removed
from dray.protocol.traffic.numbers import highest_believed

PEOPLE = b""
"""In place of a key's mark, where a person has said that a vehicle was carried away."""


class ReservationTable:
    """Lines by place. Numbers of grants only grow, whoever keeps the table.

    Args:
        reservations: what it begins with.
        version: the highest number that was given.
        removed: vehicles that were carried away.

    Attributes:
        lives: vehicle -> the mark of its key, and its newest life that is known.
    """

    def __init__(
        self,
        reservations: Iterable[PlaceReservation] = (),
        version: int = 0,
        removed: Iterable[Removed] = (),
    ) -> None:
        self._lines: dict[str, PlaceReservation] = {}
        self._by_atv: dict[str, dict[str, PlaceReservation]] = {}
        self.version = version
        self.lives: dict[str, tuple[bytes, int]] = {}
        self._removed = {(one.atv, one.mark): one.number for one in removed}
        """Vehicle and mark of its key, or `PEOPLE` -> the newest removal that was said."""
        for reservation in reservations:
            self._write(reservation)

    def holder(self, place: str) -> str:
        """Who holds a place; empty for nobody."""
        line = self._lines.get(place)
        return line.atv if line is not None else ""

    def of(self, atv: str) -> tuple[PlaceReservation, ...]:
        """All lines of one vehicle."""
        return tuple(self._by_atv.get(atv, {}).values())

    @property
    def atvs(self) -> tuple[str, ...]:
        """All that hold something."""
        return tuple(atv for atv, lines in self._by_atv.items() if lines)

    @property
    def reservations(self) -> tuple[PlaceReservation, ...]:
        """All lines."""
        return tuple(self._lines.values())

    def of_key(self, atv: str, mark: bytes) -> tuple[PlaceReservation, ...]:
        """The lines that requests of a vehicle under a key are about."""
        return tuple(line for line in self.of(atv) if line.mark in (mark, b""))

    def hears(self, atv: str, mark: bytes) -> bool:
        """Whether requests of a vehicle under a key count: none other holds something in its name, or this one does too."""
        lines = self._by_atv.get(atv)
        return not lines or any(line.mark in (mark, b"") for line in lines.values())

    def grant(self, atv: str, places: Iterable[str], mark: bytes = b"") -> None:
        """Write some places down for a vehicle, under a number of their own; all of them must be free, or its own."""
        self.version += 1
        for place in places:
            self._write(PlaceReservation(place=place, number=self.version, atv=atv, mark=mark))

    def strike(self, request: PlaceRequested, atv: str) -> bool:
        """Strike out what a vehicle has given back; True when there was something."""
        gone = [
            line.place
            for line in self.of_key(atv, request.mark)
            if line.number <= request.seen and line.place not in request.holds
        ]
        self._rub_out(atv, gone)
        return bool(gone)

    def claim(self, atv: str, request: PlaceRequested) -> bool:
        """Write down what a vehicle tells in a recovery poll that it holds, as far as nobody does; True when there was something."""
        unknown = [place for place in request.holds if not self.holder(place)]
        if unknown:
            self.grant(atv, unknown, request.mark)
        return bool(unknown)

    def tell_late(self, atv: str, request: PlaceRequested) -> None:
        """A vehicle of which nobody knew was not asked in the recovery poll from which this table was made, and tells now."""
        self.version = highest_believed((request.seen,), self.version)
        self.claim(atv, request)

    def begin_life(self, atv: str, request: PlaceRequested) -> bool:
        """Note a vehicle's life. What a new one has not seen is granted anew, under a number that only a majority can make count.

        So whoever keeps an outdated reservation table cannot tell a vehicle that has forgotten everything of grants that are void. What was kept for
        it without its key, as by people who put it back, is its own from then on.
        """
        mark, life = self.lives.get(atv, (b"", 0))
        lines = self.of_key(atv, request.mark)
        is_new = request.mark != mark or request.life > life
        if not is_new and all(line.mark == request.mark for line in lines):
            return False
        self.lives[atv] = (request.mark, max(request.life, life) if request.mark == mark else request.life)
        if all(line.number <= request.seen and line.mark == request.mark for line in lines):
            return False
        self.grant(atv, [line.place for line in lines], request.mark)
        return True

    def removal_of(self, atv: str, mark: bytes | None = None) -> int:
        """The number of the newest removal of a vehicle that the table knows of; 0 for none.

        Args:
            atv: the vehicle.
            mark: of a key, where its own word under that key counts, too; None for people's word alone.
        """
        by_people = self._removed.get((atv, PEOPLE), 0)
        return by_people if mark is None else max(by_people, self._removed.get((atv, mark or UNSIGNED), 0))

    @property
    def removed(self) -> AllRemoved:
        """All of them."""
        return tuple(
            Removed(atv=atv, number=number, mark=mark) for (atv, mark), number in self._removed.items()
        )

    def remove(self, atv: str, number: int, mark: bytes | None = None) -> tuple[str, ...]:
        """A vehicle was carried away: strike out what it holds, once for each number.

        Args:
            atv: the vehicle.
            number: of the removal.
            mark: of its key, where it has said so itself: that is about what it holds under this key alone. None for a person's word.

        Returns:
            The places that are free now; none when that was known.
        """
        if number <= self.removal_of(atv, mark):
            return ()
        self.version += 1
        lines = self.of(atv) if mark is None else self.of_key(atv, mark)
        places = tuple(line.place for line in lines if self.removal_of(atv, line.mark) < number)
        self._rub_out(atv, places)
        if mark is not None:
            self._forget_words(atv)
        self._removed[atv, PEOPLE if mark is None else mark or UNSIGNED] = number
        return places

    def _forget_words(self, atv: str) -> None:
        """Forget which removals were known under keys that hold nothing: who has such a key says so again, and there is no end of keys."""
        holding = {PEOPLE, *(line.mark or UNSIGNED for line in self.of(atv))}
        for one in tuple(self._removed):
            if one[0] == atv and one[1] not in holding:
                del self._removed[one]

    def _write(self, line: PlaceReservation) -> None:
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

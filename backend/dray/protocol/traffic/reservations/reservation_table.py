"""The reservation table of a district: which vehicle holds each place. Nothing in it depends on time.

Three rules make it safe. A place is granted only while no line names another vehicle for it. A grant is sent only when a majority of
the copies has its line. A line is struck out only by a request of its vehicle that was sent after it saw that very grant.
So the table contains every place that a vehicle may believe to hold, even if messages are late, lost, doubled or reordered.
Only a person who has carried a vehicle away speaks in its place. Its own requests count again when it knows of that.

A vehicle is identified by its name and its key (`PlaceRequested.key`). A thief of its certificate without its key counts as another
vehicle of that name, and gives back only its own places.
"""

from __future__ import annotations

from collections.abc import Iterable

from dray.errors import ProtocolViolation
from dray.messages.floor.traffic import UNSIGNED, AllRemoved, PlaceRequested, PlaceReservation, Removed
from dray.protocol.traffic.numbers import highest_believed

PEOPLE = b""
"""Stands for a key's mark where a person has reported the removal of a vehicle."""


class ReservationTable:
    """Lines by place. Grant numbers only grow, also when the leader changes.

    Args:
        reservations: the first lines.
        version: the highest number given so far.
        removed: vehicles that were carried away.

    Attributes:
        lives: vehicle -> the mark of its key, and its newest known life.
    """

    def __init__(
        self,
        reservations: Iterable[PlaceReservation] = (),
        version: int = 0,
        removed: Iterable[Removed] = (),
    ) -> None:
        self._lines: dict[str, PlaceReservation] = {}
        self._by_atv: dict[str, dict[str, PlaceReservation]] = {}
        self._since: dict[str, int] = {}
        """Place whose line has got a new number (`begin_life`) -> the number under which its holder was granted it first."""
        self.version = version
        self.lives: dict[str, tuple[bytes, int]] = {}
        self._removed = {(one.atv, one.mark): one.number for one in removed}
        """Vehicle and mark of its key, or `PEOPLE` -> the newest removal reported."""
        for reservation in reservations:
            self._write(reservation)

    def holder(self, place: str) -> str:
        """The vehicle that holds a place; empty for none."""
        line = self._lines.get(place)
        return line.atv if line is not None else ""

    def of(self, atv: str) -> tuple[PlaceReservation, ...]:
        """All lines of one vehicle."""
        return tuple(self._by_atv.get(atv, {}).values())

    @property
    def atvs(self) -> tuple[str, ...]:
        """All vehicles that hold a place."""
        return tuple(atv for atv, lines in self._by_atv.items() if lines)

    @property
    def reservations(self) -> tuple[PlaceReservation, ...]:
        """All lines."""
        return tuple(self._lines.values())

    def of_key(self, atv: str, mark: bytes) -> tuple[PlaceReservation, ...]:
        """The lines of a vehicle that its requests under a key may change."""
        return tuple(line for line in self.of(atv) if line.mark in (mark, b""))

    def hears(self, atv: str, mark: bytes) -> bool:
        """Whether a vehicle's requests under a key count: its name holds nothing, or this key holds something."""
        lines = self._by_atv.get(atv)
        return not lines or any(line.mark in (mark, b"") for line in lines.values())

    def grant(self, atv: str, places: Iterable[str], mark: bytes = b"") -> None:
        """Enter places for a vehicle under a new number; all of them must be free, or its own."""
        self.version += 1
        for place in places:
            self._write(PlaceReservation(place=place, number=self.version, atv=atv, mark=mark))

    def strike(self, request: PlaceRequested, atv: str) -> int:
        """Strike out the lines that a vehicle has given back.

        Returns:
            The lowest number under which it was granted one of them; 0 when there were none.
        """
        gone = [
            line
            for line in self.of_key(atv, request.mark)
            if line.number <= request.seen and line.place not in request.holds
        ]
        oldest = min((self._since.get(line.place, line.number) for line in gone), default=0)
        self._rub_out(atv, [line.place for line in gone])
        return oldest

    def claim(self, atv: str, request: PlaceRequested) -> bool:
        """Enter the free ones of the places that a vehicle reports to hold in a recovery poll; True when there were any."""
        unknown = [place for place in request.holds if not self.holder(place)]
        if unknown:
            self.grant(atv, unknown, request.mark)
        return bool(unknown)

    def tell_late(self, atv: str, request: PlaceRequested) -> None:
        """Enter the late answer of a vehicle that was unknown during the recovery poll."""
        self.version = highest_believed((request.seen,), self.version)
        self.claim(atv, request)

    def begin_life(self, atv: str, request: PlaceRequested, copied: Iterable[PlaceReservation] = ()) -> bool:
        """Note a vehicle's life. Lines that a new life has not seen get a new number, which only a majority can make count.

        So a leader with an outdated table cannot send void grants to a vehicle that has forgotten everything. Lines without a key,
        as those for a vehicle that people put back, get its key. A line that the life before gave back is its own again while the
        copies have it: they believe no release of an earlier life, and this life may not know yet where its body goes.

        Args:
            atv: the vehicle.
            request: what it has said.
            copied: the lines that the copies have.
        """
        mark, life = self.lives.get(atv, (b"", 0))
        lines = self.of_key(atv, request.mark)
        is_new = request.mark != mark or request.life > life
        if is_new and request.mark:
            lines += tuple(
                line
                for line in copied
                if (line.atv, line.mark) == (atv, request.mark) and line.place not in self._lines
            )
        if not is_new and all(line.mark == request.mark for line in lines):
            return False
        self.lives[atv] = (request.mark, max(request.life, life) if request.mark == mark else request.life)
        if all(line.number <= request.seen and line.mark == request.mark for line in lines):
            return False
        for line in lines:
            self._since.setdefault(line.place, line.number)
        self.grant(atv, [line.place for line in lines], request.mark)
        return True

    def renew(self, atv: str, request: PlaceRequested) -> None:
        """Grant anew the lines of places where a vehicle has come to stand again, unless it has not seen their number yet.

        It may have given them back: a release that was late, or kept back, would strike out the line of what it holds now.
        """
        wanted = {place for group in request.groups for place in group}
        old = [
            line
            for line in self.of_key(atv, request.mark)
            if line.number <= request.renews and line.place in wanted
        ]
        if not old:
            return
        for line in old:
            self._since.setdefault(line.place, line.number)
        self.grant(atv, [line.place for line in old], request.mark)

    def removal_of(self, atv: str, mark: bytes | None = None) -> int:
        """The number of a vehicle's newest known removal; 0 for none.

        Args:
            atv: the vehicle.
            mark: of the key whose reports count, too; None to count people's reports only.
        """
        by_people = self._removed.get((atv, PEOPLE), 0)
        return by_people if mark is None else max(by_people, self._removed.get((atv, mark or UNSIGNED), 0))

    @property
    def removed(self) -> AllRemoved:
        """All known removals."""
        return tuple(
            Removed(atv=atv, number=number, mark=mark) for (atv, mark), number in self._removed.items()
        )

    def remove(self, atv: str, number: int, mark: bytes | None = None) -> tuple[str, ...]:
        """A vehicle was carried away: strike out what it holds, once for each number.

        Args:
            atv: the vehicle.
            number: of the removal.
            mark: of its key, when it reports this itself: then only lines of that key are struck out. None for a person's report.

        Returns:
            The freed places; none when the removal was known.
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

    def take_back(self, atv: str, number: int) -> tuple[str, ...]:
        """Strike out what is held under keys that claim a later removal than people's newest, which people insist on.

        Returns:
            The freed places.
        """
        claims = {one: claim for one, claim in self._removed.items() if one[0] == atv and one[1] != PEOPLE}
        places = tuple(
            line.place for line in self.of(atv) if claims.get((atv, line.mark or UNSIGNED), 0) > number
        )
        if not places:
            return ()
        self.version += 1
        self._rub_out(atv, places)
        for one, claim in claims.items():
            if claim > number:
                del self._removed[one]
        return places

    def _forget_words(self, atv: str) -> None:
        """Forget removals under keys that hold nothing: their number is unbounded, and the owner of such a key reports again."""
        holding = {PEOPLE, *(line.mark or UNSIGNED for line in self.of(atv))}
        for one in tuple(self._removed):
            if one[0] == atv and one[1] not in holding:
                del self._removed[one]

    def _write(self, line: PlaceReservation) -> None:
        """Enter a line.

        Raises:
            ProtocolViolation: another vehicle holds the place, which is our own bug.
        """
        before = self._lines.get(line.place)
        if before is not None and before.atv != line.atv:
            raise ProtocolViolation(f"{line.place} is held by {before.atv} and was granted to {line.atv}")
        self._lines[line.place] = line
        self._by_atv.setdefault(line.atv, {})[line.place] = line

    def _rub_out(self, atv: str, places: Iterable[str]) -> None:
        for place in places:
            del self._lines[place], self._by_atv[atv][place]
            self._since.pop(place, None)

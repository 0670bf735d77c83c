"""A replica's check of the tables it copies: it refuses one that takes a place from a vehicle without its release.

A line may be struck out in two cases. The vehicle has signed the release after it saw that very grant; or a person has reported
the vehicle's removal, and this replica has received that report itself. So a leader alone cannot take a place from a vehicle and
give it to another one.

A leader may keep a release back, and have the line confirmed to the vehicle's next life, which has seen no grant. So a release counts
only if its vehicle has not made itself known in a later life, and a later life believes only confirmations that name it.
"""

from __future__ import annotations

from collections.abc import Sequence

from dray.messages.floor.traffic import PlaceRequested, PlaceReservation, PlaceReservations, TableReplicated
from dray.protocol.traffic.numbers import FAR
from dray.protocol.traffic.traffic_map import IsSigned


class Witness:
    """The check for one district, at one of its replicas.

    Args:
        district: the district of the table.
        is_signed: whether a vehicle's request is signed by the key that it names.
    """

    def __init__(self, district: str, is_signed: IsSigned) -> None:
        self._district = district
        self._is_signed = is_signed
        self._carried: dict[str, int] = {}
        """Vehicle -> the copy's version when people last reported its removal: what it held until then is free."""
        self._lives: dict[str, dict[bytes, int]] = {}
        """Vehicle -> mark of its key -> its newest life. Several keys only while each of them holds a place."""

    def note_life(self, atv: str, request: PlaceRequested, own: PlaceReservations) -> None:
        """Note the life of a vehicle that has sent a signed request.

        Args:
            atv: the vehicle.
            request: what it has sent to this replica itself.
            own: the lines of the copy.
        """
        if not request.mark or request.life > FAR:
            return
        lives = self._lives.get(atv, {})
        if request.mark not in lives:
            holding = {line.mark for line in own if line.atv == atv} if lives else set()
            lives = self._lives[atv] = {mark: life for mark, life in lives.items() if mark in holding}
        lives[request.mark] = max(request.life, lives.get(request.mark, 0))

    def life_of(self, atv: str, mark: bytes) -> int:
        """The newest known life of a vehicle under a key; 0 for none."""
        return self._lives.get(atv, {}).get(mark, 0)

    def on_carried(self, atv: str, version: int) -> None:
        """A person has carried a vehicle away. It may count its lives from one again, because its journal is lost."""
        self._carried[atv] = version
        self._lives.pop(atv, None)

    def objections(
        self, own: PlaceReservations, version: int, replicated: TableReplicated
    ) -> Sequence[PlaceReservation]:
        """The lines for which a table must be refused; none when it can be copied.

        Args:
            own: the lines of the copy.
            version: of the copy.
            replicated: the table that the leader has written.

        Returns:
            Lines of the copy that are struck out without their vehicle's release, and new lines with an old number: an old request
            would seem to release these.
        """
        words: dict[tuple[str, bytes], list[PlaceRequested]] = {}
        for one in replicated.given_back:
            words.setdefault((one.atv, one.request.mark), []).append(one.request)
        new = {line.place: line for line in replicated.reservations}
        before = {line.place: line for line in own}
        gone = [
            line
            for line in own
            if line.mark
            and not _is_its_own(new.get(line.place), line)
            and line.number > self._carried.get(line.atv, -1)
            and not any(self._gives_back(request, line) for request in words.get((line.atv, line.mark), ()))
        ]
        odd = [
            line
            for line in replicated.reservations
            if line.number <= version and before.get(line.place) != line
        ]
        return gone + odd

    def _gives_back(self, request: PlaceRequested, line: PlaceReservation) -> bool:
        return (
            request.district == self._district
            and request.life >= self.life_of(line.atv, line.mark)
            and line.number <= request.seen
            and line.place not in request.holds
            and self._is_signed(line.atv, request)
        )


def _is_its_own(new: PlaceReservation | None, line: PlaceReservation) -> bool:
    """Whether the same vehicle still holds a line's place, perhaps under another number."""
    return new is not None and (new.atv, new.mark) == (line.atv, line.mark)

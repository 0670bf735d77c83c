"""What one replica knows of places that vehicles have given back: it copies no reservation table that takes one from a vehicle without its word.

A line is struck out rightly in one of two ways: its vehicle has signed that it gives the place back, after it has seen that very grant; or a
person has said that the vehicle was carried away, and this replica has heard that itself. So the replica that leads a reservation table cannot alone take a
place from a vehicle and give it to another one.
"""

from __future__ import annotations

from collections.abc import Sequence

from dray.messages.floor.traffic import PlaceRequested, PlaceReservation, PlaceReservations, TableReplicated
from dray.protocol.traffic.traffic_map import IsSigned


class Witness:
    """Of one district, at one of its replicas.

    Args:
        district: whose reservation table.
        is_signed: whether a vehicle's request is signed by the key that it names.
    """

    def __init__(self, district: str, is_signed: IsSigned) -> None:
        self._district = district
        self._is_signed = is_signed
        self._carried: dict[str, int] = {}
        """Vehicle -> the version of the copy when a person has said last that it was carried away: what it held until then is free."""

    def on_carried(self, atv: str, version: int) -> None:
        """A person has said that a vehicle was carried away."""
        self._carried[atv] = version

    def objections(
        self, own: PlaceReservations, version: int, replicated: TableReplicated
    ) -> Sequence[PlaceReservation]:
        """The lines for which a reservation table cannot be copied; none where it can.

        Args:
            own: the lines of the copy.
            version: of the copy.
            replicated: what the leader of the table has written.

        Returns:
            Lines of the copy that are struck out without their vehicle's word, and new ones under a number that was given before: a
            word of before would seem to give them back.
        """
        words = {(one.atv, one.request.mark): one.request for one in replicated.given_back}
        new = {line.place: line for line in replicated.reservations}
        before = {line.place: line for line in own}
        gone = [
            line
            for line in own
            if line.mark
            and not _is_its_own(new.get(line.place), line)
            and line.number > self._carried.get(line.atv, -1)
            and not self._gives_back(words.get((line.atv, line.mark)), line)
        ]
        odd = [
            line
            for line in replicated.reservations
            if line.number <= version and before.get(line.place) != line
        ]
        return gone + odd

    def _gives_back(self, request: PlaceRequested | None, line: PlaceReservation) -> bool:
        return (
            request is not None
            and request.district == self._district
            and line.number <= request.seen
            and line.place not in request.holds
            and self._is_signed(line.atv, request)
        )


def _is_its_own(new: PlaceReservation | None, line: PlaceReservation) -> bool:
    """Whether a line's place is still held by the same vehicle, perhaps under another number."""
    return new is not None and (new.atv, new.mark) == (line.atv, line.mark)

"""Late answers: vehicles of which nobody knew when the recovery poll ran. They tell afterwards what they hold."""

from __future__ import annotations

from collections.abc import Iterable

from dray.messages.floor.traffic import PlaceRequested
from dray.protocol.traffic.numbers import FAR
from dray.protocol.traffic.reservations.reach import Reach
from dray.protocol.traffic.reservations.recovery_poll import BESIDE_MAX
from dray.protocol.traffic.reservations.reservation_table import ReservationTable


class LateAnswers:
    """Of one reservation table.

    Args:
        reach: how much of the floor one vehicle may have.

    Attributes:
        unknown: those that say to hold something; it is not known whether they are there.
    """

    def __init__(self, reach: Reach) -> None:
        self._reach = reach
        self._told: set[tuple[str, bytes]] | None = None
        """Who has told, with its key; None where the table was not made from a recovery poll."""
        self.unknown: set[str] = set()

    def start(self, told: Iterable[tuple[str, bytes]] | None) -> None:
        """A reservation table begins.

        Args:
            told: who has told in the recovery poll from which it was made, with its key; None where it was made otherwise.
        """
        self._told = None if told is None else set(told)
        self.unknown = set()

    def on_request(self, atv: str, request: PlaceRequested, table: ReservationTable, now_s: float) -> bool:
        """A vehicle says what it holds: one that has not told before tells now, and the table is changed.

        Returns:
            Whether its word counts; else it is not known yet whether it is there, and it will say it again.
        """
        if self._told is None or (atv, request.mark) in self._told:
            return True
        if request.removal < table.removal_of(atv):
            # Whatever it holds is void by a person's word.
            return True
        others = sum(one == atv for one, _ in self._told)
        if others and (not request.holds or others > BESIDE_MAX):
            # It has nothing to tell that would not come as well after the recovery poll.
            return True
        if request.seen > FAR or not self._reach.may_hold(atv, request.holds, now_s):
            self.unknown.add(atv)
            return False
        self.unknown.discard(atv)
        self._told.add((atv, request.mark))
        table.tell_late(atv, request)
        return True

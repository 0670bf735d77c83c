"""Late answers to a recovery poll, by vehicles that were unknown while it ran."""

from __future__ import annotations

from collections.abc import Iterable

from dray.messages.floor.traffic import PlaceRequested
from dray.protocol.traffic.numbers import FAR
from dray.protocol.traffic.reservations.reach import Reach
from dray.protocol.traffic.reservations.recovery_poll import BESIDE_MAX
from dray.protocol.traffic.reservations.reservation_table import ReservationTable


class LateAnswers:
    """The late answers about one reservation table.

    Args:
        reach: how much of the floor one vehicle may have.

    Attributes:
        unknown: vehicles that claim places, while their position is not known well enough to believe it.
    """

    def __init__(self, reach: Reach) -> None:
        self._reach = reach
        self._told: set[tuple[str, bytes]] | None = None
        """Vehicle and key of all answers; None when the table was not made from a recovery poll."""
        self.unknown: set[str] = set()

    def start(self, told: Iterable[tuple[str, bytes]] | None) -> None:
        """Start with a new table.

        Args:
            told: vehicle and key of all answers in its recovery poll; None when it was not made from one.
        """
        self._told = None if told is None else set(told)
        self.unknown = set()

    def on_request(self, atv: str, request: PlaceRequested, table: ReservationTable, now_s: float) -> bool:
        """Handle a request; if it is a first answer, enter what the vehicle holds into the table.

        Returns:
            Whether the request counts; otherwise the vehicle's position is not known yet, and it will repeat the request.
        """
        if self._told is None or (atv, request.mark) in self._told:
            return True
        if request.removal < table.removal_of(atv):
            # A person has carried it away since: what it holds is void.
            return True
        others = sum(one == atv for one, _ in self._told)
        if others and (not request.holds or others > BESIDE_MAX):
            # Nothing to enter; or too many keys have answered under this name.
            return True
        if request.seen > FAR or not self._reach.may_hold(atv, request.holds, now_s):
            self.unknown.add(atv)
            return False
        self.unknown.discard(atv)
        self._told.add((atv, request.mark))
        table.tell_late(atv, request)
        return True

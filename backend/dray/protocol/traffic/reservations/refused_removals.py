"""Reports of carried-away vehicles that a replica refuses: people are told why, once for each report and reason.

A vehicle's places stay taken while its replicas refuse the report, so people must know what to do. In the first minute every report is
refused, because the vehicle may be sending over a bad link. That is told only if it lasts.
"""

from __future__ import annotations

from collections.abc import Mapping

from dray.messages import Removal, RemovalRefusal
from dray.messages.fact import RemovalRefused
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.life import Life
from dray.protocol.runtime.throttle import NAMES_KEPT, Throttle
from dray.protocol.traffic.removal_authorisation import (
    EXPIRED,
    HEARD_SINCE,
    IS_HEARD,
    LISTEN_S,
    NO_PLACE,
    NOT_THERE,
    NOT_TRUSTED,
    TOO_EARLY,
)

REFUSALS: Mapping[str, RemovalRefusal] = {
    NOT_TRUSTED: RemovalRefusal.NOT_TRUSTED,
    EXPIRED: RemovalRefusal.EXPIRED,
    NO_PLACE: RemovalRefusal.NO_PLACE,
    NOT_THERE: RemovalRefusal.NOT_THERE,
    TOO_EARLY: RemovalRefusal.TOO_EARLY,
    IS_HEARD: RemovalRefusal.IS_HEARD,
    HEARD_SINCE: RemovalRefusal.HEARD_SINCE,
}

PASSING = frozenset({TOO_EARLY, IS_HEARD})
"""Objections that end by themselves when the vehicle is silent."""


class _Report:
    """The newest report of one vehicle.

    Attributes:
        number: of the report.
        since_s: since when it is refused without a break; None when it was accepted last.
        told: the objections that people were told.
    """

    __slots__ = ("number", "since_s", "told")

    def __init__(self, number: int) -> None:
        self.number = number
        self.since_s: float | None = None
        self.told: set[str] = set()


class RefusedRemovals:
    """Tells people why one agent refuses their reports."""

    def __init__(self, life: Life) -> None:
        self._life = life
        self._reports: BoundedMap[str, _Report] = BoundedMap(NAMES_KEPT)
        self._untrusted: BoundedMap[str, int] = BoundedMap(NAMES_KEPT)
        """Vehicle -> number of the report without a trusted signature that was told last."""
        self._throttle = Throttle()

    def refuse(self, removal: Removal, objection: str, now_s: float) -> None:
        """Note a refused report, and tell people why if they do not know yet."""
        if objection == NOT_TRUSTED:
            # Anybody can say that, with any number: it hides nothing of people's own reports.
            if self._untrusted.get(removal.atv) != removal.number and self._throttle.passes(
                removal.atv, now_s
            ):
                self._untrusted[removal.atv] = removal.number
                self._tell(removal, objection)
            return
        report = self._reports.get(removal.atv)
        if report is None or report.number < removal.number:
            report = self._reports[removal.atv] = _Report(removal.number)
        if report.number > removal.number or objection in report.told:
            return
        if report.since_s is None:
            report.since_s = now_s
        if objection in PASSING and now_s - report.since_s <= LISTEN_S:
            return
        report.told.add(objection)
        self._tell(removal, objection)

    def accept(self, removal: Removal) -> None:
        """Note an accepted report: a later refusal of it begins anew."""
        report = self._reports.get(removal.atv)
        if report is not None and report.number == removal.number:
            report.since_s = None

    def _tell(self, removal: Removal, objection: str) -> None:
        refused = RemovalRefused(atv=removal.atv, number=removal.number, reason=REFUSALS[objection])
        self._life.record(refused)

"""The leader's reports of the vehicles in its district: soon after changes, and now and then while they stand."""

from __future__ import annotations

from dray.messages.floor.traffic import NEAR_NODES, FloorReported, OnFloor
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.neighbours import Neighbours, Seen
from dray.protocol.traffic.reservations.reservation_table import ReservationTable

NEWS_S = 0.5
"""Longest delay of news. With 1 s, a tenth of the transports takes 18 s longer on single track
(`dray bench traffic --plant single-track-12`)."""

AGAIN_S = 3.0
"""Interval of repeated reports while vehicles are there: another vehicle may have come close, or missed one."""


class FloorReport:
    """The reports of one district.

    Args:
        district: its name.
        key: the bus key on which they are published.
        neighbours: what is known of the vehicles.

    Attributes:
        due_s: when the report must be repeated.
    """

    def __init__(self, district: str, key: str, neighbours: Neighbours, life: Life) -> None:
        self._district, self._key = district, key
        self._neighbours, self._life = neighbours, life
        self._told: tuple[OnFloor, ...] = ()
        self._number = 0
        self._said_s = -AGAIN_S
        self.due_s = NEVER_S

    def tell(self, table: ReservationTable, epoch: int, now_s: float) -> None:
        """Publish a report, if it is news or its repetition is due."""
        if now_s - self._said_s < NEWS_S - 0.01:
            return
        vehicles = tuple(self._on_floor(table, atv, now_s) for atv in sorted(table.atvs))
        if vehicles == self._told and now_s < self.due_s:
            return
        self._number += 1
        self._told, self._said_s = vehicles, now_s
        self.due_s = now_s + AGAIN_S if vehicles else NEVER_S
        told = FloorReported(district=self._district, epoch=epoch, number=self._number, vehicles=vehicles)
        self._life.publish(self._key, told)

    def _on_floor(self, table: ReservationTable, atv: str, now_s: float) -> OnFloor:
        seen = self._neighbours.of(atv) or Seen(at_s=now_s)
        return OnFloor(
            atv=atv,
            holds=tuple(line.place for line in table.of(atv)),
            stands=seen.stands,
            docked=seen.docked,
            silent=self._neighbours.is_silent(atv, now_s),
            rank=seen.rank,
            route=seen.route[:NEAR_NODES],
        )

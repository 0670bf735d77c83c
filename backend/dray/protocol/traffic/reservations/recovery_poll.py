"""A recovery poll: too few replicas of a reservation table remember it, so every vehicle is asked what it holds."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator

from dray.messages.floor.traffic import HoldsAsked, PlaceGranted, PlaceRequested
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.numbers import ALONE_MAX, FAR, OUTBID_MAX, highest_believed
from dray.protocol.traffic.reservations.reservation_table import ReservationTable

POLL_S = 6.0
"""Shortest recovery poll: every vehicle sends a heartbeat in that time, also one that is not in the plant file."""

WAVE = 200
"""Maximum vehicles asked at once: a plant of a thousand is asked within `POLL_S`, and no link or inbox is flooded."""

AGAIN_S, AGAIN_AT_MOST_S = 1.0, 5.0
"""First and longest interval until a vehicle is asked again, doubled each time; the longest is the idle heartbeat interval."""

BESIDE_MAX = 3
"""Further keys that may answer under one vehicle's name. With so many, the recovery poll waits until people have solved it."""

RAISE_AGAIN_S = 30.0
"""Shortest time between two restarts of a poll by one vehicle that reports a later epoch, so that no liar delays it for ever."""

QUIET_S = 6.0
"""Time without a first answer after which the poll stands still, and the missing vehicles are named. As long as new answers
come, it makes progress, however slow the machines are."""


class RecoveryPoll:
    """The recovery poll of one district, held by the replica that will lead.

    Args:
        district: the district whose table is lost.
        next_turn: the next epoch after a given one under which this replica may lead.
        now_s: when the poll begins.

    Attributes:
        told: vehicle -> its answer.
        epoch: the poll's epoch; grants of earlier ones are void.
    """

    def __init__(self, district: str, next_turn: Callable[[int], int], now_s: float, life: Life) -> None:
        self.told: dict[str, PlaceRequested] = {}
        self._by_people: set[str] = set()
        """Vehicles that a person has reported as off the floor, or as being put back."""
        self._beside: dict[str, dict[bytes, PlaceRequested]] = {}
        """Vehicle -> key -> answers in its name under other keys. It is unknown which is its own, so the places of all are held."""
        self.epoch = next_turn(0)
        self._district, self._next_turn, self._life = district, next_turn, life
        self._until_s = now_s + POLL_S
        self._news_s = now_s
        """When a vehicle last gave its first answer."""
        self._raised_s: dict[str, float] = {}
        """Vehicle -> when it last made the poll start anew."""
        self._later: dict[str, int] = {}
        """Vehicle -> the newest epoch that it reported above the poll's."""
        self._asks: dict[str, tuple[float, float]] = {}
        """Vehicle -> when it is asked again, and the interval after that."""

    def call(self, atvs: Iterable[str], now_s: float) -> None:
        """Ask those that have not answered and whose interval is over."""
        asked = HoldsAsked(district=self._district, epoch=self.epoch, recovery_poll=True)
        room = WAVE
        for atv in atvs:
            at_s, then_s = self._asks.get(atv, (now_s, AGAIN_S))
            if atv in self.told or at_s > now_s:
                continue
            if not room:
                return
            room -= 1
            self._asks[atv] = (now_s + then_s, min(2.0 * then_s, AGAIN_AT_MOST_S))
            self._life.send(atv, asked)

    def note(
        self,
        atv: str,
        request: PlaceRequested,
        now_s: float,
        *,
        by_person: bool = False,
        insists: bool = False,
    ) -> bool:
        """Note the answer of a vehicle, or of a person in its place; True when it counts.

        Args:
            atv: the vehicle.
            request: the answer.
            now_s: the present time.
            by_person: whether a person gives it.
            insists: whether people have repeated it for so long that later removals, which only the vehicle claims, are lies.
        """
        if request.epoch > FAR or request.seen > FAR:
            # A lie: no reservation table reaches such numbers.
            return False
        if request.epoch > self.epoch:
            if now_s - self._raised_s.get(atv, -RAISE_AGAIN_S) < RAISE_AGAIN_S:
                return False
            self._raised_s[atv] = now_s
            # The vehicle knows a later epoch: answers under this one may be outdated. A single vehicle cannot raise the epoch far: else
            # the poll would run under an epoch that no replica follows, or at the end of numbers.
            self._later[atv] = request.epoch
            others = (epoch for other, epoch in self._later.items() if other != atv)
            known = max(self.epoch, min(max(others, default=0), ALONE_MAX))
            self.told, self.epoch = {}, self._next_turn(min(request.epoch, known + OUTBID_MAX))
            self._by_people, self._beside = set(), {}
            self._asks, self._news_s = {}, now_s
            return False
        before = self.told.get(atv)
        is_beside = (
            before is not None
            and before.mark != request.mark
            and not by_person
            and atv not in self._by_people
            and request.epoch == self.epoch
        )
        if is_beside:
            return self._note_beside(atv, request)
        if insists:
            if atv in self._by_people and before is not None and before.removal >= request.removal:
                return False
            before = None
        if before is not None and before.mark in (request.mark, b"") and request.removal < before.removal:
            self._life.send(
                atv,
                PlaceGranted(
                    district=self._district,
                    epoch=self.epoch,
                    life=request.life,
                    upto=0,
                    grants=(),
                    removal=before.removal,
                ),
            )
            return False
        if request.epoch < self.epoch:
            return False
        if before is not None and _age(request) <= _age(before):
            return False
        if before is None:
            self._news_s = now_s
        self.told[atv] = request
        (self._by_people.add if by_person else self._by_people.discard)(atv)
        if by_person:
            # Of the other keys only one that knows of this removal holds anything.
            beside = self._beside.pop(atv, {})
            self._beside[atv] = {
                mark: one
                for mark, one in beside.items()
                if one.removal == request.removal or (one.removal > request.removal and not insists)
            }
        return True

    def _note_beside(self, atv: str, request: PlaceRequested) -> bool:
        """Note an answer under this name with another key; those beyond `BESIDE_MAX` keys wait for people."""
        others = self._beside.setdefault(atv, {})
        before = others.get(request.mark)
        if before is not None and _age(request) <= _age(before):
            return False
        if before is None and len(others) >= BESIDE_MAX:
            return False
        others[request.mark] = request
        return True

    @property
    def keys(self) -> Iterator[tuple[str, bytes]]:
        """Vehicle and key of all answers."""
        yield from ((atv, request.mark) for atv, request in self.told.items())
        yield from ((atv, mark) for atv, others in self._beside.items() for mark in others)

    def is_over(self, atvs: Callable[[], Iterable[str]], now_s: float) -> bool:
        """Whether the shortest time is over and all these vehicles have answered."""
        return now_s >= self._until_s and all(self._has_told(atv) for atv in atvs())

    def awaited(self, atvs: Iterable[str], now_s: float) -> Iterator[str]:
        """Vehicles that have not answered, once the poll stands still."""
        if now_s >= max(self._until_s, self._news_s + QUIET_S):
            yield from (atv for atv in atvs if not self._has_told(atv))

    def _has_told(self, atv: str) -> bool:
        return atv in self.told and len(self._beside.get(atv, ())) < BESIDE_MAX

    def table(self, may_hold: Callable[[str, Collection[str]], bool], version: int = 0) -> ReservationTable:
        """The table from all answers; when two claim one place, the first gets it.

        Args:
            may_hold: whether a vehicle's claim to these places is believed; otherwise it gets none of them.
            version: the highest known version of a copy.
        """
        table = ReservationTable(
            version=highest_believed((request.seen for request in self.told.values()), version)
        )
        for atv, request in self.told.items():
            is_removed = atv in self._by_people
            table.remove(atv, request.removal, None if is_removed else request.mark)
            table.lives[atv] = (request.mark, request.life)
            for one in (request, *self._beside.get(atv, {}).values()):
                if one.removal < request.removal and is_removed:
                    continue
                if may_hold(atv, one.holds):
                    table.claim(atv, one)
        return table


def _age(request: PlaceRequested) -> tuple[int, int, int]:
    return request.removal, request.life, request.seq

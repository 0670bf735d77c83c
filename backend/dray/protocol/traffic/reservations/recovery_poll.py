"""A recovery poll: too few replicas of a reservation table remember it, so every vehicle is asked what it holds."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator

from dray.messages.floor.traffic import HoldsAsked, PlaceGranted, PlaceRequested
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.numbers import ALONE_MAX, FAR, OUTBID_MAX, highest_believed
from dray.protocol.traffic.reservations.reservation_table import ReservationTable

POLL_S = 6.0
"""A recovery poll lasts so long at least: every vehicle beats in that time, also one that the plant file does not know."""

WAVE = 200
"""Vehicles asked at one time, at most: a plant of a thousand is asked within `POLL_S`, and no link or inbox is flooded."""

AGAIN_S, AGAIN_AT_MOST_S = 1.0, 5.0
"""Who has not told is asked again after this, doubled each time, up to as long as an idle vehicle is quiet anyway."""

BESIDE_MAX = 3
"""Keys that tell under the name of one vehicle, beside the first: with so many the recovery poll is not over before people have seen to it."""

RAISE_AGAIN_S = 30.0
"""Once in so long one vehicle lets a recovery poll start anew, since it knows of a later epoch: whoever says ever later ones holds nobody up for ever."""

QUIET_S = 6.0
"""When nobody new has told for so long the recovery poll stands still, and those that are missing are awaited by name: as long as
others tell, it is merely under way, however slow the machines are."""


class RecoveryPoll:
    """Of one district, by the replica who will lead.

    Args:
        district: whose reservation table is lost.
        next_turn: the next epoch after a given one under which this replica may lead.
        now_s: when it begins.

    Attributes:
        told: vehicle -> what it has told.
        epoch: grants of earlier ones count for nothing.
    """

    def __init__(self, district: str, next_turn: Callable[[int], int], now_s: float, life: Life) -> None:
        self.told: dict[str, PlaceRequested] = {}
        self._by_people: set[str] = set()
        """Vehicles of which a person has told that they are off the floor, or on their way back to it."""
        self._beside: dict[str, dict[bytes, PlaceRequested]] = {}
        """Vehicle -> key -> what others have told in its name: nobody knows whose word it is, so the places of all of them are held."""
        self.epoch = next_turn(0)
        self._district, self._next_turn, self._life = district, next_turn, life
        self._until_s = now_s + POLL_S
        self._news_s = now_s
        """When somebody has told for the first time, last."""
        self._raised_s: dict[str, float] = {}
        """Vehicle -> when it has let it start anew last."""
        self._later: dict[str, int] = {}
        """Vehicle -> the latest epoch that it has told, of those that were later than this one."""
        self._asks: dict[str, tuple[float, float]] = {}
        """Vehicle -> when it is asked again, and how long after that once more."""

    def call(self, atvs: Iterable[str], now_s: float) -> None:
        """Ask those that have not told, and were not asked a moment ago."""
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

    def note(self, atv: str, request: PlaceRequested, now_s: float, *, by_person: bool = False) -> bool:
        """A vehicle has told, or a person in its place; True when that counts."""
        if request.epoch > FAR or request.seen > FAR:
            # It lies: no reservation table has come farther.
            return False
        if request.epoch > self.epoch:
            if now_s - self._raised_s.get(atv, -RAISE_AGAIN_S) < RAISE_AGAIN_S:
                return False
            self._raised_s[atv] = now_s
            # The vehicle has known a later replica: what was told under this epoch may have changed since. Alone it is not believed how much
            # later: the poll would run under an epoch that no other one follows, or at the end of numbers.
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
        return True

    def _note_beside(self, atv: str, request: PlaceRequested) -> bool:
        """Another one has told under this name, with another key. Of too many the vehicle itself may be one: all wait for people."""
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
        """Who has told, with its key."""
        yield from ((atv, request.mark) for atv, request in self.told.items())
        yield from ((atv, mark) for atv, others in self._beside.items() for mark in others)

    def is_over(self, atvs: Callable[[], Iterable[str]], now_s: float) -> bool:
        """Whether all have told who may hold something."""
        return now_s >= self._until_s and all(self._has_told(atv) for atv in atvs())

    def awaited(self, atvs: Iterable[str], now_s: float) -> Iterator[str]:
        """Those that have not told, though whoever is awake has had the time."""
        if now_s >= max(self._until_s, self._news_s + QUIET_S):
            yield from (atv for atv in atvs if not self._has_told(atv))

    def _has_told(self, atv: str) -> bool:
        return atv in self.told and len(self._beside.get(atv, ())) < BESIDE_MAX

    def table(self, may_hold: Callable[[str, Collection[str]], bool], version: int = 0) -> ReservationTable:
        """The table as they have told it; of two that hold one place the first counts.

        Args:
            may_hold: whether a vehicle is believed that it holds these places; else it has none.
            version: the highest of a copy that is known.
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

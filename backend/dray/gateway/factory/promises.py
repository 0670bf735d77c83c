"""The promise ledger: what vehicles promised on contract, against the outcome.

It is computed from the facts in SQL, which are stored once each, so a restart changes nothing. Facts already
read are remembered: a look costs what has happened since the last one.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Iterable, Iterator, Sequence

import msgspec

from dray.gateway.factory.lateness import holds_of
from dray.gateway.http.csv_tables import Row, row_of
from dray.messages.fact import CarrierChanged, TaskClosed
from dray.messages.keys import STRATEGISTS
from dray.store import Store
from dray.store.history.events import EventFilter, EventRow

ON_TIME_S = 5.0
"""Factory seconds after its promise within which a transport counts as on time: the duration of docking."""

IMPLAUSIBLE_S = 86_400.0
"""Maximum plausible lateness in seconds: the task would have gone to another vehicle hours before."""

KEPT = 5_000
"""Maximum transports per vehicle in the figures, newest: some weeks of work."""

MAX_ATVS = 10_000
"""Maximum vehicles remembered: ten times the largest plant. It bounds invented ids."""

ROWS_AT_ONCE = 2_000
"""Facts per read, so that a long history does not block the database."""

_KINDS = (TaskClosed.__name__, CarrierChanged.__name__)


class PromiseLine(msgspec.Struct, frozen=True, kw_only=True):
    """How a vehicle keeps its promises; times in factory seconds, negative if early."""

    atv: str
    """Empty for the whole fleet."""
    delivered: int = 0
    """Transports delivered that had a promise: the newest 5,000 at most."""
    on_time: int = 0
    """Those delivered no later than `on_time_within_s` after the promise."""
    on_time_frac: float | None = None
    """None if nothing was delivered, as for the times below."""
    median_s: float | None = None
    """Median lateness."""
    p95_s: float | None = None
    worst_s: float | None = None
    worst_task: str = ""
    """Task of the worst one."""
    worst_held: str = ""
    """What held up the worst one longest, as `held` of `GET /api/tasks/history`; empty if nothing did or it
    is not stored any more."""
    worst_held_by: str = ""
    """What it waited for longest, or what was wrong."""
    lost: int = 0
    """Transports that another vehicle had to take over."""
    last_at_s: float | None = None
    """Wall clock time of the last delivery."""


FIELDS = PromiseLine.__struct_fields__


class PromiseLedger(msgspec.Struct, frozen=True, kw_only=True):
    """The ledger of all vehicles."""

    on_time_within_s: float
    fleet: PromiseLine
    items: tuple[PromiseLine, ...]
    """By vehicle id."""


class _Delivered(msgspec.Struct, frozen=True, gc=False):
    late_s: float
    task: str
    at_s: float


class _Account:
    """The record of one vehicle."""

    __slots__ = ("delivered", "lost")

    def __init__(self) -> None:
        self.delivered: deque[_Delivered] = deque(maxlen=KEPT)
        self.lost = 0


class Ledger:
    """Computes the ledger from the facts.

    Args:
        store: the database with the facts.
    """

    def __init__(self, store: Store) -> None:
        self._store = store
        self._accounts: dict[str, _Account] = {}
        self._read_to: int | None = None
        """Position of the last fact read."""
        self._reading = asyncio.Lock()

    async def read(self) -> PromiseLedger:
        """The present ledger."""
        async with self._reading:
            await self._read_on()
        everything = [each for account in self._accounts.values() for each in account.delivered]
        lost = sum(account.lost for account in self._accounts.values())
        lines = [
            _line("", everything, lost),
            *(_line(atv, account.delivered, account.lost) for atv, account in sorted(self._accounts.items())),
        ]
        fleet, *items = await self._explained(lines)
        return PromiseLedger(on_time_within_s=ON_TIME_S, fleet=fleet, items=tuple(items))

    async def _explained(self, lines: Sequence[PromiseLine]) -> list[PromiseLine]:
        """The lines with the cause of each worst transport."""
        worst = {line.worst_task for line in lines if line.worst_s is not None and line.worst_s > ON_TIME_S}
        async with self._store.read() as work:
            # All of these have ended.
            holds = await holds_of(work, (await work.tasks.many(worst)).values(), now_s=0.0)
        return [
            line
            if (hold := holds.get(line.worst_task)) is None
            else msgspec.structs.replace(line, worst_held=hold.doing, worst_held_by=hold.by)
            for line in lines
        ]

    async def _read_on(self) -> None:
        wanted = EventFilter(kinds=_KINDS)
        while True:
            async with self._store.read() as work:
                rows = await work.events.page(wanted, self._read_to, ROWS_AT_ONCE, newest_first=False)
            for row in rows:
                self._enter(row)
                self._read_to = row.position
            if len(rows) < ROWS_AT_ONCE:
                return

    def _enter(self, row: EventRow) -> None:
        # A strategist's carriers are machines, which promise production, not transports.
        if row.agent in STRATEGISTS:
            return
        try:
            fact = msgspec.json.decode(row.fact, type=TaskClosed | CarrierChanged)
        except msgspec.MsgspecError:
            return  # Written by another version of Dray.
        if isinstance(fact, CarrierChanged):
            if (account := self._account(fact.replaced)) is not None:
                account.lost += 1
        elif fact.outcome == "delivered" and fact.promised_s > 0:
            if (account := self._account(fact.carrier)) is not None:
                late_s = row.plant_s - fact.promised_s
                if abs(late_s) > IMPLAUSIBLE_S:
                    return  # Not plausible by any clock of this plant.
                account.delivered.append(_Delivered(late_s, fact.task, row.at_s))

    def _account(self, atv: str) -> _Account | None:
        if atv and atv not in self._accounts and len(self._accounts) < MAX_ATVS:
            self._accounts[atv] = _Account()
        return self._accounts.get(atv)


def rows(ledger: PromiseLedger) -> Iterator[Row]:
    """The ledger as table rows; the fleet comes last."""
    for line in (*ledger.items, ledger.fleet):
        yield row_of(FIELDS, msgspec.structs.replace(line, atv=line.atv or "fleet"))


def _line(atv: str, delivered: Iterable[_Delivered], lost: int) -> PromiseLine:
    ranked = sorted(delivered, key=lambda each: (each.late_s, each.at_s))
    if not ranked:
        return PromiseLine(atv=atv, lost=lost)
    on_time = sum(each.late_s <= ON_TIME_S for each in ranked)
    return PromiseLine(
        atv=atv,
        delivered=len(ranked),
        on_time=on_time,
        on_time_frac=on_time / len(ranked),
        median_s=_quantile(ranked, 0.5),
        p95_s=_quantile(ranked, 0.95),
        worst_s=ranked[-1].late_s,
        worst_task=ranked[-1].task,
        lost=lost,
        last_at_s=max(each.at_s for each in ranked),
    )


def _quantile(ranked: Sequence[_Delivered], part: float) -> float:
    """The nearest rank: always a real lateness."""
    return ranked[max(0, -int(-part * len(ranked) // 1) - 1)].late_s

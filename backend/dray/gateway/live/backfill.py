"""News from before the gateway's start, restored from the facts in SQL."""

from __future__ import annotations

from collections.abc import Iterable

import msgspec

from dray.gateway.live.projection.news import NEWS_KEPT, News
from dray.gateway.live.timescale import TimeScale
from dray.messages import Event
from dray.messages.fact import (
    AnyFact,
    CarrierChanged,
    ContractEnded,
    GoalLost,
    GoalWaits,
    HelpAsked,
    HelpPromised,
    LinkChanged,
    MemoryLost,
    TookOver,
)
from dray.store.history.events import EventFilter, EventRow
from dray.store.work import Work

TELLING = (
    TookOver,
    CarrierChanged,
    LinkChanged,
    HelpAsked,
    HelpPromised,
    GoalLost,
    GoalWaits,
    MemoryLost,
)
"""Kinds of facts that are news by themselves."""

ROWS = 4 * NEWS_KEPT
"""Maximum facts read: one piece of news takes two or three."""


async def backfill_news(work: Work, news: News, time: TimeScale) -> None:
    """Restore earlier news.

    Args:
        work: a transaction.
        news: the news to fill; should be empty.
        time: the current clocks. An earlier run of the plant may have had others, so times come from the wall
            clock.
    """
    kinds = tuple(fact.__name__ for fact in TELLING)
    rows = await work.events.page(EventFilter(kinds=kinds), None, ROWS, newest_first=True)
    _fold(news, reversed(rows), time)
    for each in news.views():
        if not each.confirmed:
            # Contracts that ended matter only for takeovers: the coordinator may have refused them.
            wanted = EventFilter(kinds=(ContractEnded.__name__,), task=each.task)
            _fold(news, await work.events.page(wanted, None, ROWS, newest_first=False), time)


def _fold(news: News, rows: Iterable[EventRow], time: TimeScale) -> None:
    for row in rows:
        try:
            fact = msgspec.json.decode(row.fact, type=AnyFact)
        except msgspec.MsgspecError:
            continue  # It was written by another version of Dray.
        at_s = time.to_plant_s(row.at_s)
        if isinstance(fact, HelpAsked | HelpPromised):
            fact = msgspec.structs.replace(fact, until_s=fact.until_s - row.plant_s + at_s)
        news.fold(
            Event(agent=row.agent, incarnation=row.incarnation, number=row.number, at_s=at_s, fact=fact)
        )

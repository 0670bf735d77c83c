"""Plain transports that people and programs order while processes are killed, and how each of them ended."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import cycle
from random import Random
from typing import Any
from urllib.parse import urlsplit

from dray.errors import UnavailableError
from dray.messages import Event, TransportState
from dray.plant import Plant
from dray_sim.bench.losses.fleet import Fleet
from dray_sim.bench.rest_work.calls import PIECES, Callers, Watch, button, call_once, loads, plan, tablet
from dray_sim.bench.rest_work.house import Client
from dray_sim.bench.row import Row, tail_row

TRIES = 180
"""Maximum attempts for one call, one second apart. A killed gateway restarts within seconds, on a busy computer within a
minute."""

ENDED = frozenset({"delivered", "cancelled"})

LOOK_S = 2.0
"""Interval of the checks whether all transports have ended (real seconds)."""


@dataclass(slots=True)
class Called:
    """The calls of a campaign and their results.

    Attributes:
        calls: planned number of calls.
        recurring: planned number of transports by a calendar.
        callers: the answers to the calls.
        schedules: ids of the schedules.
        found: all transports, as read over REST at the end.
        runs: schedules that have placed their transport, as read over REST at the end.
        asked_s: by transport, the time of its acceptance (plant clock).
    """

    calls: int
    recurring: int
    callers: Callers = field(default_factory=Callers)
    schedules: list[str] = field(default_factory=list)
    found: Sequence[Mapping[str, Any]] = ()
    runs: Sequence[Mapping[str, Any]] = ()
    asked_s: dict[str, float] = field(default_factory=dict)


class Calling:
    """Orders plain transports over REST: as a program, as a tablet and as a call button.

    Args:
        fleet: the fleet with the gateway.
        plant: the plant, for the loads.
        calls: number of calls.
        recurring: number of schedules, each for one transport.
        every_s: interval of the calls (real seconds).
    """

    def __init__(self, fleet: Fleet, plant: Plant, calls: int, recurring: int, every_s: float) -> None:
        self._fleet, self._plant, self._every_s = fleet, plant, every_s
        self._port = urlsplit(fleet.url).port or 0
        self._admin = Client(self._port, Authorization=f"Bearer {fleet.token}")
        self.called = Called(calls, recurring)
        self._who: dict[str, Client] = {}

    async def prepare(self) -> None:
        """Log a tablet in, make a key, and create the schedules.

        Raises:
            UnavailableError: the gateway refuses one of these.
        """
        called, url = self.called, self._fleet.database_url
        self._who = {
            "a program": self._admin,
            "a tablet": await tablet(self._port, url, self._plant),
            "a call button": await button(self._port, url),
        }
        called.schedules = await plan(
            self._admin, self._plant, called.recurring, called.calls * self._every_s + 240.0
        )

    async def call(self) -> None:
        """Start all calls, one per interval, and wait for their answers."""
        called, who = self.called, self._who
        wanted, began_s = loads(self._plant, Random("calls")), time.monotonic()
        async with asyncio.TaskGroup() as group:
            for number, name in zip(range(called.calls), cycle(who), strict=False):
                await asyncio.sleep(max(0.0, began_s + number * self._every_s - time.monotonic()))
                draft = next(wanted) | {"priority": ("normal", "high", "urgent", "low")[number // 3 % 4]}
                key = f"calls-{number}"
                group.create_task(call_once(called.callers, name, who[name], key, draft, TRIES))

    async def see_out(self, patience_s: float) -> None:
        """Wait until all transports have ended, or until none has ended for `patience_s` (real seconds)."""
        ended, since_s = -1, time.monotonic()
        while time.monotonic() < since_s + patience_s:
            await asyncio.sleep(LOOK_S)
            try:
                await self._look()
            except UnavailableError:
                continue  # The gateway is away.
            now = sum(each["status"] in ENDED for each in self.called.found)
            came = len(self.called.runs) >= self.called.recurring
            if came and now == len(self.called.found) >= self.called.calls:
                return
            if now > ended:
                ended, since_s = now, time.monotonic()

    async def _look(self) -> None:
        called = self.called
        called.found = await self._admin.all("/api/transports")
        schedules = await self._admin.all("/api/schedules")
        called.runs = [each for each in schedules if each["last"] and each["id"] in called.schedules]


def rows_of(called: Called, events: Iterable[Event], asked_s: Mapping[str, float], kills: str) -> list[Row]:
    """The figures.

    Args:
        called: the calls and their results.
        events: all facts of agents.
        asked_s: by transport, the time of its acceptance by the gateway (plant clock).
        kills: the number of kills by kind, in words.
    """
    watch = Watch()
    for event in events:
        watch.on_message(event.at_s, event.agent, "", event)
    told = {each["id"] for each in called.found if each["status"] == "delivered"}
    brought = {
        name
        for name, ends in watch.ends.items()
        if name in told and ends == [TransportState.DELIVERED] and watch.counted[name] == PIECES
    }
    answered = [name for names in called.callers.accepted.values() for name in names]
    of_calendar = [each["last"]["transport"] for each in called.runs]
    ended_s = {each.fact.transport: each.at_s for each in _ends(events)}
    won_s = [at_s - asked_s[name] for name, at_s in watch.won_s.items() if name in asked_s]
    done_s = [at_s - asked_s[name] for name, at_s in ended_s.items() if name in asked_s and name in brought]
    by = ", ".join(f"{len(names)} by {name}" for name, names in called.callers.accepted.items())
    refused = called.callers.refused
    return [
        Row(
            "calls: answered with 201, brought once",
            len(brought.intersection(answered)),
            "loads",
            called.calls,
            "all calls",
            target=called.calls,
            note=f"{by}; {len(refused)} refused{': ' + refused[0] if refused else ''}; {kills}",
        ),
        Row(
            "calls: recurring, brought once",
            len(brought.intersection(of_calendar)),
            "loads",
            max(1, called.recurring),
            "all moments",
            target=called.recurring,
        ),
        Row(
            "calls: transports that nobody has called",
            len({each["id"] for each in called.found}.difference(answered, of_calendar)),
            "loads",
            called.calls + called.recurring,
            "all calls",
            target=0,
            less=True,
        ),
        tail_row("calls: from call to bid won, p95", won_s),
        tail_row("calls: from call to delivery, p95", done_s),
        tail_row("calls: from call to 201, p95", called.callers.waits_s, "real time"),
    ]


def _ends(events: Iterable[Event]) -> Iterable[Any]:
    for event in events:
        if getattr(event.fact, "state", None) is TransportState.DELIVERED:
            yield event

"""Plain transports that are called by programs, tablets and a call button, and recurring ones, beside production and with kills."""

from __future__ import annotations

import asyncio
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from http import HTTPStatus
from itertools import cycle
from random import Random
from typing import Any

from dray.errors import UnavailableError
from dray.gateway.access.gate import COOKIE
from dray.gateway.access.login.invitations import invite
from dray.gateway.access.principal import Scope
from dray.gateway.access.tokens import new_id, new_key
from dray.messages import Event, Message, TransportOrdered, TransportState, TransportWait
from dray.messages.fact import TransportProgressed
from dray.plant import Plant, default_plant
from dray.priorities import Priority
from dray.store import open_store
from dray.store.access.api_keys import ApiKey
from dray_sim.bench.rest_work.house import AGAIN_S, WRITTEN_WITHIN_S, Client, House, open_house, until_all
from dray_sim.bench.rest_work.killing import kill_in_turn
from dray_sim.bench.row import Row, tail_row
from dray_sim.bench.stop.house import log_in
from dray_sim.run.observer import percentile
from dray_sim.run.stage import Shift, Stage

CALLS, RECURRING = 500, 20

SPEED = 20.0
"""Times real time: a round trip over REST is so many times as long in the plant."""

LOAD = 0.4
"""Share of the machines' time for orders beside the calls."""

EVERY_S = 24.0
"""Interval between two calls (plant clock): 150 an hour, three times as many as the orders need."""

ON_S = 3600.0
"""Orders go on for this long after the calls. A storage that has filled itself meanwhile gets room for returned loads
when orders use some."""

KILL_EVERY_S, DEAD_S = 180.0, 30.0

PIECES = 4
"""Pieces in each load: nearly every place has room for so many."""

END_WITHIN_S = 7200.0
"""Longest time after the last call (plant clock)."""


class Watch:
    """When each transport was asked for, won and done: a `Listener`."""

    def __init__(self) -> None:
        self.asked_s: dict[str, float] = {}
        self.room_s: dict[str, float] = {}
        """When there was room for its load first: before that no vehicle is asked to carry it."""
        self.won_s: dict[str, float] = {}
        self.ends: dict[str, list[TransportState]] = {}
        self.counted: Counter[str] = Counter()
        """Pieces that the destination has counted at its ends, by transport."""

    def on_message(self, at_s: float, _sender: str, _address: str, message: Message) -> None:
        """Note one utterance."""
        if type(message) is TransportOrdered:
            self.asked_s.setdefault(message.transport, at_s)
        elif type(message) is Event and type(message.fact) is TransportProgressed:
            fact = message.fact
            if fact.wait is not TransportWait.NO_ROOM:
                self.room_s.setdefault(fact.transport, at_s)
            if fact.carrier:
                self.won_s.setdefault(fact.transport, at_s)
            if fact.state in (TransportState.DELIVERED, TransportState.CANCELLED):
                self.ends.setdefault(fact.transport, []).append(fact.state)
                self.counted[fact.transport] += fact.quantity


@dataclass(slots=True)
class Result:
    """Observations of the factory's thread."""

    kills: int
    watch: Watch
    orders: int
    delivered: int


@dataclass(slots=True)
class Callers:
    """The answers to the callers.

    Attributes:
        accepted: ids of transports, by caller.
        waits_s: real seconds until each was answered.
        refused: answers that were no 201.
    """

    accepted: dict[str, list[str]] = field(default_factory=dict)
    waits_s: list[float] = field(default_factory=list)
    refused: list[str] = field(default_factory=list)


def loads(plant: Plant, random: Random) -> Iterator[dict[str, Any]]:
    """Loads to call for, without end. A load to a machine is taken back to its source, so that nothing fills up."""
    while True:
        machine = random.choice(sorted(plant.machines))
        item = random.choice(sorted(set(plant.materials_of(machine)) - set(plant.parts)))
        storage = random.choice(sorted(plant.storages_of(item)))
        yield {"item": item, "quantity": PIECES, "from": storage, "to": machine}
        yield {"item": item, "quantity": PIECES, "from": machine, "to": storage}


async def work(stage: Stage, calls: int) -> Result:
    """Run the factory with orders, calls and kills, until all have ended."""
    watch = Watch()
    stage.listeners.add(watch)
    factory = stage.factory
    victims = [
        name
        for group in zip(
            cycle(stage.plant.fleet),
            cycle(factory.workcells),
            cycle(stage.plant.storages),
            factory.strategists * len(stage.plant.fleet),
            strict=False,
        )
        for name in group
    ]
    longest_s = calls * EVERY_S + END_WITHIN_S

    def is_over() -> bool:
        return len(watch.ends) >= calls or stage.now_s() > longest_s

    kills = await kill_in_turn(stage, victims, KILL_EVERY_S, DEAD_S, is_over)
    await stage.until_s(stage.shift.duration_s)
    await stage.settle(END_WITHIN_S)
    return Result(kills, watch, len(stage.orders), len(stage.observer.fulfilled_s))


async def call_all(calls: int, recurring: int, traffic: bool | None, *, on_s: float = ON_S) -> list[Row]:
    """Call, kill, and see that each was done once; orders come `on_s` longer than calls."""
    plant = default_plant()
    every = calls + recurring
    shift = Shift(name="calls", duration_s=calls * EVERY_S + on_s, load=LOAD)
    script = lambda stage: work(stage, every)  # noqa: E731
    async with open_house(plant, shift, script, speed=SPEED, traffic=traffic) as house:
        who = {
            "a program": house.admin,
            "a tablet": await tablet(house.port, house.database_url, plant),
            "a call button": await button(house.port, house.database_url),
        }
        schedules = await plan(house.admin, plant, recurring, calls * EVERY_S / SPEED)
        callers = await _call(house, plant, who, calls)
        result = await house.result
        ended = {"delivered", "cancelled"}
        await until_all(
            house.admin,
            "/api/transports",
            lambda found: all(each["status"] in ended for each in found),
            WRITTEN_WITHIN_S,
        )
        found = await house.admin.all("/api/transports")
        runs = [each for each in await house.admin.all("/api/schedules") if each["last"]]
    return _rows(calls, recurring, callers, result, found, schedules, runs)


async def _call(house: House[Result], plant: Plant, who: dict[str, Client], calls: int) -> Callers:
    callers, wanted = Callers(), loads(plant, Random("calls"))
    async with asyncio.TaskGroup() as group:
        for number, name in zip(range(calls), cycle(who), strict=False):
            while house.now_s() < number * EVERY_S and not house.result.done():  # noqa: ASYNC110 - that clock is another thread's
                await asyncio.sleep(AGAIN_S)
            priority = ("normal", "high", "urgent", "low")[number // 3 % 4]
            draft = next(wanted) | {"priority": priority}
            group.create_task(call_once(callers, name, who[name], f"work-{number}", draft))
    return callers


async def call_once(
    callers: Callers, name: str, client: Client, key: str, draft: dict[str, Any], tries: int = 20
) -> None:
    """Send one call until it is answered, and then once more: the repeat is the same call.

    Args:
        callers: takes the answer.
        name: of the caller.
        client: of the caller.
        key: the Idempotency-Key.
        draft: the transport to call for.
        tries: attempts without an answer, a second apart.
    """
    began_s = time.monotonic()
    for _ in range(tries):
        status, answer = await asyncio.to_thread(
            client.ask, "POST", "/api/transports", draft, **{"Idempotency-Key": key}
        )
        if status == HTTPStatus.CREATED:
            callers.waits_s.append(time.monotonic() - began_s)
            callers.accepted.setdefault(name, []).append(answer["id"])
            await asyncio.to_thread(client.ask, "POST", "/api/transports", draft, **{"Idempotency-Key": key})
            return
        if status not in (
            0,
            HTTPStatus.CONFLICT,
            HTTPStatus.TOO_MANY_REQUESTS,
            HTTPStatus.SERVICE_UNAVAILABLE,
        ):
            break
        await asyncio.sleep(1.0)
    callers.refused.append(f"{name}: {status} {answer}")


async def plan(admin: Client, plant: Plant, count: int, within_s: float) -> list[str]:
    """Recurring transports, each of which comes once in this run; returns their ids.

    Raises:
        UnavailableError: one is not taken.
    """
    wanted, names = loads(plant, Random("recurring")), []
    first = datetime.now(UTC) + timedelta(minutes=2)
    for number in range(count):
        at = first + timedelta(minutes=number % max(1, int(within_s / 60.0) - 3))
        draft = {
            "name": f"Round {number + 1}",
            "calendar": f"{at.minute} {at.hour} * * *",
            "time_zone": "UTC",
            "transport": next(wanted),
        }
        status, answer = await asyncio.to_thread(admin.ask, "POST", "/api/schedules", draft)
        if status != HTTPStatus.CREATED:
            raise UnavailableError("a schedule", f"was answered with {status}: {answer}", "see why")
        names.append(answer["id"])
    return names


async def tablet(port: int, database_url: str, plant: Plant) -> Client:
    """The tablet of a logged-in operator who answers for all areas."""
    store = await open_store(database_url)
    try:
        async with store.write() as access:
            [operator, *_] = [each for each in await access.people.all() if each.areas]
            await access.people.move(operator.id, plant.areas)
            link = await invite(access, operator.id, time.time())
    finally:
        await store.close()
    return Client(port, Cookie=f"{COOKIE}={await asyncio.to_thread(log_in, port, link)}")


async def button(port: int, database_url: str) -> Client:
    """A call button: its key may call transports and nothing else."""
    token = new_key()
    store = await open_store(database_url)
    try:
        async with store.write() as access:
            key = ApiKey(
                id=new_id(),
                name="Call button",
                scopes=Scope.TRANSPORTS_CALL.value,
                priority=Priority.URGENT.value,
                created_at_s=time.time(),
            )
            await access.api_keys.add(token, key)
    finally:
        await store.close()
    return Client(port, Authorization=f"Bearer {token}")


def _rows(
    calls: int,
    recurring: int,
    callers: Callers,
    result: Result,
    found: Sequence[dict[str, Any]],
    schedules: Sequence[str],
    runs: Sequence[dict[str, Any]],
) -> list[Row]:
    watch = result.watch
    once = {
        name
        for name, ends in watch.ends.items()
        if ends == [TransportState.DELIVERED] and watch.counted[name] == PIECES
    }
    answered = [name for names in callers.accepted.values() for name in names]
    delivered = {each["id"] for each in found if each["status"] == "delivered"}
    of_schedules = [each["last"]["transport"] for each in runs if each["id"] in schedules]
    done_again = [name for name in of_schedules if name in once and name in delivered]
    won_s = [watch.won_s[name] - at_s for name, at_s in watch.asked_s.items() if name in watch.won_s]
    from_room_s = [at_s - watch.room_s[name] for name, at_s in watch.won_s.items()]
    by = ", ".join(f"{len(names)} by {name}" for name, names in callers.accepted.items())
    return [
        Row(
            "work: calls answered with 201, brought once",
            len([name for name in set(answered) if name in once and name in delivered]),
            "loads",
            calls,
            "all calls",
            target=calls,
            note=f"{by}; {len(callers.refused)} refused{': ' + callers.refused[0] if callers.refused else ''}; {result.kills} agents killed",
        ),
        Row(
            "work: recurring calls, brought once",
            len(done_again),
            "loads",
            max(1, recurring),
            "all moments",
            target=recurring,
        ),
        Row(
            "work: transports that nobody has called",
            len(found) - len(set(answered)) - len(of_schedules),
            "loads",
            calls + recurring,
            "all calls",
            target=0,
            less=True,
        ),
        tail_row("work: from call to bid won, p95", won_s),
        Row(
            "work: from room to bid won, p95",
            percentile(from_room_s, 0.95),
            "s",
            max(1e-9, percentile(won_s, 0.95)),
            "from the call on",
            note=f"of the plant's clock; median {percentile(from_room_s, 0.5):.0f} s; before that there is no room where it is called to",
            less=True,
        ),
        tail_row(
            "work: from call to 201, p95",
            callers.waits_s,
            f"real time, at {SPEED:.0f} times real time in the same process",
        ),
        Row(
            "work: orders beside the calls, delivered",
            result.delivered,
            "orders",
            max(1, result.orders),
            "all orders",
            target=result.orders,
        ),
    ]

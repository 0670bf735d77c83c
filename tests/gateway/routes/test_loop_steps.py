"""The event loop never works at one thing for long: no step of any route does, whatever is asked of it."""

from __future__ import annotations

import asyncio
import gc
import gzip
import json
from collections.abc import AsyncIterator, Iterator
from contextvars import copy_context
from datetime import UTC, datetime
from pathlib import Path

import pytest
from databases import Files
from fake_injector import FakeInjector
from gateway_kit import BEARER, PRODUCT, House, gateway
from heartbeats import atv_heartbeat
from largest_inputs import LARGEST, hostile, large_draft, orders_file
from loop_monitor import SLOWEST, YARDSTICK_S, Asked, Tries, ask, be, loop_monitor
from msgspec import Raw
from msgspec.json import decode
from msgspec.structs import replace
from stream_sockets import opened
from wall_clock import NOW_S

from dray.gateway.access.principal import Principal, Scope
from dray.gateway.access.rules import RULES
from dray.gateway.http.middleware import BODY_BYTES
from dray.gateway.live.frames import MANY, Delta
from dray.gateway.live.projection.auctions.bids import MAX_BIDS
from dray.gateway.live.projection.auctions.tasks import MAX_OPEN, MAX_OPEN_EACH
from dray.gateway.live.replay.reader import ReplayReader
from dray.gateway.live.replay.recorder import WHOLE_EVERY_S, Recorder
from dray.gateway.orders.drafts import MAX_ITEMS
from dray.gateway.orders.placement import MAX_OPEN_ORDERS
from dray.messages import Event, Role, Transport, TransportCost
from dray.messages.fact import BidReceived, TaskOpened
from dray.settings import Settings
from dray.store.orders.orders import Item, Order
from dray.store.orders.progress import OrderStatus

pytestmark = pytest.mark.anyio

STEP_MS = 20.0
"""Processor time that a step may take."""

TRIES = 4
"""The least counts: what is new is imported and kept, and other work on the computer takes from its caches."""

BULK_BYTES = Settings().body_limit_bytes

HEADERS = {**BEARER, "Content-Type": "application/json", "Accept-Encoding": "gzip"}

AGAIN = {"Idempotency-Key": "full"}
"""Under which the orders were placed."""

NEVER_HZ = 1e-6

MANAGER = Principal(kind="admin", id="admin", name="Manager", scopes=frozenset(Scope))

NAMES = {
    "agent": "ATV1",
    "atv": "ATV1",
    "machine": "M1",
    "product": PRODUCT,
    "person": "nobody",
    "area": "north",
}
"""What path templates stand for; anything else is made or unknown."""

FILES = [
    route
    for route, rule in RULES.items()
    if rule.bulk or ("{draft}" in route[1] and route[0] in ("GET", "POST"))
]
"""Routes with bodies as large as files, and what is made of them."""


@pytest.fixture(scope="module")
async def full_house(files: Files, tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[House]:
    """A gateway with a thousand orders, and a draft as large as one may be."""
    async with gateway(files.new(tmp_path_factory.mktemp("full")), faults=FakeInjector(), duty=True) as house:
        answer = await house.client.post("/api/orders/import", json=orders_file(BULK_BYTES), headers=AGAIN)
        assert answer.status_code == 200, answer.text
        made = await house.client.post("/api/plant-drafts", json={"name": "Line 4"})
        NAMES["draft"] = made.json()["id"]
        NAMES["order"] = answer.json()["orders"][0]["id"]
        draft = f"/api/plant-drafts/{NAMES['draft']}"
        kept = await house.client.put(draft, json=large_draft(BULK_BYTES), headers={"If-Match": '"1"'})
        assert kept.status_code == 200, kept.text
        yield house


def path_of(template: str) -> str:
    parts = (
        NAMES.get(part.strip("{}"), "unknown") if part.startswith("{") else part
        for part in template.split("/")
    )
    return "/".join(parts)


async def longest_ms(
    house: House, method: str, template: str, body: bytes, query: str = "", **more: str
) -> tuple[float, int]:
    """The longest step of a request, and its status."""
    tries, status = Tries(), 0
    for _ in range(TRIES):
        headers = HEADERS | more
        if "{draft}" in template and method == "PUT":
            drafts = (await house.get("/api/plant-drafts"))["items"]
            version = next(each["version"] for each in drafts if each["id"] == NAMES["draft"])
            headers["If-Match"] = f'"{version}"'
        asked = Asked(method, path_of(template), body, tuple(headers.items()), query)
        with loop_monitor() as monitor:
            status, _ = await ask(house.app, asked, template)
        tries.note(monitor.longest_s[template], monitor.yardstick_s)
        # The least counts: another try would change nothing.
        if tries.least_ms <= STEP_MS:
            break
    return tries.least_ms, status


def inputs_of(house: House, method: str, template: str) -> list[tuple[str, bytes]]:
    """The largest bodies of a route, and what they are; an empty one where it takes none."""
    document = house.app.openapi()
    operation = document["paths"].get(template, {}).get(method.lower(), {})
    taken = operation.get("requestBody", {}).get("content", {}).get("application/json")
    if taken is None:
        assert (method, template) not in LARGEST
        return [("nothing", b"")]
    assert (method, template) in LARGEST, "it takes a body: name its largest in largest_inputs.LARGEST"
    size = BULK_BYTES if RULES[method, template].bulk else BODY_BYTES
    made = [
        (make.__name__, json.dumps(make(size), separators=(",", ":")).encode())
        for make in LARGEST[method, template]
    ]
    assert all(len(body) <= size for _, body in made)
    return [*made, *hostile(taken["schema"], document["components"]["schemas"], size)]


async def test_every_route_that_takes_a_body_has_its_largest_in_the_table(full_house: House) -> None:
    taking = {
        (method.upper(), path)
        for path, operations in full_house.app.openapi()["paths"].items()
        for method, operation in operations.items()
        if "requestBody" in operation
    }
    assert set(LARGEST) == taking


async def all_steps_are_short(house: House, method: str, template: str) -> None:
    operation = house.app.openapi()["paths"].get(template, {}).get(method.lower(), {})
    has = {parameter["name"] for parameter in operation.get("parameters", ())}
    queries = ["limit=500"] if "limit" in has else [""]
    if "format" in has:
        queries.append("format=csv")
    found = [
        (round(took_ms, 1), what, query, status)
        for what, body in inputs_of(house, method, template)
        for query in queries
        for took_ms, status in [await longest_ms(house, method, template, body, query)]
    ]
    print(f"\n{method} {template}", *max(found), sep=" | ")  # noqa: T201 - for who runs pytest with -s
    too_long = [each for each in sorted(found, reverse=True) if each[0] > STEP_MS]
    assert not too_long, too_long[:5]


@pytest.mark.parametrize(("method", "template"), FILES)
async def test_no_step_of_a_route_with_files_is_long(full_house: House, method: str, template: str) -> None:
    await all_steps_are_short(full_house, method, template)


async def test_no_step_of_a_file_of_orders_that_is_sent_again_is_long(full_house: House) -> None:
    body = json.dumps(orders_file(BULK_BYTES)).encode()
    took_ms, status = await longest_ms(full_house, "POST", "/api/orders/import", body, **AGAIN)
    assert status == 200
    assert took_ms <= STEP_MS


@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "template"), [route for route in RULES if route not in FILES and route[1] != "/api/stream"]
)
async def test_no_step_of_any_other_route_is_long(full_house: House, method: str, template: str) -> None:
    await all_steps_are_short(full_house, method, template)


@pytest.fixture
async def fullest(files: Files, tmp_path: Path) -> AsyncIterator[House]:
    """A gateway with as many open orders and tasks as it keeps, each as large as one may be, whose stream makes a frame when the test says so."""
    async with gateway(files.new(tmp_path), stream_rate_hz=NEVER_HZ) as house:
        projection = house.projection
        items = tuple(Item(PRODUCT, 5) for _ in range(MAX_ITEMS))
        for number in range(MAX_OPEN_ORDERS):
            projection.orders.put(
                Order(
                    id=f"O-{number:032d}",
                    status=OrderStatus.STORED,
                    customer="x" * 200,
                    token="t",
                    items=items,
                    created_at_s=NOW_S,
                    reference=f"{number}",
                    due_at_s=NOW_S + 1e6,
                )
            )
        for coordinator in range(MAX_OPEN // MAX_OPEN_EACH):
            for event in facts_of_tasks(f"M{coordinator}", MAX_OPEN_EACH, MAX_BIDS):
                projection.fold(event)
        assert len(projection.orders.ids()) == MAX_OPEN_ORDERS
        assert len(projection.tasks.ids()) == MAX_OPEN
        # A full collection looks at all that the process holds, in whosever step it falls: the stream answers for what it makes itself.
        gc.collect()
        gc.freeze()
        yield house
        gc.unfreeze()


def facts_of_tasks(coordinator: str, count: int, bids: int) -> Iterator[Event]:
    """A coordinator opens so many tasks, and gets so many bids for each."""
    work = Transport("shaft", 40, ("S1",), coordinator, "")
    cost = TransportCost(1.0, 2.0, 3.0, 4.0)
    number = 0
    for task in (f"{coordinator}-{each}" for each in range(count)):
        opened = TaskOpened(task, 1, Role.PRIMARY, 1, work, 10.0, 1000.0, 200.0)
        bid = BidReceived(task, 1, Role.PRIMARY, 1, "ATV1", cost, 10.0, 100.0)
        for fact in (opened, *(replace(bid, bidder=f"ATV{each}") for each in range(bids))):
            number += 1
            yield Event(agent=coordinator, incarnation=1, number=number, at_s=100.0, fact=fact)


@pytest.mark.slow
@pytest.mark.parametrize("scopes", [(), (Scope.FACTORY_READ,)], ids=["all of it", "without orders"])
async def test_no_step_of_the_stream_is_long_however_much_there_is_to_tell(
    fullest: House, scopes: tuple[Scope, ...]
) -> None:
    """A panel comes and is told all, and then all of it changes at once."""
    headers = (await fullest.key(*scopes))[1] if scopes else BEARER
    projection, loop = fullest.projection, asyncio.get_running_loop()
    expected = MAX_OPEN + (0 if scopes else MAX_OPEN_ORDERS)
    tries = [Tries(), Tries()]
    be("the gateway")
    gateways = copy_context()
    for attempt in range(TRIES):
        projection.discard_changes()
        async with opened(fullest, **headers) as socket:
            for turn, each in enumerate(tries):
                if turn:
                    projection.orders.cut_off([f"{attempt}"])
                    for task in projection.tasks.ids():
                        projection.tasks.changes.mark(task)
                told = set[str]()
                with loop_monitor() as monitor:
                    be("the test")
                    while len(told) < expected:
                        frame = await socket.read()
                        told |= {view["id"] for name in MANY for view in frame[name]}
                        loop.call_soon(fullest.hub.tick, context=gateways)
                    be("the gateway")
                each.note(monitor.but("the test"), monitor.yardstick_s)
        # The least counts: another try would change nothing.
        if max(each.least_ms for each in tries) <= STEP_MS:
            break
    least_ms = [each.least_ms for each in tries]
    print(f"\nWS /api/stream | {least_ms}")  # noqa: T201 - for who runs pytest with -s
    assert max(least_ms) <= STEP_MS


async def note_recorded(house: House, tries: list[Tries]) -> None:
    """The longest steps while all of it is taken in, while it is kept whole again and read unwritten, and while it is asked for as it is now."""
    projection, loop = house.projection, asyncio.get_running_loop()
    recorder = Recorder(projection, house.store, lambda: NOW_S, name="g.1", kept_s=1e6)
    reader = ReplayReader(house.store, recorder, projection)
    be("the gateway")
    gateways = copy_context()

    async def note(at_s: float) -> None:
        loop.call_soon(recorder.note, Delta(number=0, at_s=at_s), context=gateways)
        await asyncio.sleep(0)

    async def learn_all() -> None:
        be("the test")
        while recorder.now() is None:
            await note(NOW_S)

    async def keep_again() -> None:
        await note(NOW_S + WHOLE_EVERY_S)
        assert [piece.is_whole for piece in await recorder.unwritten()] == [True, True]

    told: list[bytes] = []

    async def ask_now() -> None:
        told.append(await reader.snapshot_now(MANAGER, NOW_S))

    for step, each in zip((learn_all, keep_again, ask_now), tries, strict=True):
        with loop_monitor() as monitor:
            await asyncio.create_task(step())
        each.note(monitor.but("the test"), monitor.yardstick_s)
    assert len(json.loads(told[0])["orders"]) == MAX_OPEN_ORDERS


@pytest.mark.slow
async def test_no_step_of_the_recording_is_long_however_much_there_is_to_keep(fullest: House) -> None:
    tries = [Tries(), Tries(), Tries()]
    for _ in range(TRIES):
        await note_recorded(fullest, tries)
        least_ms = [each.least_ms for each in tries]
        # The least counts: another try would change nothing.
        if max(least_ms) <= STEP_MS:
            break
    print(f"\nthe recording | {least_ms}")  # noqa: T201 - for who runs pytest with -s
    assert max(least_ms) <= STEP_MS


def shown_in(answer: bytes) -> tuple[int, int]:
    """How many orders and tasks a picture shows, or the one that a film begins with. What is told of each is left as it is."""
    told = decode(answer, type=dict[str, Raw])
    shown = decode(told["snapshot"], type=dict[str, Raw]) if "snapshot" in told else told
    orders, tasks = (decode(shown[name], type=list[Raw]) for name in ("orders", "tasks"))
    return len(orders), len(tasks)


@pytest.mark.slow
@pytest.mark.parametrize(("path", "encoding"), [("/api/replay", "identity"), ("/api/replay/film", "gzip")])
async def test_no_step_is_long_that_shows_the_present_before_anything_is_recorded(
    fullest: House, path: str, encoding: str
) -> None:
    """The recorder has not taken all of it in yet, or there is none."""
    assert fullest.recorder.now() is None
    tries, body = Tries(), b""
    headers = BEARER | {"Accept-Encoding": encoding}
    for _ in range(TRIES):
        with loop_monitor() as monitor:
            status, body = await ask(fullest.app, Asked("GET", path, b"", tuple(headers.items())), path)
        assert status == 200
        tries.note(monitor.longest_s[path], monitor.yardstick_s)
        if tries.least_ms <= STEP_MS:
            break
    assert shown_in(gzip.decompress(body) if encoding == "gzip" else body) == (MAX_OPEN_ORDERS, MAX_OPEN)
    print(f"\nGET {path} without a recording | {tries.least_ms}")  # noqa: T201 - for who runs pytest with -s
    assert tries.least_ms <= STEP_MS


@pytest.mark.slow
async def test_no_step_is_long_that_shows_a_recorded_moment(fullest: House) -> None:
    """All of it is recorded: the picture of a moment is as large as one may be, and a film begins with one."""
    while fullest.recorder.now() is None:
        fullest.recorder.note(Delta(number=0, at_s=NOW_S))
    moment = datetime.fromtimestamp(NOW_S, UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    headers = tuple((BEARER | {"Accept-Encoding": "gzip"}).items())
    for path, query in (
        ("/api/replay", f"at={moment}"),
        ("/api/replay/film", f"since={moment}&until={moment}"),
    ):
        tries = Tries()
        for _ in range(TRIES):
            with loop_monitor() as monitor:
                status, body = await ask(fullest.app, Asked("GET", path, b"", headers, query), path)
            assert status == 200
            tries.note(monitor.longest_s[path], monitor.yardstick_s)
            if tries.least_ms <= STEP_MS:
                break
        print(f"\nGET {path}, recorded | {tries.least_ms}")  # noqa: T201 - for who runs pytest with -s
        assert tries.least_ms <= STEP_MS
        assert shown_in(gzip.decompress(body)) == (MAX_OPEN_ORDERS, MAX_OPEN)


@pytest.mark.slow
async def test_no_step_is_long_that_asks_what_an_agent_knew(fullest: House) -> None:
    """One that has nothing to do with any task, so that all are looked through: before anything is recorded, and when all is."""
    path = "/api/agents/{agent}/knowledge"
    fullest.projection.fold(atv_heartbeat(NAMES["agent"]))
    took_ms = {"now": await longest_ms(fullest, "GET", path, b"")}
    assert fullest.recorder.now() is None
    while fullest.recorder.now() is None:
        fullest.recorder.note(Delta(number=0, at_s=NOW_S))
    moment = datetime.fromtimestamp(NOW_S, UTC).strftime("at=%Y-%m-%dT%H:%M:%SZ")
    for query in ("", moment):
        took_ms[f"recorded {query}"] = await longest_ms(fullest, "GET", path, b"", query)
    print(f"\nGET {path} | {took_ms}")  # noqa: T201 - for who runs pytest with -s
    assert {status for _, status in took_ms.values()} == {200}
    assert max(longest for longest, _ in took_ms.values()) <= STEP_MS


async def test_the_monitor_sees_a_long_step_and_whose_it_was(full_house: House) -> None:
    async def app(_scope: object, _receive: object, send: object) -> None:
        await asyncio.sleep(0)
        sum(range(12_000_000))
        await send({"type": "http.response.start", "status": 200})  # type: ignore[operator]

    # A gateway makes ready at the first request.
    await ask(full_house.app, Asked("GET", "/healthz"), "first")
    with loop_monitor() as monitor:
        await ask(app, Asked("GET", "/"), "long")  # type: ignore[arg-type]
        await ask(full_house.app, Asked("GET", "/healthz"), "short")
    took_ms = {}
    for whose in ("long", "short"):
        tries = Tries()
        tries.note(monitor.longest_s[whose], monitor.yardstick_s)
        took_ms[whose] = tries.least_ms
    assert took_ms["long"] > STEP_MS > took_ms["short"]


def test_of_several_tries_the_one_whose_yardstick_was_disturbed_is_not_favoured() -> None:
    tries = Tries()
    tries.note(0.030, YARDSTICK_S)
    tries.note(0.030, 3 * YARDSTICK_S)
    assert tries.least_ms == pytest.approx(30.0)
    tries.note(0.012, 2 * YARDSTICK_S)
    assert tries.least_ms == pytest.approx(12.0)


def test_a_slow_computer_gets_an_allowance_up_to_a_bound() -> None:
    for slower, told_ms in ((0.5, 40.0), (2.0, 20.0), (SLOWEST, 10.0), (3 * SLOWEST, 10.0)):
        tries = Tries()
        tries.note(0.040, slower * YARDSTICK_S)
        assert tries.least_ms == pytest.approx(told_ms)

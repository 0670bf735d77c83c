"""What is only asked for costs the event loop no long step either, however much the plant has to tell, its history has, and its calendars hold."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator, Iterator
from datetime import UTC, datetime, timedelta

import msgspec
import pytest
from databases import Files
from gateway_kit import BEARER, PRODUCT, House, gateway
from heartbeats import events
from loop_monitor import Asked, Tries, ask, loop_monitor
from msgspec.structs import replace
from wall_clock import NOW_S

from dray.gateway.access.principal import Scope
from dray.gateway.access.rules import RULES
from dray.gateway.factory.catalogue import PRODUCTS_MAX, Catalogue
from dray.gateway.http.provided import provided
from dray.gateway.live.projection.auctions.bids import MAX_BIDS
from dray.gateway.live.projection.auctions.tasks import MAX_OPEN, MAX_OPEN_EACH
from dray.gateway.orders.drafts import MAX_ITEMS
from dray.gateway.orders.placement import MAX_OPEN_ORDERS
from dray.gateway.orders.transports import OPEN_MAX
from dray.gateway.routes.history.tasks import EVENTS_MOST
from dray.gateway.routes.products.removal import REMOVED_AT_ONCE
from dray.gateway.schedules.drafts import HOLIDAYS_MAX
from dray.gateway.schedules.scheduler import SCHEDULES_MAX
from dray.messages import (
    BillLine,
    MachineCycle,
    Phase,
    ProductDefinition,
    Role,
    Transport,
    TransportCost,
)
from dray.messages.fact import AnyFact, BidReceived, PhaseEntered, TaskClosed, TaskOpened
from dray.plant import Plant
from dray.store.access.audit import AuditRow
from dray.store.orders.orders import Item, Order
from dray.store.orders.products import DefinedProduct
from dray.store.orders.progress import OrderStatus
from dray.store.orders.schedules import ScheduleRow
from dray.store.orders.transports import TransportRow

pytestmark = pytest.mark.anyio

STEP_MS = 20.0
"""Processor time that a step may take (`test_loop_steps`)."""

TRIES = 12
"""A busy computer takes processor time from what runs on it. One try that is short shows that the step can be."""

TASK = "M8.1-1"
"""One that has more events than are read of it."""

ELSEWHERE = ("/api/stream", "/api/replay", "/api/replay/film")
"""What is told of everything: looked at in `test_loop_steps`, with a recorder that has been told all."""

LIVE = [
    template
    for method, template in RULES
    if method == "GET" and "{" not in template and template.startswith("/api/") and template not in ELSEWHERE
]
"""Lists and figures, as they are without a word of what is wanted."""

HISTORY_ROWS = 1_000
"""Tasks that have ended, and lines of the audit log: as many as are read at once for a table."""

SAID_AT_ONCE = 100
"""Tasks whose facts are said before the historian writes them."""

COMMON = "+".join("x" * length for length in range(1, 9))
"""Words that stand in the names of nearly all products."""

ROOM = 2
"""How many more products may be defined."""

GZIP = {"Accept-Encoding": "gzip"}
"""As every browser sends it: compressing is work of the loop, too."""


def at_first_sight(house: House) -> None:
    """As if every task had changed since anybody looked: why it stands as it does is to be found anew."""
    tasks = house.projection.tasks
    tasks._unexplained.update(tasks.ids())


async def longest_ms(
    house: House,
    method: str,
    path: str,
    query: str,
    headers: dict[str, str],
    body: bytes = b"",
    tried: Tries | None = None,
) -> float:
    """The longest step of a request in milliseconds; with those that were `tried` before, one try more."""
    tries = tried or Tries()
    for _ in range(1 if tried else TRIES):
        asked = Asked(method, path, body, tuple((BEARER | GZIP | headers).items()), query)
        at_first_sight(house)
        with loop_monitor() as monitor:
            status, _ = await ask(house.app, asked, path)
        # What this caller may not see, a real plant has not, or there are too many of is refused.
        assert status in (200, 403, 404, 409, 503), status
        tries.note(monitor.longest_s[path], monitor.yardstick_s)
        # The least counts: another try would change nothing.
        if tries.least_ms <= STEP_MS:
            break
    return tries.least_ms


def work() -> Transport:
    return Transport("shaft", 40, ("S1",), "M8", "")


def tasks_of(coordinator: str, count: int, bids: int) -> Iterator[AnyFact]:
    """A coordinator opens so many tasks, and gets so many bids for each."""
    cost = TransportCost(1.0, 2.0, 3.0, 4.0)
    for task in (f"{coordinator}-{each}" for each in range(count)):
        yield TaskOpened(task, 1, Role.PRIMARY, 1, work(), 10.0, 1000.0, 200.0)
        bid = BidReceived(task, 1, Role.PRIMARY, 1, "ATV1", cost, 10.0, 100.0)
        yield from (replace(bid, bidder=f"ATV{each}") for each in range(bids))


def schedules() -> Iterator[ScheduleRow]:
    """As many as may be, by calendars that fall on days off as often as they may."""
    first = datetime.fromtimestamp(NOW_S, UTC).date() - timedelta(days=1)
    # Every other day, so that no two can be passed over at once.
    days = json.dumps([(first + timedelta(days=2 * each)).isoformat() for each in range(HOLIDAYS_MAX)])
    minutes = ",".join(map(str, range(30)))
    for number in range(SCHEDULES_MAX):
        yield ScheduleRow(
            id=f"S-{number:012d}",
            name=f"{number}",
            calendar=f"{minutes} 6 1-31/2 * *",
            time_zone="Europe/Berlin",
            holidays=days,
            make_up=False,
            paused=False,
            revision=1,
            transport='{"from":"S3","to":"M8","item":"shaft","quantity":40}',
            next_at_s=NOW_S,
            owner="admin admin",
            by="Manager",
            at_s=NOW_S,
        )


@pytest.fixture(scope="module")
async def fullest(files: Files, tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[House]:
    """A gateway with as many open orders, transports and tasks, as much recurring work and as many products as may be, and a long history."""
    async with gateway(files.new(tmp_path_factory.mktemp("fullest"))) as house:
        for begun in range(0, HISTORY_ROWS, SAID_AT_ONCE):
            ended = ended_tasks(range(begun, begun + SAID_AT_ONCE))
            await house.say(events("M9", *ended, first=2 * begun + 1))
        for coordinator in range(MAX_OPEN // MAX_OPEN_EACH):
            for event in events(f"M{coordinator}", *tasks_of(f"M{coordinator}", MAX_OPEN_EACH, MAX_BIDS)):
                house.projection.fold(event)
        told: list[AnyFact] = [TaskOpened(TASK, 1, Role.PRIMARY, 1, work(), 20.0, 300.0, 5.0)]
        told += [PhaseEntered(TASK, 1, Phase.APPROACHING, "S3")] * (EVENTS_MOST + 1)
        await house.say(events("M8", *told))
        for order in orders():
            house.projection.orders.put(order)
        async with house.store.write() as work_:
            for row in schedules():
                assert await work_.schedules.add(row)
            for product in products(house.projection.site.plant):
                assert await work_.products.define(product)
            await work_.orders.add_all(list(orders()))
            for transport in transports():
                assert await work_.transports.add(transport)
            for number in range(HISTORY_ROWS):
                await work_.audit.add(audit_line(number))
        async with house.store.read() as work_:
            await provided(house.app, Catalogue).look(work_)
        await is_full(house)
        yield house


async def is_full(house: House) -> None:
    """What is there at the first question."""
    projection = house.projection
    assert len(projection.site.products) > PRODUCTS_MAX - ROOM
    assert len(projection.orders.ids()) == MAX_OPEN_ORDERS
    assert len(list(projection.tasks.under_way())) == MAX_OPEN
    for path, least in (
        ("/api/tasks/history", HISTORY_ROWS),
        ("/api/transports", OPEN_MAX),
        ("/api/orders", MAX_OPEN_ORDERS),
    ):
        assert (await house.get(path, limit=1))["total"] >= least, path
    for path in ("/api/audit", "/api/events"):
        assert len((await house.get(path, limit=500))["items"]) == 500, path


def ended_tasks(numbers: range) -> Iterator[AnyFact]:
    """Tasks that were opened and have ended."""
    for task in (f"M9.1-{number}" for number in numbers):
        yield TaskOpened(task, 1, Role.PRIMARY, 1, work(), 20.0, 300.0, 5.0)
        yield TaskClosed(task, 1, "delivered", "ATV1", 100.0)


def orders() -> Iterator[Order]:
    """As many as may be open, each as large as one may be."""
    items = tuple(Item(PRODUCT, 5) for _ in range(MAX_ITEMS))
    for number in range(MAX_OPEN_ORDERS):
        yield Order(
            id=f"O-{number:032d}",
            status=OrderStatus.STORED,
            customer="x" * 200,
            token=f"{number}",
            items=items,
            created_at_s=NOW_S,
            reference=f"{number}",
            due_at_s=NOW_S + 1e6,
        )


def transports() -> Iterator[TransportRow]:
    """As many as may be open."""
    for number in range(OPEN_MAX):
        yield TransportRow(
            id=f"T-{number:032d}",
            source="S3",
            destination="M8",
            item="shaft",
            quantity=40,
            priority="normal",
            called_by="x" * 200,
            caller=f"key {number}",
            created_at_s=NOW_S,
            due_at_s=NOW_S + 1e3,
            updated_at_s=NOW_S,
        )


def audit_line(number: int) -> AuditRow:
    return AuditRow(
        at_s=NOW_S,
        who="x" * 64,
        who_kind="key",
        action="transport.call",
        target=f"T-{number}",
        result="done",
        detail={"customer": "x" * 200},
    )


def products(plant: Plant) -> Iterator[DefinedProduct]:
    """Nearly as many as may be, each of which every machine makes."""
    known = plant.products[PRODUCT]
    definition = ProductDefinition(
        lot=known.lot,
        ability=known.ability,
        bill=tuple(BillLine(line.material, line.quantity) for line in known.bill),
        name="x" * 80,
        revision=1,
        machines=tuple(MachineCycle(machine, 12.5) for machine in plant.machines),
    )
    written = msgspec.json.encode(definition).decode()
    for number in range(PRODUCTS_MAX - ROOM):
        yield DefinedProduct(f"X{number:031d}", definition.name, 1, written, f"{number}", NOW_S)


@pytest.mark.slow
@pytest.mark.parametrize("template", LIVE)
@pytest.mark.parametrize("scopes", [(), (Scope.FACTORY_READ,)], ids=["all of it", "without orders"])
async def test_no_step_is_long_however_much_there_is_to_tell(
    fullest: House, template: str, scopes: tuple[Scope, ...]
) -> None:
    headers = (await fullest.key(*scopes))[1] if scopes else {}
    found = {}
    for query in ("", "limit=500", "format=csv", f"q={COMMON}"):
        if query and query.partition("=")[0] not in parameters(fullest, template):
            continue
        found[query] = await longest_ms(fullest, "GET", template, query, headers)
    print(f"\nGET {template} | {found}")  # noqa: T201 - for who runs pytest with -s
    assert max(found.values()) <= STEP_MS


def parameters(house: House, template: str) -> set[str]:
    operation = house.app.openapi()["paths"].get(template, {}).get("get", {})
    return {each["name"] for each in operation.get("parameters", ())}


@pytest.mark.slow
async def test_no_step_of_defining_a_product_is_long_however_many_there_are(fullest: House) -> None:
    plant = fullest.projection.site.plant
    known = plant.products[PRODUCT]
    fields = {
        "name": "Bracket",
        "lot": known.lot,
        "bill": {line.material: line.quantity for line in known.bill},
        "machines": dict.fromkeys(plant.machines, 12.5),
    }
    path, headers = f"/api/products/X{0:031d}", {"Content-Type": "application/json"}
    tries = Tries()
    for revision in range(1, TRIES + 1):
        body = json.dumps(fields | {"name": f"Bracket {revision}"}).encode()
        match = {"If-Match": f'"{revision}"'}
        took_ms = await longest_ms(fullest, "PUT", path, "", headers | match, body, tries)
        assert (await fullest.get(path))["revision"] == revision + 1
        if took_ms <= STEP_MS:
            break
    print(f"\nPUT {path} | {took_ms}")  # noqa: T201 - for who runs pytest with -s
    assert took_ms <= STEP_MS


@pytest.mark.slow
@pytest.mark.parametrize("path", [f"/api/tasks/{TASK}/timeline", "/api/tasks/unknown", "/api/tasks/M1-999"])
async def test_no_step_is_long_of_one_task(fullest: House, path: str) -> None:
    took_ms = await longest_ms(fullest, "GET", path, "", {})
    print(f"\nGET {path} | {took_ms}")  # noqa: T201 - for who runs pytest with -s
    assert took_ms <= STEP_MS


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, REMOVED_AT_ONCE])
async def test_no_step_of_removing_products_is_long_however_many_there_are(
    fullest: House, count: int
) -> None:
    """The last test here: afterwards there are fewer."""
    path, headers = "/api/products/remove", {"Content-Type": "application/json"}
    tries = Tries()
    # Four times 500 are all that there are.
    for _ in range(3):
        there = [id_ for id_ in sorted(fullest.projection.site.products) if id_.startswith("X")][:count]
        body = json.dumps({"products": there}).encode()
        took_ms = await longest_ms(fullest, "POST", path, "", headers, body, tries)
        assert not set(there) & fullest.projection.site.products
        if took_ms <= STEP_MS:
            break
    print(f"\nPOST {path} | {count} | {took_ms}")  # noqa: T201 - for who runs pytest with -s
    assert took_ms <= STEP_MS

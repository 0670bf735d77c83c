"""The OpenAPI document tells the truth: whatever is asked, the answer is one that it tells of."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from copy import deepcopy
from dataclasses import dataclass
from typing import Any, cast

import httpx
import jsonschema_rs
import pytest
import requests
import schemathesis
from anyio.from_thread import BlockingPortal, start_blocking_portal
from databases import Files
from fake_bus import PLANT, FakeBus
from fake_injector import FakeInjector
from gateway_kit import AUTHORITY, BEARER, PRODUCT, House, gateway
from heartbeats import atv_heartbeat, events, machine_heartbeat
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from hypothesis.errors import Unsatisfiable
from schemathesis import GenerationMode
from schemathesis.specs.openapi.checks import ignored_auth, negative_data_rejection, positive_data_acceptance
from variants import in_campaigns

from dray.gateway.app import create_app
from dray.gateway.live.timescale import TimeScale
from dray.messages import (
    CommandAnswered,
    MachineCommand,
    MachineStatus,
    Message,
    Role,
    Transport,
    VehicleCommand,
)
from dray.messages.fact import TaskOpened
from dray.settings import Settings
from dray.store import Store

NO_STORE = cast(Store, None)
"""A document is written before anything is opened."""

APP = create_app(
    settings=Settings(),
    plant=PLANT,
    bus=FakeBus(),
    store=NO_STORE,
    time=TimeScale(0.0, 0.0),
    authority=AUTHORITY,
)

DOCUMENT: dict[str, Any] = json.loads(json.dumps(APP.openapi()))


def _unguarded() -> dict[str, Any]:
    """A copy of the document, since schemathesis writes into what it reads, in which nobody has to log in.

    The administrator asks, whatever credentials schemathesis would think of; so it had better think of fields.
    """
    document = deepcopy(DOCUMENT)
    for guarded in (document, *(methods[name] for methods in document["paths"].values() for name in methods)):
        guarded.pop("security", None)
    return document


SCHEMA = schemathesis.openapi.from_dict(_unguarded())

OPERATIONS = [(method, path) for path, methods in DOCUMENT["paths"].items() for method in methods]

FEW, MANY = 2, 12
"""Requests per operation: some good ones, and enough, good and bad, for every field to be wrong once."""

CREDENTIALS = {"Authorization", "authorization", "Cookie", "cookie"}

one_way = settings(
    deadline=None,
    derandomize=True,
    database=None,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=list(HealthCheck),
)


@dataclass
class Running:
    """A gateway on a loop that is not the test's."""

    portal: BlockingPortal
    house: House
    known: dict[str, str]
    """Per path parameter, an id that there is."""

    def answer(self, request: requests.PreparedRequest) -> httpx.Response:
        async def ask() -> httpx.Response:
            return await self.house.client.request(
                request.method or "",
                request.url or "",
                content=cast(bytes | str | None, request.body),
                # The administrator asks: who may do what is another test's matter.
                headers=[
                    *((name, value) for name, value in request.headers.items() if name not in CREDENTIALS),
                    *BEARER.items(),
                ],
            )

        return self.portal.call(ask)


@contextmanager
def _running(*urls: str) -> Iterator[list[Running]]:
    """A gateway on each of these databases, with something of everything in it."""
    with start_blocking_portal("asyncio") as portal, ExitStack() as stack:
        houses = [
            stack.enter_context(portal.wrap_async_context_manager(gateway(url, faults=FakeInjector())))
            for url in urls
        ]
        yield [Running(portal, house, portal.call(_fill, house)) for house in houses]


@pytest.fixture(scope="module")
def shared(files: Files, tmp_path_factory: pytest.TempPathFactory) -> Iterator[list[Running]]:
    """One gateway of which every operation is asked in turn."""
    with _running(files.new(tmp_path_factory.mktemp("shared"))) as running:
        yield running


@pytest.fixture
def running(request: pytest.FixtureRequest) -> Iterator[list[Running]]:
    """The shared gateway; where much is asked, one of its own on each kind of database."""
    if request.node.callspec.params["examples"] == FEW:
        yield request.getfixturevalue("shared")
        return
    urls = [request.getfixturevalue("sqlite_url")]
    # Without PostgreSQL other tests are skipped, and tell so.
    with suppress(pytest.skip.Exception):
        urls.append(request.getfixturevalue("postgresql_url"))
    with _running(*urls) as running:
        yield running


async def _fill(house: House) -> dict[str, str]:
    for agent in ("ATV1", "M1"):

        def obey(sender: str, message: Message, agent: str = agent) -> None:
            if isinstance(message, VehicleCommand | MachineCommand):
                house.bus.tell(agent, sender, CommandAnswered(message.command, done=True))

        house.bus.join(agent, obey)
    work = Transport(item="steel", quantity=4, sources=("S1",), destination="M1", ability="tote")
    opened = TaskOpened("M1-1", 1, Role.PRIMARY, 1, work, 20.0, 900.0, 105.0)
    await house.say(
        [atv_heartbeat("ATV1"), machine_heartbeat("M1", status=MachineStatus.ERROR), *events("M1", opened)]
    )
    order = await house.place()
    await house.client.post("/api/faults", json={"kind": "powered_off", "agent": "ATV3"})
    token = order["tracking_url"].rpartition("/")[2]
    await house.alerts.look()
    draft = (await house.client.post("/api/plant-drafts", json={"name": "Hall 2"})).json()["id"]
    called = {"from": "S3", "to": "M8", "item": "shaft", "quantity": 4}
    transport = (await house.client.post("/api/transports", json=called)).json()["id"]
    recurring = {"name": "Daily", "calendar": "0 6 * * *", "time_zone": "UTC", "transport": called}
    schedule = (await house.client.post("/api/schedules", json=recurring)).json()["id"]
    ana = {"id": "ana", "name": "Ana, North", "role": "operator", "areas": ["AREA1"]}
    person = (await house.client.post("/api/people", json=ana)).json()["id"]
    made = await house.client.post("/api/keys", json={"name": "ERP", "scopes": ["orders:read"]})
    return {
        "alert": "machine_error-M1",
        "person": person,
        "key": made.json()["key"]["id"],
        "order": order["id"],
        "token": token,
        "area": "AREA1",
        "atv": "ATV1",
        "agent": "ATV2",
        "machine": "M1",
        "task": "M1-1",
        "fault": "f1",
        "closure": "c1f0a93be",
        "call": "ATV1-1-1",
        "draft": draft,
        "transport": transport,
        "schedule": schedule,
        "product": PRODUCT,
    }


MUCH = [(*operation, MANY) for operation in OPERATIONS]


@pytest.mark.parametrize(
    ("method", "path", "examples"),
    [*((*operation, FEW) for operation in OPERATIONS), *in_campaigns(MUCH, *MUCH[::10])],
)
def test_every_answer_is_one_that_the_document_tells_of_whatever_the_database(
    running: list[Running], method: str, path: str, examples: int
) -> None:
    # What is refused changes nothing, so it comes first. It is searched for long where any text may stand.
    if examples == MANY:
        with suppress(Unsatisfiable):
            _ask(running, method, path, GenerationMode.NEGATIVE, examples)
    _ask(running, method, path, GenerationMode.POSITIVE, examples)


def _takes_any_word(parameter: dict[str, Any]) -> bool:
    """Whether a parameter of an address may be repeated, and each time be a word that JSON writes for a truth value."""
    shapes = parameter["schema"].get("anyOf", [parameter["schema"]])
    items = [shape["items"] for shape in shapes if shape.get("type") == "array"]
    return parameter["in"] == "query" and any(
        each.get("type") == "string" and "enum" not in each and re.search(each.get("pattern", ""), "false")
        for each in items
    )


def _ask(running: list[Running], method: str, path: str, mode: GenerationMode, examples: int) -> None:
    cases = SCHEMA[path][method.upper()].as_strategy(generation_mode=mode)
    # What has the right shape may still name a product that nobody makes, or another list's cursor.
    excluded = [positive_data_acceptance, ignored_auth]
    if any(map(_takes_any_word, DOCUMENT["paths"][path][method].get("parameters", ()))):
        # A number or a truth value in an address is text like any other, and names an agent that nobody knows.
        excluded.append(negative_data_rejection)

    @settings(one_way, max_examples=examples)
    @given(case=cases, known=st.booleans())
    def ask(case: schemathesis.Case, known: bool) -> None:
        by_name = known and mode is GenerationMode.POSITIVE
        if by_name and (method, path) == ("post", "/api/orders"):
            case.body = case.body | {
                "items": [item | {"product": PRODUCT} for item in case.body["items"]],
                "due_at": None,
            }
        statuses = set()
        for each in running:
            if by_name:
                case.path_parameters = {name: each.known[name] for name in case.path_parameters or {}}
            request = requests.Request(**case.as_transport_kwargs("http://dray.test")).prepare()
            answer = each.answer(request)
            case.validate_response(answer, excluded_checks=excluded)
            statuses.add(answer.status_code)
        assert len(statuses) == 1, "each kind of database leads to another answer"

    ask()


def test_every_operation_has_a_summary_and_an_example() -> None:
    without = []
    for method, path in OPERATIONS:
        operation = DOCUMENT["paths"][path][method]
        assert operation["summary"]
        assert operation["description"]
        good = next(answer for status, answer in operation["responses"].items() if status.startswith("2"))
        if "example" not in good.get("content", {}).get("application/json", {"example": None}):
            without.append(f"{method} {path}")
        if "requestBody" in operation:
            body = operation["requestBody"]["content"]["application/json"]
            shape = DOCUMENT["components"]["schemas"].get(
                body["schema"].get("$ref", "").rpartition("/")[2], {}
            )
            if "examples" not in body and "examples" not in shape:
                without.append(f"{method} {path} body")
    assert without == []


def test_every_example_has_the_shape_that_it_is_an_example_of() -> None:
    for method, path in OPERATIONS:
        for answer in DOCUMENT["paths"][path][method]["responses"].values():
            content = answer.get("content", {}).get("application/json", {})
            if "example" in content:
                schema = content["schema"] | {"components": DOCUMENT["components"]}
                jsonschema_rs.validator_for(schema).validate(content["example"])


def test_every_shape_that_is_named_is_there() -> None:
    def named(part: Any) -> Iterator[str]:
        if isinstance(part, dict):
            if isinstance(part.get("$ref"), str):
                yield part["$ref"]
            for inner in part.values():
                yield from named(inner)
        elif isinstance(part, list):
            for inner in part:
                yield from named(inner)

    shapes = {f"#/components/schemas/{name}" for name in DOCUMENT["components"]["schemas"]}
    assert set(named(DOCUMENT)) <= shapes


@pytest.mark.anyio
async def test_the_document_is_served_as_it_is_written(house: House) -> None:
    assert await house.get("/api/openapi.json") == DOCUMENT

"""The stop path: an endpoint, a sender and a recorder, on a bus and without threads (those are in `tests/cli`)."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from typing import Any

import pytest
from answers import problem
from gateway_kit import ADMIN_TOKEN, AUTHORITY, House, gateway
from heartbeats import atv_heartbeat
from stop_way import STOP, Way, way
from wall_clock import NOW_S

from dray.adapters.security.signing import TrustedKeys
from dray.errors import UnavailableError
from dray.gateway.access.gate import COOKIE
from dray.gateway.access.principal import ADMIN, Role, Scope
from dray.gateway.factory import awaited
from dray.gateway.factory.commands import STOP_VALID_S
from dray.gateway.http.problems import Problem
from dray.gateway.stop.endpoint import BODY_BYTES
from dray.messages import CommandAnswered, CommandKind, VehicleCommand, signed_words
from dray.store import Database, Store

pytestmark = pytest.mark.anyio

PANEL = "http://dray.test:8000"


@pytest.fixture
async def stops(house: House) -> AsyncIterator[Way]:
    async with way(house) as stops:
        yield stops


def forget_the_database(monkeypatch: pytest.MonkeyPatch) -> None:
    """From now on the database is away."""

    def away(*_all: Any) -> None:
        raise UnavailableError("database", "connection refused", "start it")

    monkeypatch.setattr(Store, "read", away)
    monkeypatch.setattr(Store, "write", away)
    monkeypatch.setattr(Database, "do", away)


async def test_a_stop_is_answered_with_the_vehicles_word_and_carries_its_grant(stops: Way) -> None:
    heard = stops.vehicle()
    answer = await stops.ask(body=STOP | {"command": "c-1"})
    assert answer.status_code == 200
    assert answer.json() == {"command": "c-1", "done": True, "reason": None, "detail": "", "text": ""}
    (command,) = heard
    assert command.kind is CommandKind.STOP
    grant = command.grant
    assert grant is not None
    assert (grant.person, grant.everywhere, grant.valid_until_s) == ("admin:admin", True, STOP_VALID_S)
    assert TrustedKeys(AUTHORITY.public)(signed_words("ATV1", command, grant), grant.signature)


async def test_a_vehicle_whose_clock_is_an_hour_ahead_is_told_until_when_by_that_clock(stops: Way) -> None:
    stops.house.bus.say(atv_heartbeat("ATV1", at_s=3600.0))
    heard = stops.vehicle()
    assert (await stops.ask()).status_code == 200
    assert [command.grant.valid_until_s for command in heard if command.grant] == [3600.0 + STOP_VALID_S]


async def test_a_stop_passes_wherever_the_gateway_thinks_the_vehicle_is_and_the_vehicle_decides(
    stops: Way,
) -> None:
    stops.vehicle(reason="not_here")
    answer = (await stops.ask()).json()
    assert answer["done"] is False
    assert answer["reason"] == "not_here"


@pytest.mark.parametrize("kind", ["resume", "acknowledge", "set_speed", "promise", "nothing"])
async def test_nothing_but_a_stop_passes(stops: Way, kind: str) -> None:
    heard = stops.vehicle()
    problem(await stops.ask(body={"kind": kind}), 422, "unusable-fields")
    assert heard == []


async def test_panels_see_a_stop_that_went_its_own_way_and_the_audit_log_has_one_line(stops: Way) -> None:
    stops.house.bus.say(atv_heartbeat("ATV1"))
    stops.vehicle()
    assert (await stops.ask(body=STOP | {"command": "c-1"})).status_code == 200
    assert stops.states() == ["confirmed"]
    # The panel has sent it both ways.
    other = await stops.house.client.post("/api/atvs/ATV1/commands", json=STOP | {"command": "c-1"})
    assert other.json()["done"] is True
    (line,) = await stops.house.audit(action="vehicle.command")
    assert (line.who, line.target, line.result) == ("admin", "ATV1", "done")


async def test_a_stop_that_was_heard_at_the_gateway_first_has_one_line_too(stops: Way) -> None:
    stops.house.bus.say(atv_heartbeat("ATV1"))
    heard = stops.vehicle()
    body = STOP | {"command": "c-1"}
    assert (await stops.house.client.post("/api/atvs/ATV1/commands", json=body)).status_code == 200
    assert (await stops.ask(body=body)).status_code == 200
    assert len(heard) == 2, "each way says it; a vehicle answers what comes again as before"
    assert len(await stops.house.audit(action="vehicle.command")) == 1


async def test_a_stop_that_is_sent_again_is_said_once_and_a_name_stands_for_one_stop(stops: Way) -> None:
    heard = stops.vehicle()
    stops.vehicle("ATV2")
    body = STOP | {"command": "c-1"}
    assert (await stops.ask(body=body)).json() == (await stops.ask(body=body)).json()
    assert len(heard) == 1
    problem(await stops.ask("ATV2", body=body), 409, "command-name-used")


async def test_a_stop_that_is_not_confirmed_is_said_so_and_a_late_word_still_counts(house: House) -> None:
    async with way(house, timeout_s=0.01) as stops:
        told = problem(await stops.ask(body=STOP | {"command": "c-1"}), 504, "not-confirmed")
        assert "look at it" in told["detail"]
        assert stops.states() == ["not_confirmed"]
        house.bus.tell("ATV1", "gateway-stop", CommandAnswered(command="c-1", done=True))
        assert stops.states() == ["confirmed"]


async def test_an_answer_of_another_vehicle_confirms_nothing(stops: Way) -> None:
    asked = asyncio.create_task(stops.ask(body=STOP | {"command": "c-1"}))
    await stops.house.bus.next_to("ATV1", VehicleCommand)
    stops.house.bus.tell("ATV2", "gateway-stop", CommandAnswered(command="c-1", done=True))
    assert stops.states() == ["sent"]
    stops.house.bus.tell("ATV1", "gateway-stop", CommandAnswered(command="c-1", done=True))
    assert (await asked).json()["done"] is True


async def test_a_session_that_was_never_shown_here_may_stop_while_the_database_is_away(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    browser = await house.log_in("olga", Role.OPERATOR, "AREA1")
    _, key = await house.key(Scope.VEHICLES_STOP)
    house.access.sessions._remembered.clear()
    await house.access.learn()
    async with way(house) as stops:
        heard = stops.vehicle()
        forget_the_database(monkeypatch)
        stops.client.headers.clear()
        answer = await stops.ask(cookie=f"{COOKIE}={browser.cookies[COOKIE]}")
        assert answer.status_code == 200
        assert heard[0].grant is not None
        assert heard[0].grant.areas == ("AREA1",)
        assert (await stops.ask(**key)).status_code == 200
        assert house.access.audit_log.waiting == 2
        monkeypatch.undo()
        assert len(await house.audit(action="vehicle.command")) == 2


async def test_who_has_logged_out_or_was_disabled_or_lost_a_key_stops_nothing(house: House) -> None:
    here, elsewhere = await house.log_in("olga"), await house.log_in("olaf")
    key, shown = await house.key(Scope.VEHICLES_STOP)
    cookies = [f"{COOKIE}={each.cookies[COOKIE]}" for each in (here, elsewhere)]
    await house.access.learn()
    async with way(house) as stops:
        heard = stops.vehicle()
        stops.client.headers.clear()
        # Here it is known at once, and from elsewhere with the next look into the database.
        await here.post("/logout")
        problem(await stops.ask(cookie=cookies[0]), 401, "not-logged-in")
        async with house.store.write() as work:
            await work.people.change("olaf", disabled_at_s=NOW_S)
            await work.api_keys.revoke(key.id, NOW_S)
        await house.access.learn()
        problem(await stops.ask(cookie=cookies[1]), 401, "not-logged-in")
        problem(await stops.ask(**shown), 401, "not-logged-in")
        assert heard == []


async def test_a_session_that_has_run_out_of_time_may_stop(house: House) -> None:
    browser = await house.log_in("olga", Role.OPERATOR, "AREA1")
    house.wall.now_s += 11 * 3600.0
    async with way(house) as stops:
        stops.vehicle()
        stops.client.headers.clear()
        assert (await stops.ask(cookie=f"{COOKIE}={browser.cookies[COOKIE]}")).status_code == 200


async def test_a_key_without_the_scope_stops_nothing_and_a_stranger_tries_so_often_only(house: House) -> None:
    _, key = await house.key(Scope.FACTORY_READ, Scope.ORDERS_WRITE)
    await house.access.learn()
    async with way(house) as stops:
        heard = stops.vehicle()
        problem(await stops.ask(**key), 401, "not-logged-in")
        statuses = [(await stops.ask(Authorization="Bearer dray_guess")).status_code for _ in range(60)]
        assert statuses[0] == 401
        assert statuses[-1] == 429
        # Strangers use up their own tries only.
        assert (await stops.ask(Authorization=f"Bearer {ADMIN_TOKEN}")).status_code == 200
        assert len(heard) == 1


async def test_a_panel_may_ask_from_the_gateways_own_address_and_no_other_page(stops: Way) -> None:
    stops.vehicle()
    for origin in (PANEL, "https://dray.example.com", "http://dray.test:8001"):
        asked = await stops.client.options("/api/atvs/ATV1/commands", headers={"Origin": origin})
        assert asked.status_code == 204
        assert asked.headers["access-control-allow-origin"] == origin
        assert asked.headers["access-control-allow-credentials"] == "true"
        answer = await stops.ask(Origin=origin)
        assert answer.status_code == 200
        assert answer.headers["access-control-allow-origin"] == origin
    for origin in ("http://dray.test", "http://dray.test:9999", "http://evil.test:8000", "null", "http://["):
        told = await stops.ask(Origin=origin)
        problem(told, 403, "not-allowed")
        assert "access-control-allow-origin" not in told.headers


async def test_what_is_asked_by_a_strange_name_or_is_no_stop_is_refused(stops: Way) -> None:
    heard = stops.vehicle()
    problem(await stops.ask(Host="evil.test"), 421, "unknown-host")
    problem(await stops.client.get("/api/orders"), 404, "not-found")
    problem(await stops.client.get("/api/atvs/ATV1/commands"), 405, "method-not-allowed")
    problem(await stops.ask("A B"), 422, "unusable-fields")
    many = {"Content-Type": "application/json"}
    path = "/api/atvs/ATV1/commands"
    problem(
        await stops.client.post(path, content=b" " * (BODY_BYTES + 1), headers=many), 413, "body-too-large"
    )
    problem(await stops.client.post(path, content=b"{", headers=many), 400, "not-json")
    problem(await stops.client.post(path, content=b"[" * 1000, headers=many), 422, "unusable-fields")
    problem(await stops.client.post(path, content=b"kind=stop"), 415, "not-called-json")
    assert (await stops.client.get("/healthz")).status_code == 204
    assert heard == []


async def test_one_caller_cannot_fill_the_desk(house: House, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(awaited, "PENDING_EACH", 3)
    _, key = await house.key(Scope.VEHICLES_STOP)
    await house.access.learn()
    async with way(house) as stops:
        waiting = [asyncio.create_task(stops.sender.stop("ATV9", ADMIN, "")) for _ in range(3)]
        for number in range(3):
            await house.bus.next_to("ATV9", VehicleCommand, after=number)
        with pytest.raises(Problem, match="Too many commands"):
            await stops.sender.stop("ATV9", ADMIN, "")
        stops.vehicle("ATV1")
        assert (await stops.ask(**key)).status_code == 200
        for each in waiting:
            each.cancel()


async def test_the_pages_say_where_stops_pass_and_let_browsers_ask_there(url: str) -> None:
    async with gateway(url, stop_port=8001) as house:
        page = await house.client.get("/operator")
        if page.status_code == 200:  # Where the panels are built.
            assert '<meta name="dray-stop" content="http://dray.test:8001">' in page.text
            assert "connect-src 'self' http://dray.test:8001" in page.headers["content-security-policy"]

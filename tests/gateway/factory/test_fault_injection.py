"""Faults by hand over REST: begun, shown, ended, and refused with a reason."""

from __future__ import annotations

from collections.abc import AsyncIterator
from typing import Any

import httpx
import pytest
from answers import problem
from fake_injector import FakeInjector
from gateway_kit import House, gateway
from wall_clock import NOW_S

from dray.gateway.routes.factory import faults as route

pytestmark = pytest.mark.anyio

NEVER_HZ = 1e-6
"""The hub takes no changes that the test wants to see."""

OFF = {"kind": "powered_off", "agent": "ATV3"}


@pytest.fixture
def injector() -> FakeInjector:
    return FakeInjector()


@pytest.fixture
async def simulated(url: str, injector: FakeInjector) -> AsyncIterator[House]:
    async with gateway(url, faults=injector, stream_rate_hz=NEVER_HZ) as house:
        yield house


async def begin(house: House, body: Any = OFF) -> httpx.Response:
    return await house.client.post("/api/faults", json=body)


async def test_a_fault_is_begun_listed_and_ended(simulated: House, injector: FakeInjector) -> None:
    begun = await begin(simulated)
    assert begun.status_code == 201
    view = begun.json()
    assert view == {"id": "f1", "kind": "powered_off", "fault": OFF, "agents": ["ATV3"], "began_at_s": NOW_S}
    assert begun.headers["location"] == "/api/faults/f1"
    listed = await simulated.get("/api/faults")
    assert listed["items"] == [view]
    assert listed["kinds"] == [
        {"kind": "powered_off", "what": "Switched off.", "fields": ["agent"], "optional": []}
    ]
    ended = await simulated.client.delete("/api/faults/f1")
    assert (ended.status_code, ended.json()) == (200, view)
    assert (injector.begun, injector.ended) == ([OFF], ["f1"])
    assert (await simulated.get("/api/faults"))["items"] == []


async def test_panels_see_what_is_at_work(simulated: House) -> None:
    projection = simulated.projection
    await begin(simulated)
    assert [fault.id for fault in projection.delta(1, NOW_S, None).faults] == ["f1"]
    snapshot = projection.snapshot(1, NOW_S)
    assert (snapshot.fault_injection, [fault.id for fault in snapshot.faults]) == (True, ["f1"])
    await simulated.client.delete("/api/faults/f1")
    assert projection.delta(2, NOW_S, None).gone == ("fault:f1",)


async def test_a_fault_that_makes_no_sense_is_refused_at_its_field(simulated: House) -> None:
    told = problem(await begin(simulated, {**OFF, "agent": "ATV99"}), 422, "unusable-fields")
    assert told["errors"] == [{"field": "agent", "reason": "there is no such agent"}]
    assert (await simulated.get("/api/faults"))["items"] == []


@pytest.mark.parametrize("body", [{}, {"kind": ""}, {"kind": 7}, {"kind": None}, {"kind": "x" * 65}])
async def test_a_fault_without_a_kind_is_refused(simulated: House, body: Any) -> None:
    told = problem(await begin(simulated, body), 422, "unusable-fields")
    assert [error["field"] for error in told["errors"]] == ["kind"]


@pytest.mark.parametrize("body", [[], "powered_off", 7])
async def test_what_is_no_object_is_refused(simulated: House, body: Any) -> None:
    problem(await begin(simulated, body), 422, "unusable-fields")


async def test_a_fault_that_is_not_at_work_cannot_be_ended(simulated: House, injector: FakeInjector) -> None:
    told = problem(await simulated.client.delete("/api/faults/f9"), 404, "unknown-fault")
    assert "/api/faults" in told["detail"]
    assert injector.ended == []


async def test_a_factory_that_does_not_answer_is_said_and_the_fault_stays(
    simulated: House, injector: FakeInjector
) -> None:
    await begin(simulated)
    injector.away = True
    problem(await begin(simulated), 503, "no-answer")
    problem(await simulated.client.delete("/api/faults/f1"), 503, "no-answer")
    assert [fault["id"] for fault in (await simulated.get("/api/faults"))["items"]] == ["f1"]


async def test_faults_at_work_are_bounded(simulated: House, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(route, "MAX_FAULTS", 1)
    assert (await begin(simulated)).status_code == 201
    problem(await begin(simulated), 409, "too-many-faults")


async def test_another_sites_page_can_let_nothing_go_wrong(simulated: House, injector: FakeInjector) -> None:
    headers = {"Origin": "https://elsewhere.example"}
    refused = await simulated.client.post("/api/faults", json=OFF, headers=headers)
    problem(refused, 403, "other-origin")
    problem(await simulated.client.delete("/api/faults/f1", headers=headers), 403, "other-origin")
    assert injector.begun == []


@pytest.mark.parametrize("method", ["GET", "POST"])
async def test_a_factory_that_is_not_simulated_has_no_faults(house: House, method: str) -> None:
    answer = await house.client.request(method, "/api/faults", json=OFF)
    told = problem(answer, 409, "not-simulated")
    assert "dray up" in told["detail"]
    problem(await house.client.delete("/api/faults/f1"), 409, "not-simulated")
    assert house.projection.snapshot(1, NOW_S).fault_injection is False

"""A scenario over REST: how far it is, and on to its next step."""

from __future__ import annotations

from collections.abc import AsyncIterator

import pytest
from answers import problem
from fake_player import FakePlayer
from gateway_kit import House, gateway
from wall_clock import NOW_S

from dray.gateway.access.principal import Role, Scope

pytestmark = pytest.mark.anyio

SKIP = "/api/scenario/skip"

NEVER_HZ = 1e-6
"""The hub takes no changes that the test wants to see."""


@pytest.fixture
def player() -> FakePlayer:
    return FakePlayer()


@pytest.fixture
async def played(url: str, player: FakePlayer) -> AsyncIterator[House]:
    async with gateway(url, scenario=player, stream_rate_hz=NEVER_HZ) as house:
        yield house


async def test_a_scenario_tells_what_has_happened_and_when_the_rest_is_expected(played: House) -> None:
    view = await played.get("/api/scenario")
    assert (view["id"], view["state"], view["began_at_s"], view["skipping"]) == (
        "case-0",
        "playing",
        NOW_S,
        False,
    )
    assert [(step["step"], step["after_s"], step["expected_s"]) for step in view["steps"]] == [
        ("ordered", 0.0, 0.0),
        ("contracted", None, 600.0),
    ]


async def test_a_skip_is_begun_shown_to_all_and_ended(played: House) -> None:
    begun = await played.client.post(SKIP)
    assert (begun.status_code, begun.json()["skipping"]) == (200, True)
    assert (await played.get("/api/scenario"))["skipping"]
    assert [view.skipping for view in played.projection.scenarios.take_changed()] == [True]
    ended = await played.client.delete(SKIP)
    assert (ended.status_code, ended.json()["skipping"]) == (200, False)
    assert not (await played.get("/api/scenario"))["skipping"]
    assert [line.action for line in await played.audit()] == ["scenario.skip_end", "scenario.skip"]


async def test_nothing_is_skipped_when_the_scenario_has_ended(played: House, player: FakePlayer) -> None:
    player.put(state="held", after_s=601.0)
    for ask in (played.client.post, played.client.delete):
        assert problem(await ask(SKIP), 409, "scenario-over")
    assert (await played.get("/api/scenario"))["state"] == "held"


async def test_a_factory_without_a_scenario_says_how_to_play_one(house: House) -> None:
    for answer in (
        await house.client.get("/api/scenario"),
        await house.client.post(SKIP),
        await house.client.delete(SKIP),
    ):
        told = problem(answer, 409, "no-scenario")
        assert "dray up --scenario" in told["detail"]


async def test_a_factory_that_does_not_answer_is_503(played: House, player: FakePlayer) -> None:
    player.away = True
    assert problem(await played.client.post(SKIP), 503, "no-answer")
    assert not (await played.get("/api/scenario"))["skipping"]


async def test_only_who_may_let_things_go_wrong_skips(played: House) -> None:
    _, reader = await played.key(Scope.FACTORY_READ)
    assert (await played.visitor(**reader).post(SKIP)).status_code == 403
    assert (await played.visitor(**reader).get("/api/scenario")).status_code == 200
    _, injector = await played.key(Scope.FAULTS_WRITE)
    assert (await played.visitor(**injector).post(SKIP)).status_code == 200
    operator = await played.log_in("otto", Role.OPERATOR, "area1")
    assert (await operator.get("/api/scenario")).status_code == 403

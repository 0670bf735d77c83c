"""The login: whoever guesses does not come in, and learns nothing."""

from __future__ import annotations

import asyncio

import httpx
import pytest
from answers import problem
from gateway_kit import PASSWORD, House, gateway
from login_kit import try_in

from dray.gateway.access.limits import BUCKETS, Limit, neighbourhood
from dray.gateway.access.login.login import (
    FIRST_LOCKOUT_S,
    FORGIVEN_S,
    FREE_FAILURES,
    LONGEST_LOCKOUT_S,
    TRIES,
    lockout_s,
)
from dray.gateway.http.problems import Problem

pytestmark = pytest.mark.anyio


@pytest.mark.parametrize("name", ["boss", "nobody"])
async def test_a_name_is_locked_out_after_five_failures_whether_anybody_has_it_or_not(
    house: House, visitor: httpx.AsyncClient, name: str
) -> None:
    await house.know("boss")
    for _ in range(FREE_FAILURES):
        problem(await try_in(visitor, name, "wrong"), 401, "wrong-login")
    answer = await try_in(visitor, name, PASSWORD)
    problem(answer, 429, "too-many-tries")
    assert answer.headers["retry-after"] == str(int(FIRST_LOCKOUT_S))


async def test_who_was_locked_out_comes_in_later_and_has_all_tries_again(
    house: House, visitor: httpx.AsyncClient
) -> None:
    await house.know("boss")
    for _ in range(FREE_FAILURES):
        await try_in(visitor, "boss", "wrong")
    house.wall.now_s += FIRST_LOCKOUT_S
    assert (await try_in(visitor, "boss", PASSWORD)).status_code == 303
    for _ in range(FREE_FAILURES):
        problem(await try_in(visitor, "boss", "wrong"), 401, "wrong-login")


async def test_a_lockout_grows_and_outlives_the_process(url: str) -> None:
    async with gateway(url) as house, house.visitor() as visitor:
        await house.know("boss")
        for _ in range(FREE_FAILURES):
            await try_in(visitor, "boss", "wrong")
        house.wall.now_s += FIRST_LOCKOUT_S
        problem(await try_in(visitor, "boss", "wrong"), 401, "wrong-login")
        wall = house.wall
    async with gateway(url, wall=wall) as house, house.visitor() as visitor:
        answer = await try_in(visitor, "boss", PASSWORD)
        problem(answer, 429, "too-many-tries")
        assert answer.headers["retry-after"] == str(int(2 * FIRST_LOCKOUT_S))


def test_a_lockout_doubles_up_to_an_hour() -> None:
    assert [lockout_s(n) for n in (1, 4, 5, 6, 7)] == [0, 0, 30, 60, 120]
    assert lockout_s(12) == LONGEST_LOCKOUT_S == lockout_s(10_000)


async def test_failures_are_forgotten_after_a_day(house: House, visitor: httpx.AsyncClient) -> None:
    for _ in range(FREE_FAILURES - 1):
        await try_in(visitor, "nobody", "wrong")
    house.wall.now_s += FORGIVEN_S + 1
    await try_in(visitor, "somebody", "wrong")
    async with house.store.read() as work:
        assert await work.lockouts.count() == 1


async def test_many_guesses_at_once_count_as_many(house: House, visitor: httpx.AsyncClient) -> None:
    await house.know("boss")
    answers = await asyncio.gather(*(try_in(visitor, "boss", f"guess {n}") for n in range(12)))
    statuses = [answer.status_code for answer in answers]
    assert (statuses.count(401), statuses.count(429)) == (FREE_FAILURES, 12 - FREE_FAILURES)


async def test_one_address_tries_so_many_names_and_no_more(house: House, visitor: httpx.AsyncClient) -> None:
    await house.know("boss")
    for n in range(TRIES):
        problem(await try_in(visitor, f"name-{n}", "wrong"), 401, "wrong-login")
    answer = await try_in(visitor, "boss", PASSWORD)
    problem(answer, 429, "too-many-tries")
    wait_s = int(answer.headers["retry-after"])
    problem(await visitor.post("/login/guess"), 429, "too-many-tries")
    house.wall.now_s += wait_s
    assert (await try_in(visitor, "boss", PASSWORD)).status_code == 303


async def test_whoever_succeeds_is_not_slowed_down(house: House, visitor: httpx.AsyncClient) -> None:
    await house.know("boss")
    for _ in range(2 * TRIES):
        assert (await try_in(visitor, "boss", PASSWORD)).status_code == 303


def test_one_who_has_a_whole_network_has_one_bucket() -> None:
    assert neighbourhood("2001:db8::1") == neighbourhood("2001:db8::ffff:1")
    assert neighbourhood("2001:db8::1") != neighbourhood("2001:db8:0:1::1")
    assert neighbourhood("::ffff:192.0.2.1") == neighbourhood("192.0.2.1") != neighbourhood("192.0.2.2")
    assert neighbourhood("") == ""


def test_no_more_buckets_are_kept_than_there_is_room_for() -> None:
    limit = Limit(lambda: 0.0, tries=1, rate_hz=1.0)
    for n in range(BUCKETS + 5):
        limit.take(str(n))
    assert len(limit._buckets) == BUCKETS
    with pytest.raises(Problem):
        limit.take(str(BUCKETS))


def test_a_wall_clock_that_goes_back_gives_nothing() -> None:
    now_s = [1000.0]
    limit = Limit(lambda: now_s[0], tries=1, rate_hz=1.0)
    limit.take("a")
    now_s[0] = 10.0
    with pytest.raises(Problem):
        limit.take("a")

"""Two gateways on one database, and the clock of one is behind: of two deeds the later one holds, though its time is the earlier one."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest
from answers import problem
from fake_bus import FakeBus
from gateway_kit import House, gateway
from products_kit import NEW, define
from wall_clock import NOW_S, Wall

from dray.gateway.access.access import Access
from dray.gateway.access.keys import KNOWN_S
from dray.gateway.access.principal import Role, Scope
from dray.gateway.factory.catalogue import Catalogue
from dray.gateway.http.provided import provided

pytestmark = pytest.mark.anyio

BEHIND_S = 3600.0


@asynccontextmanager
async def apart(url: str) -> AsyncIterator[tuple[House, House]]:
    """A gateway, and one whose clock was set back by an hour."""
    bus = FakeBus()
    async with (
        gateway(url, bus=bus, wall=Wall(), gateway_name="gateway-1") as first,
        gateway(url, bus=bus, wall=Wall(NOW_S - BEHIND_S), gateway_name="gateway-2") as behind,
    ):
        yield first, behind


async def learn(*houses: House) -> None:
    """What every gateway does every few seconds: it reads who may stop vehicles."""
    for house in houses:
        access = provided(house.app, Access)
        await access.sessions.learn()
        await access.keys.learn()


async def test_a_person_who_is_disabled_where_the_clock_is_behind_is_out_at_both(url: str) -> None:
    async with apart(url) as (first, behind):
        boss, ana = await first.log_in("boss"), await first.log_in("ana", Role.OPERATOR)
        del boss
        assert (await ana.get("/api/me")).status_code == 200
        for house, act in ((first, "disable"), (behind, "enable"), (first, "disable"), (behind, "enable")):
            assert (await house.client.post(f"/api/people/ana/{act}")).status_code == 200
        token = ana.cookies.get("dray-session") or next(iter(ana.cookies.values()))
        again = first.visitor()
        answer = await again.post("/login", data={"name": "ana", "secret": "402719"})
        assert answer.status_code == 303, "the newest deed is that she may come in, with the earlier time"
        assert (await ana.get("/api/me")).status_code == 401, "the old session has ended for good"
        assert (await behind.client.post("/api/people/ana/disable")).status_code == 200
        problem(await again.get("/api/me"), 401, "not-logged-in")
        await learn(first, behind)
        for house in (first, behind):
            sessions = provided(house.app, Access).sessions
            for cookie in (token, next(iter(again.cookies.values()))):
                assert sessions.remembered(cookie, house.wall.now_s) is None
            shown = {each["id"]: each for each in (await house.get("/api/people"))["items"]}
            assert shown["ana"]["disabled_at_s"] == NOW_S - BEHIND_S


async def test_a_key_that_is_taken_back_where_the_clock_is_behind_is_refused_at_both(url: str) -> None:
    async with apart(url) as (first, behind):
        key, shows = await first.key(Scope.FACTORY_READ, Scope.VEHICLES_STOP)
        await learn(first, behind)
        assert (await behind.client.post(f"/api/keys/{key.id}/revoke")).status_code == 200
        first.wall.now_s += KNOWN_S
        await learn(first, behind)
        token = shows["Authorization"].removeprefix("Bearer ")
        for house in (first, behind):
            assert (await house.visitor(**shows).get("/api/atvs")).status_code == 401
            assert provided(house.app, Access).keys.remembered(token, house.wall.now_s) is None


async def test_a_product_that_is_removed_where_the_clock_is_behind_is_gone_at_both_and_comes_back_defined_anew(
    url: str,
) -> None:
    async with apart(url) as (first, behind):

        async def look() -> None:
            for house in (first, behind):
                async with house.store.read() as work:
                    await provided(house.app, Catalogue).look(work)

        assert (await define(first, NEW, "bracket")).status_code == 201
        await look()
        assert (await behind.client.delete("/api/products/bracket")).status_code == 204
        await look()
        for house in (first, behind):
            problem(await house.client.get("/api/products/bracket"), 404, "unknown-product")
        assert (await define(behind, NEW, "bracket")).status_code == 201
        await look()
        assert (await first.client.delete("/api/products/bracket")).status_code == 204
        await look()
        for house in (first, behind):
            problem(await house.client.get("/api/products/bracket"), 404, "unknown-product")

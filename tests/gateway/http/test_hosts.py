"""Under which names a gateway may be asked, and which address it tells others."""

from __future__ import annotations

import pytest
from answers import PROBLEM, problem
from gateway_kit import House, draft, gateway

from dray.gateway.http.hosts import Hosts
from dray.settings import Settings

pytestmark = pytest.mark.anyio


@pytest.mark.parametrize("host", ["evil.test", "dray.test.evil.test", "", "[", "dray.test@evil.test", "a b"])
async def test_whoever_asks_by_a_strange_name_is_refused_whatever_is_asked(
    quiet_house: House, host: str
) -> None:
    for path in ("/healthz", "/api/orders", "/", "/api/track/x"):
        told = problem(await quiet_house.client.get(path, headers={"Host": host}), 421, "unknown-host")
        assert "DRAY_ALLOWED_HOSTS" in told["detail"]


@pytest.mark.parametrize(
    "host",
    ["dray.test", "DRAY.test.", "dray.test:8000", "localhost", "127.0.0.1:8000", "10.1.2.3", "[::1]:8000"],
)
async def test_an_address_and_a_name_of_ours_are_known(quiet_house: House, host: str) -> None:
    answer = await quiet_house.client.get("/healthz", headers={"Host": host})
    assert answer.status_code == 200


def test_names_come_from_the_settings_and_a_star_is_any() -> None:
    told = Settings.load(
        host="0.0.0.0",
        public_url="https://plant.example.com:8443",
        allowed_hosts="dray.lan, other.lan",
    )
    hosts = Hosts.of(told)
    for name in ("plant.example.com:8443", "dray.lan", "other.lan:80", "localhost"):
        assert hosts.know(name)
    assert not hosts.know("example.com")
    assert Hosts("*").know("example.com")


async def test_a_link_for_a_customer_leads_to_the_public_address_whoever_asks(url: str) -> None:
    async with gateway(url, public_url="https://dray.example.com") as house:
        headers = {"Host": "10.1.2.3:8000"}
        order = (await house.client.post("/api/orders", json=draft(), headers=headers)).json()
        assert order["tracking_url"].startswith("https://dray.example.com/track/")
        listed = (await house.client.get("/api/orders", headers=headers)).json()["items"]
        assert [each["tracking_url"] for each in listed] == [order["tracking_url"]]


@pytest.mark.parametrize(
    ("path", "allowed"),
    [
        ("/api/orders", "GET, POST"),
        ("/api/atvs/ATV1/commands", "POST"),
        ("/healthz", "GET"),
        ("/login", "GET, POST"),
    ],
)
async def test_options_are_answered_with_what_is_allowed(quiet_house: House, path: str, allowed: str) -> None:
    answer = await quiet_house.client.options(path)
    assert answer.status_code == 204
    assert answer.headers["allow"] == allowed
    assert PROBLEM not in answer.headers.get("content-type", "")
    problem(await quiet_house.client.options("/api/nothing"), 404, "not-found")

"""What tests of the login have in common: a form that is sent, cookies that are read, a link that is made."""

from __future__ import annotations

import httpx
from gateway_kit import HOME, House

from dray.gateway.access.login.invitations import invite

BROWSER = {"Accept": "text/html,application/xhtml+xml", "Origin": HOME, "Sec-Fetch-Site": "same-origin"}
"""What a browser sends with a form of ours."""

COOKIE = "dray_session"


async def try_in(client: httpx.AsyncClient, name: str, secret: str, **more: str) -> httpx.Response:
    return await client.post("/login", data={"name": name, "secret": secret, **more})


def set_cookies(answer: httpx.Response) -> dict[str, str]:
    """What an answer tells a browser to keep, whole, by name."""
    return {line.partition("=")[0]: line for line in answer.headers.get_list("set-cookie")}


async def link_for(house: House, person_id: str, life_s: float = 3600.0) -> str:
    async with house.store.write() as work:
        return "/login/" + await invite(work, person_id, house.wall.now_s, life_s)

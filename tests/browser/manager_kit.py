"""A manager before the panel of a house, and a clock that goes as the browser's does."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

from open_house import OpenHouse
from playwright.sync_api import Page, expect

sys.path.insert(0, str(Path(__file__).parents[1] / "gateway/kits"))

from gateway_kit import House
from wall_clock import Wall

OpenPage = Callable[..., Page]

BEAT_S = 0.5
"""How often vehicles of a house say how they are."""


class GoingWall(Wall):
    """A wall clock that goes as the browser's does; `now_s` puts it forward."""

    def __init__(self) -> None:
        super().__init__()
        self._begun_s = time.monotonic()

    def __call__(self) -> float:
        return self.now_s + time.monotonic() - self._begun_s


def as_manager(house: OpenHouse, open_page: OpenPage, **look: object) -> Page:
    async def session(inside: House) -> str:
        return (await inside.log_in("manager")).cookies["dray_session"]

    page = open_page("about:blank", who=None, **look)
    cookie = {"name": "dray_session", "value": house.do(session), "url": house.url}
    page.context.add_cookies([cookie | {"httpOnly": True, "sameSite": "Strict"}])
    page.goto(house.url)
    return page


def choose(page: Page, name: str) -> None:
    """With the keyboard alone, once the panel knows who is there."""
    finder = page.get_by_role("combobox", name="Find")
    finder.focus()
    page.keyboard.type(name)
    expect(page.locator("#finder-list").get_by_role("option").first).to_contain_text(name)
    page.keyboard.press("Enter")

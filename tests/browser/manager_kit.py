"""A manager before the panel of a house, and a clock that goes as the browser's does."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

from open_house import OpenHouse
from playwright.sync_api import Page, Route, expect

sys.path.insert(0, str(Path(__file__).parents[1] / "gateway/kits"))

from gateway_kit import House
from wall_clock import Wall

from dray.plant import PlantFile

OpenPage = Callable[..., Page]

BEAT_S = 0.5
"""How often vehicles of a house say how they are."""

ASKED = 60
"""Times, before it is given up."""

BEFORE_S = 5
"""Kept before a moment of the past that is shown: a test goes back by less."""


PAD_PX = {"left": 12, "right": 12, "top": 10, "bottom": 32}
"""Around the floor, as the map draws it at first (`frontend/src/plant/draw/renderer.ts`)."""


class GoingWall(Wall):
    """A wall clock that goes as the browser's does; `now_s` puts it forward."""

    def __init__(self) -> None:
        super().__init__()
        self._begun_s = time.monotonic()

    def __call__(self) -> float:
        return self.now_s + time.monotonic() - self._begun_s


def as_manager(
    house: OpenHouse,
    open_page: OpenPage,
    *,
    before: Callable[[Page], None] = lambda _page: None,
    **look: object,
) -> Page:
    async def session(inside: House) -> str:
        return (await inside.log_in("manager")).cookies["dray_session"]

    page = open_page("about:blank", who=None, **look)
    cookie = {"name": "dray_session", "value": house.do(session), "url": house.url}
    page.context.add_cookies([cookie | {"httpOnly": True, "sameSite": "Strict"}])
    before(page)
    page.goto(house.url)
    return page


def choose(page: Page, name: str) -> None:
    """With the keyboard alone, once the panel knows who is there."""
    finder = page.get_by_role("combobox", name="Find")
    finder.focus()
    page.keyboard.type(name)
    expect(page.locator("#finder-list").get_by_role("option").first).to_contain_text(name)
    page.keyboard.press("Enter")


@contextmanager
def held(page: Page, address: str) -> Iterator[Callable[[], Any]]:
    """Posts to an address wait until the given function is called, which returns the answer to the first."""
    waiting: list[Route] = []
    gone: list[bool] = []

    def hold(route: Route) -> None:
        if route.request.method != "POST" or gone:
            route.continue_()
        else:
            waiting.append(route)

    def let_go() -> Any:
        with page.expect_response(lambda response: response.request.method == "POST") as answered:
            gone.append(True)
            for route in waiting:
                route.continue_()
        return answered.value.json()

    page.route(address, hold)
    yield let_go
    page.unroute(address, hold)


def map_scale(page: Page, plant: PlantFile) -> float:
    """Pixels per metre of the map, as it is drawn at first."""
    box = page.locator("#plant-map").bounding_box()
    assert box is not None
    width_px = box["width"] - PAD_PX["left"] - PAD_PX["right"]
    height_px = box["height"] - PAD_PX["top"] - PAD_PX["bottom"]
    return min(width_px / plant.width_m, height_px / plant.height_m)


def on_map(page: Page, plant: PlantFile, x_m: float, y_m: float) -> tuple[float, float]:
    """Where a point of the floor is drawn."""
    box, scale = page.locator("#plant-map").bounding_box(), map_scale(page, plant)
    assert box is not None
    width_px = box["width"] - PAD_PX["left"] - PAD_PX["right"]
    height_px = box["height"] - PAD_PX["top"] - PAD_PX["bottom"]
    left_px = PAD_PX["left"] + (width_px - plant.width_m * scale) / 2
    low_px = PAD_PX["top"] + (height_px + plant.height_m * scale) / 2
    return box["x"] + left_px + x_m * scale, box["y"] + low_px - y_m * scale


def kept_moment(dray: Any, before_s: float = BEFORE_S) -> float:
    """Four seconds ago at a stepped factory, once enough was kept before it to go back to: so many seconds."""
    for _ in range(ASKED):
        now_s = dray.wall_s
        span = urlencode({"since": iso(now_s - 60), "until": iso(now_s)})
        from_s = dray.ask(f"/api/replay/overview?{span}")["kept_from_at_s"]
        if from_s is not None and from_s < now_s - before_s - 4:
            return float(now_s - 4)
        dray.advance(10.0)
    raise AssertionError("nothing was kept")


def iso(at_s: float) -> str:
    """A moment as REST reads it."""
    return datetime.fromtimestamp(at_s, UTC).isoformat()

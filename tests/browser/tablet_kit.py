"""A tablet at a station: who stands before it, what it shows, and what can happen to it."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from complaints import Complaints
from open_house import OpenHouse, open_house
from playwright.sync_api import Locator, Page, WebSocketRoute, expect
from puppets import Puppet

sys.path.insert(0, str(Path(__file__).parents[1] / "gateway/kits"))

from gateway_kit import House
from heartbeats import machine_heartbeat

from dray.gateway.access.principal import Role
from dray.messages import AtvStatus, BufferLevel, CommandKind, HelpWanted, MachineStatus, Problem, ProblemKind

OpenPage = Callable[..., Page]
Enter = Callable[..., Page]

LYING, UPRIGHT = {"width": 1024, "height": 768}, {"width": 800, "height": 1280}
"""The tablets that the panel is made for."""

PHONE = {"width": 390, "height": 844}
"""What somebody may have in a pocket."""

LOOKS = {
    "lying-light-en": {"viewport": LYING, "color_scheme": "light", "locale": "en-GB"},
    "upright-dark-de": {"viewport": UPRIGHT, "color_scheme": "dark", "locale": "de-DE"},
    "phone-dark-es": {"viewport": PHONE, "color_scheme": "dark", "locale": "es-ES"},
}

AREA, STATION = "AREA3", "M8"
IN_AREA = {"ATV2": (25.0, 14.5), "ATV6": (40.0, 14.5)}
"""Vehicles in the middle of the area."""

WHO = "operator-south"

TOUCH_PX, THUMB_PX = 64.0, 118.0
"""A finger in a glove; and 20 mm on a tablet of ten inches, with 149 px to the inch."""

HOLD_MS = 1200
"""Longer than Resume has to be held."""


@pytest.fixture
def house(sqlite_url: str) -> Iterator[OpenHouse]:
    """A gateway to which the test tells what happens in its factory."""
    with open_house(sqlite_url) as house:
        yield house


@pytest.fixture
def vehicles(house: OpenHouse) -> dict[str, Puppet]:
    """The vehicles in the area, and the machine of the station."""

    async def join(inside: House) -> dict[str, Puppet]:
        stock = (
            BufferLevel(item="housing", level=11, capacity=72, reorder_point=20, on_order=24),
            BufferLevel(item="shaft", level=38, capacity=120, reorder_point=20),
        )
        inside.bus.say(machine_heartbeat(STATION, at_s=3600.0, status=MachineStatus.PRODUCING, buffers=stock))
        return {atv: await Puppet.join(inside, atv, *place) for atv, place in IN_AREA.items()}

    return house.do(join)


@pytest.fixture
def enter(open_page: OpenPage, house: OpenHouse) -> Enter:
    """Open the panel as the operator of the area; once more for another tab of the same browser."""

    def enter(
        *,
        beside: Page | None = None,
        before: Callable[[Page], None] = lambda _page: None,
        area: str = AREA,
        station: str = STATION,
        **look: Any,
    ) -> Page:
        if beside is not None:
            page = beside.context.new_page()
        else:
            page = open_page("about:blank", who=None, has_touch=True, **{"viewport": LYING} | look)
            token = house.do(partial(_session, area=area, station=station))
            cookie = {"name": "dray_session", "value": token, "url": house.url}
            page.context.add_cookies([cookie | {"httpOnly": True, "sameSite": "Strict"}])
        before(page)
        page.goto(f"{house.url}/operator")
        return page

    return enter


async def _session(house: House, area: str, station: str) -> str:
    browser = await house.log_in(WHO, Role.OPERATOR, area)
    if area == AREA and station:
        await browser.post("/login/station", data={"station": station})
    return browser.cookies["dray_session"]


def card(page: Page, atv: str) -> Locator:
    return page.locator(f"#vehicle-{atv}")


def stop_of(page: Page, atv: str) -> Locator:
    return page.locator(f"#stop-{atv}")


def assert_touchable(*buttons: Locator) -> None:
    """Each is large enough for a finger in a glove."""
    for button in buttons:
        box = button.bounding_box()
        assert box is not None
        assert min(box["width"], box["height"]) >= TOUCH_PX


def press_and_hold(page: Page, button: Locator) -> None:
    button.scroll_into_view_if_needed()
    box = button.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    page.wait_for_timeout(HOLD_MS)
    page.mouse.up()


def answer(page: Page, card: Locator, *, first: bool) -> None:
    """Give one of the two answers to a card's question: a long touch does it, and a short one nothing."""
    buttons = card.locator(".vehicle-acts button")
    expect(buttons).to_have_count(2)
    assert_touchable(*buttons.all())
    chosen = buttons.first if first else buttons.last
    chosen.tap()
    press_and_hold(page, chosen)
    expect(card).to_have_count(0)


def settle(page: Page) -> None:
    """Wait until cards that have moved count touches again."""
    expect(page.locator(".vehicle.settling")).to_have_count(0)


def kinds(vehicle: Puppet) -> list[CommandKind]:
    return [command.kind for command in vehicle.heard]


def forgive(complaints: Complaints, *causes: str) -> None:
    """Take back what the test itself has brought about; each cause must have been complained of."""
    for cause in causes:
        assert any(cause in complaint for complaint in complaints), (cause, list(complaints))
    complaints[:] = [each for each in complaints if not any(cause in each for cause in causes)]


def ask_for_help(vehicle: Puppet) -> Callable[[House], Any]:
    """It has a problem, and a task that waits."""
    wanted = HelpWanted(until_s=170.0)
    about = Problem(kind=ProblemKind.LOAD, passes=False, needs_person=True, load_movable=True)
    return beat(
        vehicle, status=AtvStatus.ERROR, problem="the load has shifted", about_problem=about, help=wanted
    )


def beat(vehicle: Puppet, **state: Any) -> Callable[[House], Any]:
    """It changes, and says so."""

    async def say(_house: House) -> None:
        vehicle.beat(**state)

    return say


class Cable:
    """The network between a page and its gateway, which can be pulled out."""

    def __init__(self) -> None:
        self._page: Page | None = None
        self._sockets: list[WebSocketRoute] = []
        self._out = False

    def lay(self, page: Page) -> None:
        self._page = page
        page.route_web_socket("**/api/stream", self._open)

    def pull(self) -> None:
        assert self._page is not None
        self._out = True
        self._page.context.set_offline(True)
        for socket in self._sockets:
            socket.close()

    def plug_in(self) -> None:
        assert self._page is not None
        self._out = False
        self._page.context.set_offline(False)

    def _open(self, socket: WebSocketRoute) -> None:
        if self._out:
            socket.close()
        else:
            self._sockets.append(socket)
            socket.connect_to_server()


CUT_MS = 60_000
"""Many times what a vehicle may be silent for."""


AHEAD = """(() => {
    const now = performance.now.bind(performance);
    let ahead = 0;
    performance.now = () => now() + ahead;
    window.goAhead = (ms) => { ahead += ms; };
})()"""
"""The clock by which a panel tells how old its picture is, to be put forward."""


def can_be_cut_off(page: Page, cable: Cable) -> None:
    """To be called before the page is opened: its network can be cut, and its clock put forward."""
    cable.lay(page)
    page.add_init_script(AHEAD)


def be_cut_off(page: Page, cable: Cable) -> None:
    """For a minute, counted since the page has noticed: a frame may have been on its way.

    What the page asks for of its own accord is there before.
    """
    page.wait_for_load_state("networkidle")
    cable.pull()
    banner = page.locator(".banner")
    expect(banner).to_contain_text("No connection to the plant")
    page.evaluate("ms => window.goAhead(ms)", CUT_MS)
    expect(banner).to_contain_text(re.compile(r"([6-9]\d|1\d\d)\ss|[1-3]:\d\d"))

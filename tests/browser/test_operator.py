"""The operator panel, as a person at a station uses it: by touch, with gloves, on a network that may fail."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from complaints import Complaints
from open_house import OpenHouse, open_house
from playwright.sync_api import Locator, Page, WebSocketRoute, expect
from puppets import Puppet

sys.path.insert(0, str(Path(__file__).parents[1] / "gateway"))

from gateway_kit import PIN, House, machine_heartbeat

from dray.gateway.access.principal import Role
from dray.gateway.access.sessions import LIFE_S
from dray.messages import AtvStatus, BufferLevel, CommandKind, HelpWanted, MachineStatus

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]
Enter = Callable[..., Page]

LYING, UPRIGHT = {"width": 1024, "height": 768}, {"width": 800, "height": 1280}
"""The tablets that the panel is made for."""

LOOKS = {
    "lying-light-en": {"viewport": LYING, "color_scheme": "light", "locale": "en-GB"},
    "upright-dark-de": {"viewport": UPRIGHT, "color_scheme": "dark", "locale": "de-DE"},
}

AREA, STATION = "AREA3", "M8"
IN_AREA = {"ATV2": (25.0, 14.5), "ATV6": (40.0, 14.5)}
"""Vehicles in the middle of the area."""

WHO = "operator-south"

TOUCH_PX, THUMB_PX = 64.0, 118.0
"""A finger in a glove; and 20 mm on a tablet of ten inches, with 149 px to the inch."""

HOLD_MS = 1200
"""Longer than Resume has to be held."""

PAST_MS = 12_000
"""A picture is one of the past after five seconds."""

NOT_CONFIRMED_MS = 8_000
"""A vehicle has three seconds to answer."""


@pytest.fixture
def house(tmp_path: Path) -> Iterator[OpenHouse]:
    """A gateway to which the test tells what happens in its factory."""
    with open_house(tmp_path) as house:
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
        *, beside: Page | None = None, before: Callable[[Page], None] = lambda _page: None, **look: Any
    ) -> Page:
        if beside is not None:
            page = beside.context.new_page()
        else:
            page = open_page("about:blank", who=None, has_touch=True, **{"viewport": LYING} | look)
            token = house.do(_session)
            cookie = {"name": "dray_session", "value": token, "url": house.url}
            page.context.add_cookies([cookie | {"httpOnly": True, "sameSite": "Strict"}])
        before(page)
        page.goto(f"{house.url}/operator")
        return page

    return enter


async def _session(house: House) -> str:
    browser = await house.log_in(WHO, Role.OPERATOR, AREA)
    await browser.post("/login/station", data={"station": STATION})
    return browser.cookies["dray_session"]


def card(page: Page, atv: str) -> Locator:
    return page.locator(f"#vehicle-{atv}")


def press_and_hold(page: Page, button: Locator) -> None:
    button.scroll_into_view_if_needed()
    box = button.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    page.wait_for_timeout(HOLD_MS)
    page.mouse.up()


def kinds(vehicle: Puppet) -> list[CommandKind]:
    return [command.kind for command in vehicle.heard]


def forgive(complaints: Complaints, *causes: str) -> None:
    """Take back what the test itself has brought about; each cause must have been complained of."""
    for cause in causes:
        assert any(cause in complaint for complaint in complaints), (cause, list(complaints))
    complaints[:] = [each for each in complaints if not any(cause in each for cause in causes)]


# --- coming in ---------------------------------------------------------------------------------------


def test_an_operator_comes_in_by_touch_with_a_pin_and_a_station(
    house: OpenHouse, vehicles: dict[str, Puppet], open_page: OpenPage, screenshot: Screenshot
) -> None:
    house.do(lambda inside: inside.know(WHO, Role.OPERATOR, AREA))
    page = open_page(f"{house.url}/operator", who=None, has_touch=True, viewport=LYING)
    page.get_by_label("Name").fill(WHO)
    for digit in f"9{PIN}":
        page.get_by_role("button", name=digit, exact=True).tap()
    secret = page.locator("#secret")
    for _ in range(len(PIN) + 1):
        page.get_by_role("button", name="Delete the last digit").tap()
    expect(secret).to_have_value("")
    for digit in PIN:
        page.get_by_role("button", name=digit, exact=True).tap()
    screenshot(page, "operator-login")
    page.get_by_role("button", name="Log in").tap()
    page.get_by_role("button", name=STATION).tap()
    expect(page).to_have_url(f"{house.url}/operator")
    expect(page.get_by_role("heading", level=1)).to_contain_text(STATION)
    material = page.get_by_role("region", name="Material")
    expect(material).to_contain_text("11 / 72")
    expect(material).to_contain_text("+24")


def test_only_the_own_area_is_shown(house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter) -> None:
    house.do(lambda inside: Puppet.join(inside, "ATV1", 25.0, 35.0))
    page = enter()
    expect(page.locator(".vehicle h2")).to_have_text(["ATV2", "ATV6"])
    expect(page.get_by_role("banner")).to_contain_text("South middle")


def test_every_stop_is_as_large_as_a_thumb_and_everything_else_as_a_finger_in_a_glove(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    house.do(_ask_for_help(vehicles["ATV2"]))
    page = enter()
    expect(card(page, "ATV2")).to_contain_text("asks for help")
    for size in (LYING, UPRIGHT):
        page.set_viewport_size(size)
        boxes = page.locator("button:visible:not(.link), a.button:visible").evaluate_all(
            "all => all.map(each => [each.className, each.offsetWidth, each.offsetHeight])"
        )
        assert len(boxes) > 10
        small = [box for box in boxes if min(box[1:]) < (THUMB_PX if box[0] == "stop" else TOUCH_PX)]
        assert small == []


# --- stop, acknowledge, resume -----------------------------------------------------------------------


@pytest.mark.parametrize("look", LOOKS)
def test_a_stop_holds_until_two_acts_in_two_places_end_it(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot, look: str
) -> None:
    page = enter(**LOOKS[look])
    stopped = card(page, "ATV2")
    stopped.locator(".stop").tap()
    line = stopped.locator(".command")
    expect(line.locator(".stage")).to_have_count(3)
    expect(line.locator(".stage.now")).to_have_class("stage now")
    acknowledge, resume = stopped.locator(".act").nth(0), stopped.locator(".act").nth(1)
    expect(resume).to_be_disabled()
    screenshot(page, f"operator-stopped-{look}")
    acknowledge.tap()
    expect(acknowledge).to_be_disabled()
    expect(resume).to_be_enabled()
    resume.tap()
    expect(line).not_to_have_class("command command-sent")
    assert CommandKind.RESUME not in kinds(vehicles["ATV2"]), "a touch alone resumes nothing"
    press_and_hold(page, resume)
    expect(stopped.locator(".act")).to_have_count(0)
    screenshot(page, f"operator-calm-{look}")
    assert kinds(vehicles["ATV2"]) == [CommandKind.STOP, CommandKind.ACKNOWLEDGE, CommandKind.RESUME]
    assert kinds(vehicles["ATV6"]) == []


def test_a_fault_that_is_still_there_cannot_be_acknowledged(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    house.do(_ask_for_help(vehicles["ATV2"]))
    page = enter()
    asking = card(page, "ATV2")
    asking.get_by_role("button", name="Stop vehicle").tap()
    acknowledge = asking.get_by_role("button", name="Fault is gone")
    expect(acknowledge).to_be_disabled()
    expect(asking).to_contain_text("It still reports: the load has shifted.")
    house.do(_beat(vehicles["ATV2"], problem=""))
    expect(acknowledge).to_be_enabled()


def test_speed_is_limited_in_steps_and_the_vehicles_word_shows_which(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    page = enter()
    half = card(page, "ATV6").get_by_role("button", name="At most 50")
    expect(half).to_have_attribute("aria-pressed", "false")
    half.tap()
    expect(half).to_have_attribute("aria-pressed", "true")
    [command] = vehicles["ATV6"].heard
    assert (command.kind, command.speed_frac, command.issued_by) == (CommandKind.SET_SPEED, 0.5, WHO.title())


@pytest.mark.parametrize("look", LOOKS)
def test_a_call_for_help_comes_first_and_a_promise_is_told_to_the_vehicle(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot, look: str
) -> None:
    page = enter(**LOOKS[look])
    expect(page.locator(".vehicle h2")).to_have_text(["ATV2", "ATV6"])
    house.do(_ask_for_help(vehicles["ATV6"]))
    expect(page.locator(".vehicle h2")).to_have_text(["ATV6", "ATV2"])
    asking = card(page, "ATV6")
    expect(asking.get_by_role("timer")).to_contain_text("min")
    screenshot(page, f"operator-help-{look}")
    asking.locator(".promises button").nth(1).tap()
    expect(asking.get_by_role("timer")).to_contain_text(WHO.title())
    [promise] = vehicles["ATV6"].heard
    assert (promise.kind, promise.wait_s) == (CommandKind.PROMISE, 180.0)


def _ask_for_help(vehicle: Puppet) -> Callable[[House], Any]:
    wanted = HelpWanted(until_s=170.0)
    return _beat(vehicle, status=AtvStatus.ERROR, problem="the load has shifted", help=wanted)


def _beat(vehicle: Puppet, **state: Any) -> Callable[[House], Any]:
    async def beat(_house: House) -> None:
        vehicle.beat(**state)

    return beat


# --- what can fail -----------------------------------------------------------------------------------


def test_a_refusal_is_told_with_the_vehicles_reason(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    house.do(_beat(vehicles["ATV2"], status=AtvStatus.STOPPED, acknowledged=True))
    page = enter()
    resume = card(page, "ATV2").get_by_role("button", name="Resume")
    expect(resume).to_be_enabled()
    vehicles["ATV2"].state["acknowledged"] = False  # and its heartbeat has not come yet
    press_and_hold(page, resume)
    line = card(page, "ATV2").locator(".command")
    expect(line).to_contain_text("refused")
    expect(line).to_contain_text("the fault is not acknowledged yet")


def test_a_vehicle_that_does_not_answer_has_not_confirmed(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, complaints: Complaints
) -> None:
    vehicles["ATV2"].deaf = True
    page = enter()
    card(page, "ATV2").get_by_role("button", name="Stop vehicle").tap()
    line = card(page, "ATV2").locator(".command")
    expect(line).to_contain_text("accepted")
    expect(line).to_contain_text("not confirmed", timeout=NOT_CONFIRMED_MS)
    expect(line).to_contain_text("may or may not have heard")
    forgive(complaints, "status of 504")


def test_of_a_silent_vehicle_only_stop_is_left(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot
) -> None:
    house.do(_beat(vehicles["ATV2"], at_s=-100.0))
    page = enter()
    silent = card(page, "ATV2")
    expect(silent).to_contain_text("Last heard")
    for step in silent.locator(".steps button").all():
        expect(step).to_be_disabled()
    screenshot(page, "operator-silent")
    silent.get_by_role("button", name="Stop vehicle").tap()
    expect(silent.locator(".command")).to_contain_text("confirmed by the vehicle")
    assert kinds(vehicles["ATV2"]) == [CommandKind.STOP]


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


def test_a_cut_network_is_said_and_no_command_waits_for_its_end(
    house: OpenHouse,
    vehicles: dict[str, Puppet],
    enter: Enter,
    screenshot: Screenshot,
    complaints: Complaints,
) -> None:
    cable = Cable()
    page = enter(before=cable.lay)
    expect(page.locator(".vehicle")).to_have_count(2)
    cable.pull()
    banner = page.get_by_role("alert")
    expect(banner).to_contain_text("No connection to the plant", timeout=PAST_MS)
    expect(banner).to_contain_text("In danger use the button on the vehicle")
    moved = card(page, "ATV2")
    expect(moved.get_by_role("button", name="At most 50")).to_be_disabled()
    screenshot(page, "operator-offline")
    moved.get_by_role("button", name="Stop vehicle").tap()
    expect(moved.locator(".command")).to_contain_text("not confirmed")
    house.do(_beat(vehicles["ATV6"], status=AtvStatus.CHARGING))
    cable.plug_in()
    expect(banner).to_be_hidden()
    expect(card(page, "ATV6")).to_contain_text("charging")
    expect(moved.get_by_role("button", name="At most 50")).to_be_enabled()
    assert kinds(vehicles["ATV2"]) == [], "a stop is given when it is pressed, or not at all"
    forgive(complaints, "ERR_INTERNET_DISCONNECTED")


def test_a_session_that_has_run_out_leaves_stop_and_a_way_in_again(
    house: OpenHouse,
    vehicles: dict[str, Puppet],
    enter: Enter,
    screenshot: Screenshot,
    complaints: Complaints,
) -> None:
    page = enter()
    moved = card(page, "ATV2")
    expect(moved).to_be_visible()

    async def shift_ends(inside: House) -> None:
        inside.wall.now_s += LIFE_S[Role.OPERATOR] + 60.0
        await inside.parts.access.watch.check()

    house.do(shift_ends)
    banner = page.get_by_role("alert")
    expect(banner).to_contain_text("Stop still works")
    expect(moved.get_by_role("button", name="At most 50")).to_be_disabled()
    moved.get_by_role("button", name="Stop vehicle").tap()
    expect(moved.locator(".command")).to_contain_text("confirmed by the vehicle")
    screenshot(page, "operator-session-ended")
    [stop] = vehicles["ATV2"].heard
    assert (stop.kind, stop.issued_by) == (CommandKind.STOP, WHO.title())
    banner.get_by_role("link", name="Log in").tap()
    expect(page.get_by_role("heading", name="Operator panel")).to_be_visible()
    forgive(complaints, "status of 401")


def test_a_session_that_was_ended_leaves_for_the_login(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    page = enter()
    expect(card(page, "ATV2")).to_be_visible()
    page.get_by_role("button", name="Settings").tap()
    page.get_by_role("button", name="Log out").tap()
    expect(page).to_have_url(f"{house.url}/login?as=operator")


def test_what_one_tab_commands_the_other_one_shows(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    first = enter()
    second = enter(beside=first)
    expect(card(second, "ATV2")).to_be_visible()
    card(first, "ATV2").get_by_role("button", name="Stop vehicle").tap()
    line = card(second, "ATV2").locator(".command")
    expect(line).to_contain_text("Stop")
    expect(line).to_contain_text("confirmed by the vehicle")
    expect(card(second, "ATV2").get_by_role("button", name="Fault is gone")).to_be_enabled()


def test_the_panel_opens_without_a_network_and_shows_nothing_old(
    house: OpenHouse,
    vehicles: dict[str, Puppet],
    enter: Enter,
    screenshot: Screenshot,
    complaints: Complaints,
) -> None:
    page = enter(service_workers="allow")
    expect(card(page, "ATV2")).to_be_visible()
    page.evaluate("() => navigator.serviceWorker.ready.then(() => undefined)")
    kept = page.evaluate(
        "async () => (await Promise.all((await caches.keys()).map(async name => (await caches.open(name)).keys())))"
        ".flat().map(request => new URL(request.url).pathname)"
    )
    assert kept
    assert not [path for path in kept if path.startswith("/api/")]
    page.context.set_offline(True)
    page.reload()
    expect(page.get_by_role("alert")).to_contain_text("nothing was heard of it yet")
    expect(page.locator(".vehicle")).to_have_count(0)
    screenshot(page, "operator-without-network")
    page.context.set_offline(False)
    expect(card(page, "ATV2")).to_be_visible()
    forgive(complaints, "ERR_INTERNET_DISCONNECTED")


# --- by keyboard -------------------------------------------------------------------------------------


def test_stop_acknowledge_and_resume_are_reached_by_keyboard_alone(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    page = enter()
    expect(card(page, "ATV2")).to_be_visible()
    tab_to(page, "Stop vehicle ATV2")
    page.keyboard.press("Enter")
    expect(card(page, "ATV2").get_by_role("button", name="Fault is gone")).to_be_enabled()
    page.keyboard.press("Shift+Tab")
    tab_to(page, "Fault is gone", back=True)
    page.keyboard.press("Space")
    expect(card(page, "ATV2").get_by_role("button", name="Resume")).to_be_enabled()
    tab_to(page, "Resume press and hold")
    page.keyboard.press("Enter")
    page.wait_for_timeout(HOLD_MS)
    assert kinds(vehicles["ATV2"]) == [CommandKind.STOP, CommandKind.ACKNOWLEDGE], (
        "a short press is not enough"
    )
    page.keyboard.down("Enter")
    page.wait_for_timeout(HOLD_MS)
    page.keyboard.up("Enter")
    expect(card(page, "ATV2").get_by_role("button", name="Resume")).to_have_count(0)
    assert kinds(vehicles["ATV2"])[-1] is CommandKind.RESUME


def tab_to(page: Page, name: str, *, back: bool = False) -> None:
    for _ in range(60):
        label = page.evaluate(
            "() => document.activeElement?.ariaLabel ?? document.activeElement?.textContent ?? ''"
        )
        if label == name:
            return
        page.keyboard.press("Shift+Tab" if back else "Tab")
    raise AssertionError(f"no way to {name} by keyboard")

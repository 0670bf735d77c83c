"""The operator panel, as a person at a station uses it: by touch, with gloves, on a network that may fail."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from accessibility import violations
from complaints import Complaints
from facts_kit import opened
from gateway_kit import PIN, House
from heartbeats import events, machine_heartbeat
from looks import WIDTHS_PX
from open_house import OpenHouse
from playwright.sync_api import Page, expect
from products_kit import NEW, define
from puppets import LATER_S, Puppet
from tablet_kit import (
    AREA,
    HOLD_MS,
    IN_AREA,
    LOOKS,
    LYING,
    STATION,
    THUMB_PX,
    TOUCH_PX,
    UPRIGHT,
    WHO,
    Enter,
    ask_for_help,
    beat,
    card,
    forgive,
    kinds,
    press_and_hold,
    settle,
    stop_of,
)

from dray.gateway.access.principal import Role
from dray.gateway.access.sessions import LIFE_S
from dray.messages import AtvStatus, Brief, BufferLevel, CommandKind, Phase, TaskBrief, Transport
from dray.messages import Role as MessageRole
from dray.messages.fact import AwardAnswered

Screenshot = Callable[..., Path]
SHAFTS = Transport(item="shaft", quantity=40, sources=("S3",), destination=STATION, ability="tote", goal="G1")
IN_EACH_LOOK = ["upright-dark-de", pytest.param("lying-light-en", marks=pytest.mark.slow)]


# --- coming in ---------------------------------------------------------------------------------------


def test_an_operator_comes_in_by_touch_with_a_pin_and_a_station(
    house: OpenHouse, vehicles: dict[str, Puppet], open_page: Callable[..., Page], screenshot: Screenshot
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
    house.do(ask_for_help(vehicles["ATV2"]))
    page = enter()
    expect(card(page, "ATV2")).to_contain_text("asks for help")
    for size in (LYING, UPRIGHT):
        page.set_viewport_size(size)
        boxes = page.locator("button:visible:not(.link), a.button:visible").evaluate_all(
            "all => all.map(each => [each.className, each.offsetWidth, each.offsetHeight])"
        )
        assert len(boxes) > 10
        stops = [box for box in boxes if "stop" in box[0].split()]
        assert len(stops) == len(IN_AREA)
        assert [box for box in boxes if min(box[1:]) < (THUMB_PX if box in stops else TOUCH_PX)] == []


# --- stop, acknowledge, resume -----------------------------------------------------------------------


@pytest.mark.parametrize("look", IN_EACH_LOOK)
def test_a_stop_holds_until_two_acts_in_two_places_end_it(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot, look: str
) -> None:
    page = enter(**LOOKS[look])
    stopped = card(page, "ATV2")
    stop_of(page, "ATV2").tap()
    line = stopped.locator(".command")
    expect(line.locator(".stage")).to_have_count(3)
    expect(line.locator(".stage.now")).to_have_class("stage now")
    acknowledge, resume = stopped.locator(".act").nth(0), stopped.locator(".act").nth(1)
    expect(resume).to_be_disabled()
    screenshot(page, f"operator-stopped-{look}")
    settle(page)
    acknowledge.tap()
    expect(acknowledge).to_be_disabled()
    expect(resume).to_be_enabled()
    resume.tap()
    expect(line).not_to_have_class("command command-sent")
    assert CommandKind.RESUME not in kinds(vehicles["ATV2"]), "a touch alone resumes nothing"
    press_and_hold(page, resume)
    expect(stopped.locator(".act")).to_have_count(0)
    screenshot(page, f"operator-idle-{look}")
    assert kinds(vehicles["ATV2"]) == [CommandKind.STOP, CommandKind.ACKNOWLEDGE, CommandKind.RESUME]
    assert kinds(vehicles["ATV6"]) == []


SHORT_PRESS = """key => {
    for (const kind of ["keydown", "keyup"])
        document.activeElement.dispatchEvent(new KeyboardEvent(kind, { key, bubbles: true, cancelable: true }));
}"""
"""A key that is let go at once, however busy the computer is."""

HELD_WHILE_BUSY = """button => {
    const touch = {bubbles: true, button: 0, pointerType: "touch"};
    button.dispatchEvent(new PointerEvent("pointerdown", touch));
    const began = performance.now();
    while (performance.now() - began < 1000);
    button.dispatchEvent(new PointerEvent("pointerup", touch));
}"""
"""A finger that holds for a second, in which the tablet does something else: no timer of it ends meanwhile."""


def test_a_tablet_that_is_busy_loses_no_hold(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    house.do(beat(vehicles["ATV2"], status=AtvStatus.STOPPED, acknowledged=True))
    page = enter()
    resume = card(page, "ATV2").locator(".act").nth(1)
    expect(resume).to_be_enabled()
    resume.evaluate(HELD_WHILE_BUSY)
    house.until(lambda _house: vehicles["ATV2"].heard)
    assert kinds(vehicles["ATV2"]) == [CommandKind.RESUME]


def test_a_fault_that_is_still_there_cannot_be_acknowledged(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    house.do(ask_for_help(vehicles["ATV2"]))
    page = enter()
    asking = card(page, "ATV2")
    stop_of(page, "ATV2").tap()
    acknowledge = asking.get_by_role("button", name="Fault is gone")
    expect(acknowledge).to_be_disabled()
    expect(asking).to_contain_text("It still reports: the load has shifted.")
    house.do(beat(vehicles["ATV2"], problem=""))
    expect(acknowledge).to_be_enabled()


def test_a_product_has_its_name_as_soon_as_somebody_has_defined_it(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    house.do(beat(vehicles["ATV2"], load="bracket", load_quantity=4))
    page = enter()
    doing = card(page, "ATV2").locator(".doing")
    expect(doing).to_contain_text("bracket")
    answer = house.do(lambda inside: define(inside, NEW, name="Angle of steel"))
    assert answer.status_code == 201, answer.text
    # Nobody has reloaded anything, and the vehicle says what it has said.
    expect(doing).to_contain_text("Angle of steel")


@pytest.mark.slow
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


@pytest.mark.parametrize("look", IN_EACH_LOOK)
def test_a_call_for_help_comes_first_and_what_a_person_says_of_it_is_told_to_the_vehicle(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot, look: str
) -> None:
    page = enter(**LOOKS[look])
    expect(page.locator(".vehicle h2")).to_have_text(["ATV2", "ATV6"])
    house.do(ask_for_help(vehicles["ATV6"]))
    expect(page.locator(".vehicle h2")).to_have_text(["ATV6", "ATV2"])
    asking = card(page, "ATV6")
    expect(asking.get_by_role("timer")).to_contain_text("min")
    settle(page)
    screenshot(page, f"operator-help-{look}")
    asking.locator(".promises button").nth(1).tap()
    expect(asking.get_by_role("timer")).to_contain_text(WHO.title())
    [promise] = vehicles["ATV6"].heard
    assert (promise.kind, promise.wait_s) == (CommandKind.PROMISE, 180.0)
    over = asking.locator(".hand-over")
    over.tap()
    expect(over).to_contain_class("leaving")
    over.tap()
    expect(over).not_to_contain_class("leaving")
    assert len(vehicles["ATV6"].heard) == 1, "a slip of the finger was taken back"
    over.tap()
    expect(over).to_have_count(0)
    assert kinds(vehicles["ATV6"])[1:] == [CommandKind.HAND_OVER]
    screenshot(page, f"operator-handed-over-{look}")


@pytest.mark.parametrize(
    ("look", "said"),
    [
        ("lying-light-en", ("+24 with a vehicle elsewhere", "a vehicle elsewhere takes it")),
        ("upright-dark-de", ("+24 bringt ein Fahrzeug anderswo", "ein Fahrzeug anderswo übernimmt")),
        ("phone-dark-es", ("+24 con un vehículo en otra parte", "la asume un vehículo en otra parte")),
    ],
)
def test_a_vehicle_elsewhere_is_words(
    house: OpenHouse,
    vehicles: dict[str, Puppet],
    enter: Enter,
    screenshot: Screenshot,
    look: str,
    said: tuple[str, str],
) -> None:
    stock = (BufferLevel(item="housing", level=11, capacity=72, reorder_point=20, on_order=24),)
    brought = TaskBrief("M8-1", 1, "housing", 24, "S3", STATION, LATER_S + 900.0, primary="ATV1")
    waiting = TaskBrief("M8-2", 1, "shaft", 40, "S3", STATION, LATER_S + 900.0, "ATV2", "ATV1")
    brief = Brief("M8-2", 1, MessageRole.PRIMARY, STATION, Phase.APPROACHING, "shaft", 40)

    async def work(inside: House) -> None:
        await Puppet.join(inside, "ATV1", 25.0, 35.0)
        tasks = (brought, waiting)
        inside.bus.say(machine_heartbeat(STATION, 2, at_s=LATER_S, buffers=stock, tasks=tasks))
        secondary = AwardAnswered("M8-2", 1, MessageRole.SECONDARY, "ATV1", "accepted")
        for event in events(STATION, opened("M8-2", work=SHAFTS), secondary):
            inside.bus.say(event)
        vehicles["ATV2"].beat(task=brief)

    house.do(work)
    house.do(ask_for_help(vehicles["ATV2"]))
    page = enter(**LOOKS[look])
    expect(page.locator(".stock")).to_contain_text(said[0])
    expect(card(page, "ATV2").locator(".hand-over")).to_contain_text(said[1])
    screenshot(page, f"operator-elsewhere-{look}")
    assert "*" not in page.locator("body").inner_text()


@pytest.mark.slow
@pytest.mark.parametrize("look", IN_EACH_LOOK)
def test_a_vehicle_is_taken_out_of_service_and_put_into_service_again(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot, look: str
) -> None:
    page = enter(**LOOKS[look])
    own = card(page, "ATV2")
    own.locator(".service-open").tap()
    choice = own.locator(".service")
    expect(choice.locator("button").nth(4)).to_be_disabled()
    choice.locator("button").nth(1).tap()
    screenshot(page, f"operator-take-out-{look}")
    choice.locator("button").nth(5).tap()
    back = own.locator(".service-back")
    expect(back).to_contain_text(WHO.title())
    screenshot(page, f"operator-out-of-service-{look}")
    checks = back.locator(".checks button")
    expect(back.locator("> button")).to_be_disabled()
    expect(checks.nth(1)).to_be_disabled()
    for check in checks.all():
        check.tap()
    press_and_hold(page, back.locator("> button"))
    expect(own.locator(".service-open")).to_have_count(1)
    taken, put = vehicles["ATV2"].heard
    assert (taken.kind, taken.wait_s, put.kind) == (CommandKind.TAKE_OUT, 8 * 3600.0, CommandKind.PUT_IN)
    assert taken.reason


# --- what can fail -----------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_refusal_is_told_with_the_vehicles_reason(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    house.do(beat(vehicles["ATV2"], status=AtvStatus.STOPPED, acknowledged=True))
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
    stop_of(page, "ATV2").tap()
    line = card(page, "ATV2").locator(".command")
    expect(line).to_contain_text("accepted")
    expect(line).to_contain_text("not confirmed")
    expect(line).to_contain_text("may or may not have heard")
    forgive(complaints, "status of 504")


def test_of_a_silent_vehicle_only_stop_is_left(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot
) -> None:
    house.do(beat(vehicles["ATV2"], at_s=-100.0))
    page = enter()
    silent = card(page, "ATV2")
    expect(silent).to_contain_text("Last heard")
    for step in silent.locator(".steps button").all():
        expect(step).to_be_disabled()
    screenshot(page, "operator-silent")
    stop_of(page, "ATV2").tap()
    expect(silent.locator(".command")).to_contain_text("confirmed by the vehicle")
    assert kinds(vehicles["ATV2"]) == [CommandKind.STOP]


@pytest.mark.slow
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
        await inside.access.watch.check()

    house.do(shift_ends)
    banner = page.get_by_role("alert")
    expect(banner).to_contain_text("Stop still works")
    expect(moved.get_by_role("button", name="At most 50")).to_be_disabled()
    stop_of(page, "ATV2").tap()
    expect(moved.locator(".command")).to_contain_text("confirmed by the vehicle")
    screenshot(page, "operator-session-ended")
    [stop] = vehicles["ATV2"].heard
    assert (stop.kind, stop.issued_by) == (CommandKind.STOP, WHO.title())
    banner.get_by_role("link", name="Log in").tap()
    expect(page.get_by_role("heading", name="Operator panel")).to_be_visible()
    forgive(complaints, "status of 401")


@pytest.mark.slow
def test_a_session_that_was_ended_leaves_for_the_login(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, complaints: Complaints
) -> None:
    page = enter()
    expect(card(page, "ATV2")).to_be_visible()
    page.get_by_role("button", name="Settings").tap()
    page.get_by_role("button", name="Log out").tap()
    expect(page).to_have_url(f"{house.url}/login?as=operator")
    complaints[:] = [each for each in complaints if "status of 401" not in each]  # to what was being asked


@pytest.mark.slow
def test_what_one_tab_commands_the_other_one_shows(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    first = enter()
    second = enter(beside=first)
    expect(card(second, "ATV2")).to_be_visible()
    stop_of(first, "ATV2").tap()
    line = card(second, "ATV2").locator(".command")
    expect(line).to_contain_text("Stop")
    expect(line).to_contain_text("confirmed by the vehicle")
    expect(card(second, "ATV2").get_by_role("button", name="Fault is gone")).to_be_enabled()


@pytest.mark.slow
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


@pytest.mark.slow
def test_stop_acknowledge_and_resume_are_reached_by_keyboard_alone(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    page = enter()
    expect(card(page, "ATV2")).to_be_visible()
    tab_to(page, "Stop ATV2")
    page.keyboard.press("Enter")
    expect(card(page, "ATV2").get_by_role("button", name="Fault is gone")).to_be_enabled()
    tab_to(page, "Fault is gone", back=True)
    page.keyboard.press("Space")
    expect(card(page, "ATV2").get_by_role("button", name="Resume")).to_be_enabled()
    tab_to(page, "Resume press and hold")
    page.evaluate(SHORT_PRESS, "Enter")
    page.wait_for_timeout(HOLD_MS)
    so_far = [CommandKind.STOP, CommandKind.ACKNOWLEDGE]
    assert kinds(vehicles["ATV2"]) == so_far, "a short press is not enough"
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
        if label.startswith(name):
            return
        page.keyboard.press("Shift+Tab" if back else "Tab")
    raise AssertionError(f"no way to {name} by keyboard")


def test_at_every_width_the_panel_names_its_place_and_is_fit_for_all(
    vehicles: dict[str, Puppet], enter: Enter
) -> None:
    page = enter(locale="es-ES")
    where = page.get_by_role("heading", level=1)
    expect(where).to_contain_text(STATION)
    expect(page.locator(".station .stock li")).not_to_have_count(0)
    for width in WIDTHS_PX:
        page.set_viewport_size({"width": width, "height": 768})
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), width
        assert where.evaluate("each => each.scrollWidth <= each.clientWidth"), width
        assert violations(page) == [], width

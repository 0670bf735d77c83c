"""The login in a real browser: by a link, by a password, by a PIN; with and without a script."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from databases import Files
from looks import LOCALES
from open_house import OpenHouse, open_house
from playwright.sync_api import Page, Route, expect
from scanner import scan
from variants import variants

from dray.gateway.access.login.cookies import PEOPLE
from dray.gateway.access.login.invitations import invite
from dray.gateway.access.principal import Role

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

DESK = {"width": 1280, "height": 800}
LYING, STANDING = {"width": 1024, "height": 768}, {"width": 800, "height": 1280}
"""A tablet at a station."""

LOOKS: dict[str, dict[str, Any]] = {
    "desk-light-en": {"viewport": DESK, "color_scheme": "light", "locale": "en-GB"},
    "desk-dark-de": {"viewport": DESK, "color_scheme": "dark", "locale": "de-DE"},
    "lying-dark-es": {"viewport": LYING, "color_scheme": "dark", "locale": "es-ES", "has_touch": True},
    "standing-light-de": {
        "viewport": STANDING,
        "color_scheme": "light",
        "locale": "de-DE",
        "has_touch": True,
    },
}

PASSWORD, PIN, BADGE = "four words are good", "402719", "04a2b9c1d2e380"

REFUSED = re.compile("status of 4(01|10|29)")
"""What Chromium says of every page that it shows with such a status."""


@pytest.fixture(scope="module")
def plant(files: Files, tmp_path_factory: pytest.TempPathFactory) -> Iterator[OpenHouse]:
    with open_house(files.new(tmp_path_factory.mktemp("login"))) as house:
        house.do(lambda inside: inside.know("boss"))
        house.do(lambda inside: inside.know("ana", Role.OPERATOR, "AREA1"))
        house.do(give_badge)
        yield house


async def give_badge(house: Any) -> None:
    chief = await house.log_in("chief")
    badge = {"kind": "badge", "secret": BADGE}
    assert (await chief.put("/api/people/ana/secret", json=badge)).status_code == 200


def link_for(plant: OpenHouse, person: str) -> str:
    async def make(house: Any) -> str:
        async with house.store.write() as work:
            return str(await invite(work, person, house.wall.now_s))

    return f"{plant.url}/login/{plant.do(make)}"


def cookies(page: Page) -> dict[str, Any]:
    return {cookie["name"]: cookie for cookie in page.context.cookies()}


def fits(page: Page) -> bool:
    """Whether nothing has to be scrolled sideways."""
    return bool(page.evaluate("document.documentElement.scrollWidth <= innerWidth"))


@pytest.mark.parametrize("look", variants(LOOKS, "desk-dark-de", "lying-dark-es"))
@pytest.mark.parametrize("role", ["manager", "operator"])
def test_the_login_fits_every_screen_in_every_language(
    plant: OpenHouse, open_page: OpenPage, screenshot: Screenshot, look: str, role: str
) -> None:
    page = open_page(f"{plant.url}/login?as={role}", **LOOKS[look])
    expect(page.get_by_role("heading", level=1)).to_be_visible()
    assert fits(page)
    screenshot(page, f"login-{role}-{look}")


HINT_FITS = """input => {
    const style = getComputedStyle(input, "::placeholder"), pen = document.createElement("canvas").getContext("2d");
    pen.font = `${style.fontWeight} ${style.fontSize} ${style.fontFamily}`;
    const own = getComputedStyle(input);
    const room = input.clientWidth - parseFloat(own.paddingLeft) - parseFloat(own.paddingRight);
    return pen.measureText(input.placeholder).width <= room;
}"""


@pytest.mark.parametrize("locale", ["en-GB", "de-DE", "es-ES"])
def test_on_a_narrow_telephone_the_hint_for_the_badge_is_whole(
    plant: OpenHouse, open_page: OpenPage, locale: str
) -> None:
    page = open_page(f"{plant.url}/login?as=operator", viewport={"width": 360, "height": 740}, locale=locale)
    page.evaluate("document.fonts.ready")
    assert fits(page)
    assert page.locator("#badge").evaluate(HINT_FITS)


@pytest.mark.parametrize("script", [True, False])
def test_a_manager_logs_in_by_password_and_goes_on_where_he_wanted_to(
    plant: OpenHouse, open_page: OpenPage, script: bool
) -> None:
    page = open_page(f"{plant.url}/?x=1", java_script_enabled=script)
    assert page.url == f"{plant.url}/login?next=%2F%3Fx%3D1"
    page.get_by_label("Name").fill("boss")
    page.get_by_label("Password").fill(PASSWORD)
    page.get_by_role("button", name="Log in").click()
    page.wait_for_url(f"{plant.url}/?x=1")
    cookie = cookies(page)["dray_session"]
    assert cookie["httpOnly"]
    assert cookie["sameSite"] == "Strict"
    if script:
        assert "dray_session" not in page.evaluate("document.cookie")


@pytest.mark.parametrize("script", [True, False])
def test_an_operator_logs_in_by_pin_says_where_and_is_known_the_next_time(
    plant: OpenHouse, open_page: OpenPage, screenshot: Screenshot, complaints: Any, script: bool
) -> None:
    page = open_page(f"{plant.url}/login?as=operator", java_script_enabled=script, **LOOKS["lying-dark-es"])
    page.get_by_label("Nombre").fill("ana")
    page.locator("#secret").fill(PIN)
    page.get_by_role("button", name="Entrar").click()
    expect(page.get_by_role("heading", level=1)).to_have_text("¿Dónde trabaja ahora?")
    if script:
        screenshot(page, "login-station")
    page.get_by_role("button", name="M2").click()
    page.wait_for_url(f"{plant.url}/operator")
    page.context.clear_cookies(name="dray_session")
    page.goto(f"{plant.url}/login?as=operator")
    expect(page.get_by_role("radio", name="ana")).to_be_checked()
    if script:
        expect(page.get_by_label("Nombre")).to_be_hidden()
        screenshot(page, "login-known")
    page.locator("#secret").fill(PIN)
    page.get_by_role("button", name="Entrar").click()
    page.wait_for_url(f"{plant.url}/operator")
    # What the operator's panel complains of when it is left so soon is another test's matter.
    page.goto("about:blank")
    complaints.clear()


def test_a_link_logs_in_by_one_button_and_once(
    plant: OpenHouse, open_page: OpenPage, screenshot: Screenshot
) -> None:
    link = link_for(plant, "boss")
    page = open_page(link)
    expect(page.get_by_role("heading", level=1)).to_have_text("Hello, Boss")
    screenshot(page, "login-link")
    page.get_by_role("button", name="Log in").click()
    page.wait_for_url(f"{plant.url}/")


def test_a_link_that_was_used_says_so(
    plant: OpenHouse, open_page: OpenPage, screenshot: Screenshot, complaints: Any
) -> None:
    page = open_page(f"{plant.url}/login/guess")
    expect(page.get_by_role("heading", level=1)).to_have_text("This link does not log in any more")
    screenshot(page, "login-gone")
    complaints[:] = [each for each in complaints if not REFUSED.search(each)]


def test_a_wrong_secret_is_said_beside_the_form_and_the_name_stays(
    plant: OpenHouse, open_page: OpenPage, screenshot: Screenshot, complaints: Any
) -> None:
    page = open_page(f"{plant.url}/login")
    page.get_by_label("Name").fill("boss")
    page.get_by_label("Password").fill("not this one")
    page.get_by_role("button", name="Log in").click()
    expect(page.get_by_role("alert")).to_contain_text("name or password")
    expect(page.get_by_label("Name")).to_have_value("boss")
    expect(page.get_by_label("Password")).to_have_value("")
    expect(page.get_by_label("Password")).to_be_focused()
    screenshot(page, "login-wrong")
    complaints[:] = [each for each in complaints if not REFUSED.search(each)]


def test_a_name_that_was_typed_before_the_script_came_stays(plant: OpenHouse, open_page: OpenPage) -> None:
    page = open_page("about:blank", has_touch=True)
    page.context.add_cookies([{"name": PEOPLE, "value": "ana", "url": plant.url}])
    held: list[Route] = []

    def hold(route: Route) -> None:
        held.append(route)

    page.route("**/main-*.js", hold)
    page.goto(f"{plant.url}/login?as=operator", wait_until="commit")
    expect(page.get_by_role("radio", name="ana")).to_be_checked()
    page.get_by_label("Name").fill("ben")
    held.pop().continue_()
    expect(page.get_by_role("button", name="7", exact=True)).to_be_visible()
    expect(page.get_by_label("Name")).to_have_value("ben")
    expect(page.get_by_role("radio", name="Somebody else")).to_be_checked()


@pytest.mark.parametrize("focused", ["main", "#secret", '[name="known"]', ".pad button"])
def test_a_badge_that_is_held_to_its_reader_logs_in_wherever_the_focus_is(
    plant: OpenHouse, open_page: OpenPage, focused: str
) -> None:
    page = open_page(f"{plant.url}/login?as=operator", **LOOKS["lying-dark-es"])
    page.context.add_cookies([{"name": "dray_people", "value": "ana", "url": plant.url}])
    page.reload()
    page.locator(focused).first.focus()
    scan(page, BADGE)
    expect(page.get_by_role("heading", level=1)).to_have_text("¿Dónde trabaja ahora?")


@pytest.mark.parametrize(
    ("language", "said"),
    [
        ("en", ("name or PIN", "badge does not")),
        ("de", ("Name oder PIN", "Ausweis passt nicht")),
        ("es", ("nombre o el PIN", "tarjeta no da acceso")),
    ],
)
def test_a_wrong_pin_is_typed_again_and_a_wrong_badge_held_again(
    plant: OpenHouse,
    open_page: OpenPage,
    screenshot: Screenshot,
    complaints: Any,
    language: str,
    said: tuple[str, str],
) -> None:
    page = open_page(
        f"{plant.url}/login?as=operator", locale=LOCALES[language], has_touch=True, viewport=STANDING
    )
    page.locator("#name").fill("operator-south")
    page.locator("#secret").fill("111111")
    page.locator(".go").click()
    expect(page.get_by_role("alert")).to_contain_text(said[0])
    expect(page.locator("#name")).to_have_value("operator-south")
    expect(page.locator("#secret")).to_be_focused()
    screenshot(page, f"login-wrong-pin-{language}")
    page.locator("#badge").fill("unknown-badge")
    page.keyboard.press("Enter")
    expect(page.get_by_role("alert")).to_contain_text(said[1])
    expect(page.locator("#badge")).to_be_focused()
    complaints[:] = [each for each in complaints if not REFUSED.search(each)]

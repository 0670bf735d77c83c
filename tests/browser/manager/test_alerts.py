"""Alerts in the tab's title, with a sound and a notification, taken on until some moment, and found in their history."""

from __future__ import annotations

import asyncio
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from looks import CUT, LOCALES, WIDTHS_PX, in_every_look
from manager_kit import BEAT_S, GoingWall, as_manager
from open_house import OpenHouse, open_house
from playwright.sync_api import Locator, Page, expect

from dray.gateway.live.views import AlertView
from dray.messages import MachineStatus

from gateway_kit import House  # isort: skip - their folder is on the path since `manager_kit` is
from heartbeats import machine_heartbeat  # isort: skip
from wall_clock import NOW_S  # isort: skip

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

HEARD = """
window.told = [];
window.Notification = class {
  static permission = "%s";
  static async requestPermission() { window.asked = (window.asked ?? 0) + 1; return this.permission = "%s"; }
  constructor(title, more) {
    window.told.push([title, more.body]);
    document.documentElement.dataset.told = window.told.length;
  }
  close() {}
};
"""
"""Notifications that are noted and not shown: what they may at first, and what the person answers."""


@dataclass
class Machines:
    """Machines that say how they are, as machines do."""

    house: House
    state: dict[str, dict[str, Any]] = field(default_factory=dict)
    telling: asyncio.Task[None] | None = None
    beats: int = 0

    @classmethod
    async def join(cls, house: House) -> Machines:
        machines = cls(house, {"M5": {}, "M8": {}})
        machines.telling = asyncio.create_task(machines.tell())
        return machines

    async def tell(self) -> None:
        """Say how things are, until the house is closed."""
        while True:
            self.beat()
            await asyncio.sleep(BEAT_S)

    def beat(self) -> None:
        self.beats += 1
        for machine, state in self.state.items():
            at_s = self.house.wall() - NOW_S
            self.house.bus.say(machine_heartbeat(machine, self.beats, at_s=at_s, **state))

    async def fail(self, machine: str) -> None:
        self.state[machine] = {"status": MachineStatus.ERROR, "problem": "spindle"}
        self.beat()

    async def mend(self, machine: str) -> None:
        self.state[machine] = {}
        self.beat()


@pytest.fixture
def house(sqlite_url: str) -> Iterator[OpenHouse]:
    with open_house(sqlite_url, wall=GoingWall()) as house:
        yield house


@pytest.fixture
def machines(house: OpenHouse) -> Machines:
    return house.do(Machines.join)


def close(page: Page, closure: dict[str, str]) -> None:
    """As a program of this person's browser would."""
    page.evaluate(
        """async body => {
            const headers = {"Content-Type": "application/json"};
            const answer = await fetch("/api/closures", {method: "POST", headers, body: JSON.stringify(body)});
            if (!answer.ok) throw new Error(await answer.text());
        }""",
        closure,
    )


TAKE = """async alert => {
    const headers = {"Content-Type": "application/json"};
    const answer = await fetch(`/api/alerts/${alert}/acknowledge`, {method: "POST", headers, body: "{}"});
    if (!answer.ok) throw new Error(await answer.text());
}"""
"""Somebody takes an alert on, elsewhere."""


async def alerts_of(house: House) -> Sequence[AlertView]:
    return house.projection.alerts.views()


def log_of(page: Page, name: str = "All alerts so far") -> Locator:
    return page.get_by_role("region", name=name)


def test_the_tab_tells_how_much_asks_for_an_answer(
    house: OpenHouse, machines: Machines, open_page: OpenPage
) -> None:
    page = as_manager(house, open_page)
    icon = page.locator("link[rel=icon]")
    expect(page).to_have_title(re.compile(r"^Dray"))
    house.do(lambda _: machines.fail("M8"))
    expect(page).to_have_title(re.compile(r"^\(1\) "))
    expect(icon).to_have_attribute("href", "/static/icon-alarm.svg")
    house.do(lambda _: machines.fail("M5"))
    expect(page).to_have_title(re.compile(r"^\(2\) "))
    page.locator(".inbox").get_by_role("button", name=re.compile("^Take: M8")).click()
    expect(page).to_have_title(re.compile(r"^\(1\) "))
    house.do(lambda _: machines.mend("M5"))
    expect(page).to_have_title(re.compile(r"^Dray"))
    expect(icon).to_have_attribute("href", "/static/icon.svg")


def test_a_sheet_stays_open_with_what_is_typed_when_rows_change_their_order(
    house: OpenHouse, machines: Machines, open_page: OpenPage
) -> None:
    house.do(lambda _: machines.fail("M8"))
    page = as_manager(house, open_page)
    page.evaluate("location.hash = '#alerts'")
    table = page.locator("main > section").first
    table.get_by_role("row", name="Show M8").locator("[popovertarget]").click()
    said = page.locator("form.say-alert").get_by_role("textbox")
    said.fill("the chuck is stuck")
    house.do(lambda _: machines.fail("M5"))
    rows = table.get_by_role("row", name="Show M")
    expect(rows).to_have_text([re.compile("M5"), re.compile("M8")])
    expect(said).to_have_value("the chuck is stuck")
    expect(said).to_be_focused()
    # Somebody takes it on: it goes below.
    alert = next(each.id for each in house.do(alerts_of) if each.agent == "M5")
    page.evaluate(TAKE, alert)
    expect(rows).to_have_text([re.compile("M8"), re.compile("M5")])
    expect(said).to_be_visible()
    expect(said).to_have_value("the chuck is stuck")
    house.do(lambda _: machines.mend("M5"))
    expect(rows).to_have_text([re.compile("M8")])
    house.do(lambda _: machines.fail("M5"))
    expect(rows).to_have_text([re.compile("M5"), re.compile("M8")])
    expect(said).to_be_visible()


def test_what_somebody_has_taken_is_counted_until_it_ends_and_lately_tells_what_people_did(
    house: OpenHouse, machines: Machines, open_page: OpenPage, screenshot: Screenshot
) -> None:
    house.do(lambda _: machines.fail("M8"))
    page = as_manager(house, open_page)
    tag = page.locator(".alerts-button")
    expect(tag).to_have_text("1 alarm")
    page.locator(".inbox").get_by_role("button", name=re.compile("^Take: M8")).click()
    expect(tag).to_have_text("1 alarm, taken")
    close(page, {"kind": "closed", "place": "M5", "reason": "oil on the floor"})
    tag.click()
    lately = page.locator(".card.news")
    expect(lately).to_contain_text("M5 closed. oil on the floor")
    page.get_by_role("link", name="Plant", exact=True).click()
    page.get_by_role("button", name="Open M5").click()
    tag.click()
    expect(lately).to_contain_text("M5 is open again")
    screenshot(page, "alarm-taken")
    house.do(lambda _: machines.mend("M8"))
    expect(tag).to_have_text("No alarms")
    expect(log_of(page)).to_contain_text("spindle")


@pytest.mark.parametrize("size", [{"width": 1280, "height": 800}, {"width": 1440, "height": 900}])
def test_an_alarm_and_a_closure_move_no_button_and_are_in_sight(
    house: OpenHouse,
    machines: Machines,
    open_page: OpenPage,
    screenshot: Screenshot,
    size: dict[str, int],
) -> None:
    page = as_manager(house, open_page, viewport=size)
    names = ("Publish", "Define", "Close lanes…", "Pause an area…")
    buttons = [page.get_by_role("button", name=name, exact=True) for name in names]
    for button in buttons:
        expect(button).to_be_visible()
    before = [button.bounding_box() for button in buttons]
    house.do(lambda _: machines.fail("M8"))
    take = page.locator(".inbox").get_by_role("button", name=re.compile("^Take: M8"))
    expect(take).to_be_in_viewport(ratio=1.0)
    assert [button.bounding_box() for button in buttons] == before
    assert page.locator(".factory").evaluate(CUT) == []
    close(page, {"kind": "closed", "place": "M5", "reason": "oil on the floor"})
    expect(page.get_by_role("button", name="Open M5")).to_be_visible()
    assert [button.bounding_box() for button in buttons] == before
    screenshot(page, f"alarm-fixed-places-{size['width']}")


@pytest.mark.parametrize("size", [{"width": 1280, "height": 800}, {"width": 1440, "height": 900}])
def test_what_is_closed_is_in_sight_with_the_way_to_open_it(
    house: OpenHouse, open_page: OpenPage, screenshot: Screenshot, size: dict[str, int]
) -> None:
    page = as_manager(house, open_page, viewport=size)
    expect(page.get_by_role("button", name="Publish", exact=True)).to_be_visible()
    close(page, {"kind": "closed", "place": "M5", "reason": "oil on the floor"})
    expect(page.get_by_role("button", name="Open M5")).to_be_in_viewport(ratio=1.0)
    assert page.locator(".factory").evaluate(CUT) == []
    screenshot(page, f"closure-in-sight-{size['width']}")


@pytest.mark.parametrize("language", LOCALES)
def test_the_top_bar_is_as_high_with_an_alarm_that_is_open_taken_and_over(
    house: OpenHouse, machines: Machines, open_page: OpenPage, screenshot: Screenshot, language: str
) -> None:
    page = as_manager(house, open_page, locale=LOCALES[language])
    top, tag = page.locator("header.top"), page.locator(".alerts-button .tag")
    expect(page.locator(".live-age")).not_to_be_empty()
    # In another font the line may be two.
    page.evaluate("document.fonts.ready.then(() => true)")
    before = top.bounding_box()
    house.do(lambda _: machines.fail("M8"))
    expect(tag).to_have_class(re.compile("tag-alarm"))
    assert top.bounding_box() == before
    page.locator(".inbox .take").click()
    expect(tag).to_have_class("tag")
    expect(tag).to_contain_text("1")
    screenshot(page, f"alarm-taken-{language}")
    assert top.bounding_box() == before


def test_an_alert_is_put_aside_with_a_comment_asks_again_and_is_found_in_the_history(
    house: OpenHouse, machines: Machines, open_page: OpenPage, screenshot: Screenshot
) -> None:
    house.do(lambda _: machines.fail("M8"))
    page = as_manager(house, open_page)
    page.locator(".alerts-button").click()
    row = page.locator("main > section").first.get_by_role("row").filter(has_text="M8")
    row.get_by_role("button", name="With a comment…").click()
    form = page.get_by_role("form", name=re.compile("^Take with a comment: M8"))
    expect(form.get_by_label("Comment")).to_be_focused()
    page.keyboard.type("fitter comes at two")
    form.get_by_label("Ask again").select_option("in 15 minutes")
    screenshot(page, "alert-with-comment")
    page.keyboard.press("Tab")
    form.get_by_role("button", name="Take").click()
    expect(row).to_contain_text("until")
    expect(row).to_contain_text("fitter comes at two")
    expect(log_of(page)).to_contain_text(re.compile(r"took it until .*fitter comes at two"))

    async def later(inside: House) -> None:
        inside.wall.now_s += 901
        machines.beat()

    house.do(later)
    expect(row).to_contain_text("Asks again: the time is over")
    expect(row.get_by_role("button", name=re.compile("^Take: M8"))).to_be_visible()
    house.do(lambda _: machines.mend("M8"))
    expect(page.locator("main > section").first).to_contain_text("Nothing needs an answer.")
    expect(log_of(page)).to_contain_text("asked again: the time was over")
    log = log_of(page)
    log.get_by_role("searchbox").fill("fitter")
    expect(page).to_have_url(re.compile(r"#alerts\?q=fitter"))
    expect(log.locator("tbody tr")).to_have_count(1)
    log.get_by_role("searchbox").fill("nobody said that")
    expect(log).to_contain_text("Nothing fits.")
    log.get_by_role("searchbox").fill("")
    expect(log.locator("tbody tr")).to_have_count(1)
    assert "format=csv" in (log_of(page).get_by_role("link", name="CSV").get_attribute("href") or "")


def test_new_alarms_are_told_where_somebody_asked_for_it_and_no_old_ones(
    house: OpenHouse, machines: Machines, open_page: OpenPage
) -> None:
    house.do(lambda _: machines.fail("M5"))
    page = as_manager(house, open_page)
    page.add_init_script(HEARD % ("default", "granted"))
    page.reload()
    expect(page).to_have_title(re.compile(r"^\(1\) "))
    assert page.evaluate("window.asked ?? 0") == 0, "nothing is asked without a click"
    page.locator(".person").click()
    notice = page.get_by_label("With a notification")
    expect(notice).not_to_be_checked()
    notice.check()
    expect(notice).to_be_checked()
    page.keyboard.press("Escape")
    house.do(lambda _: machines.fail("M8"))
    expect(page).to_have_title(re.compile(r"^\(2\) "))
    expect(page.locator("html")).to_have_attribute("data-told", "1")
    assert page.evaluate("window.told") == [["M8: Stopped by a fault: spindle", "Have it repaired"]]
    assert page.evaluate("window.asked") == 1


@pytest.mark.parametrize(
    ("answer", "says"),
    [("denied", "The browser refuses notifications"), ("default", "it asks once more")],
)
def test_a_browser_that_refuses_is_told_of_plainly(
    house: OpenHouse, machines: Machines, open_page: OpenPage, screenshot: Screenshot, answer: str, says: str
) -> None:
    page = as_manager(house, open_page)
    page.add_init_script(HEARD % ("default", answer))
    page.reload()
    page.locator(".person").click()
    notice = page.get_by_label("With a notification")
    notice.click()
    expect(page.locator(".telling")).to_contain_text(says)
    expect(notice).not_to_be_checked()
    screenshot(page, f"telling-{answer}")


def test_a_sound_is_played_for_a_new_alarm(house: OpenHouse, machines: Machines, open_page: OpenPage) -> None:
    page = as_manager(house, open_page)
    page.add_init_script("""
        window.tones = 0;
        const start = OscillatorNode.prototype.start;
        OscillatorNode.prototype.start = function (...at) { document.documentElement.dataset.tones = ++window.tones; return start.apply(this, at); };
    """)
    page.reload()
    page.locator(".person").click()
    page.get_by_label("With a sound").check()
    expect(page.locator("html")).to_have_attribute("data-tones", "2")
    page.keyboard.press("Escape")
    house.do(lambda _: machines.fail("M8"))
    expect(page.locator("html")).to_have_attribute("data-tones", "4")


def test_choosing_an_alert_selects_its_whole_story(
    house: OpenHouse, machines: Machines, open_page: OpenPage
) -> None:
    house.do(lambda _: machines.fail("M8"))
    page = as_manager(house, open_page)
    page.locator(".alerts-button").click()
    page.get_by_role("button", name="Show M8").click()
    expect(page).to_have_url(re.compile(r"#plant\?at=machine%3AM8$"))
    story = page.get_by_role("region", name="What is chosen")
    expect(story.get_by_role("button", name="M8", exact=True)).to_be_visible()
    expect(page.locator(".column.right").get_by_role("region", name=re.compile(r"^M8\b"))).to_be_visible()


@in_every_look
def test_the_page_of_alerts_in_every_look(
    house: OpenHouse,
    machines: Machines,
    open_page: OpenPage,
    screenshot: Screenshot,
    language: str,
    theme: str,
) -> None:
    for machine in ("M5", "M8"):
        house.do(lambda _, machine=machine: machines.fail(machine))
    house.until(lambda inside: len(inside.projection.alerts.views()) == 2)
    house.do(
        lambda inside: inside.alerts.acknowledge("machine_error-M5", "Early shift", "spindle is ordered")
    )
    page = as_manager(house, open_page, locale=LOCALES[language], color_scheme=theme)
    page.locator(".alerts-button").click()
    expect(page.locator("main table")).to_have_count(2)
    for width_px in WIDTHS_PX:
        page.set_viewport_size({"width": width_px, "height": 900})
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), width_px
        screenshot(page, f"alerts-{language}-{theme}-{width_px}")

"""A jam before a dock: on the map, in words on both panels, as one alert that names its cause, and gone when it is gone."""

from __future__ import annotations

import asyncio
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from drawn_words import overlapping, watch_words, words_of
from manager_kit import BEAT_S, GoingWall, as_manager, choose
from msgspec.structs import replace
from open_house import OpenHouse, open_house
from playwright.sync_api import Page, expect
from puppets import Puppet
from tablet_kit import LOOKS, Enter, card
from variants import variants

from dray.gateway.live.projection.alerting.wait_rules import LONG_WAIT_S, UNHEARD_S
from dray.messages import AtvStatus, Brief, Phase, Role
from dray.messages.heartbeat import FloorBrief
from dray.plant import load_plant

from gateway_kit import House  # isort: skip - their folder is on the path since `puppets` is
from wall_clock import NOW_S  # isort: skip

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

PLANT = load_plant("single-track")

QUEUE = {
    "ATV7": ("m8", (), ("m8-lane", "m8"), ""),
    "ATV3": ("c2", ("m8-lane", "m8"), ("c2",), "ATV7"),
    "ATV5": ("m7-lane", ("c2", "m8-lane", "m8"), ("m7-lane",), "ATV3"),
    "ATV2": ("c3", ("c2", "d2"), ("c3",), "ATV3"),
}
"""Each vehicle's node, the way before it, what it holds, and for whom it waits; the first one is at the dock of M8."""

LONG = re.compile(r"\b[2-9]:\d\d")
"""Two minutes and more: the clock goes on while a slow browser draws."""

SENTENCE = "ATV5 waits for ATV3, which waits for ATV7 at the dock of M8"


TYPE_AT_ONCE = """async (button, text) => {
    const sheet = document.getElementById(button.getAttribute("popovertarget"));
    const opened = new Promise((told) => sheet.addEventListener("toggle", told, { once: true }));
    button.click();
    const field = sheet.querySelector("input");
    field.value = text;
    field.dispatchEvent(new Event("input", { bubbles: true }));
    await opened;
}"""
"""Opens a sheet and types on it before the page has told of the opening: what was typed is to stay."""


@dataclass
class Jam:
    """Vehicles that stand one behind the other, and say so as vehicles do."""

    house: House
    vehicles: dict[str, Puppet] = field(default_factory=dict)
    telling: asyncio.Task[None] | None = None

    @classmethod
    async def form(cls, house: House) -> Jam:
        jam = cls(house)
        work = Brief("M8-1", 1, Role.PRIMARY, "M8", Phase.CARRYING, "shaft", 8)
        for atv, (node, way, holds, behind) in QUEUE.items():
            spot, needs = PLANT.nodes[node], way[0] if way else ""
            floor = FloorBrief(holds, docked=not way, waits=bool(way), waits_for=behind, waits_at=needs)
            state = {"node": node, "way": way, "floor": floor, "task": work, "status": AtvStatus.WORKING}
            state |= {"load": "shaft", "load_quantity": 8, "at_s": jam.now_s}
            jam.vehicles[atv] = await Puppet.join(house, atv, spot.x_m, spot.y_m, **state)
        jam.telling = asyncio.create_task(jam.tell())
        return jam

    @property
    def now_s(self) -> float:
        """The plant's clock."""
        return self.house.wall() - NOW_S

    async def tell(self) -> None:
        """Say how things are, until the house is closed."""
        while True:
            self.beat()
            await asyncio.sleep(BEAT_S)

    def beat(self) -> None:
        for puppet in self.vehicles.values():
            puppet.beat(at_s=self.now_s)

    async def last(self, wait_s: float) -> None:
        """All have stood there for so much longer."""
        self.house.wall.now_s += wait_s
        self.beat()

    async def clear(self) -> None:
        """The one at the dock has left, and the others follow it."""
        for puppet in self.vehicles.values():
            puppet.state |= {"floor": FloorBrief((puppet.state["node"],), stands=False), "speed_mps": 1.0}
        self.beat()


@pytest.fixture
def house(sqlite_url: str) -> Iterator[OpenHouse]:
    with open_house(sqlite_url, wall=GoingWall()) as house:
        yield house


@pytest.fixture
def jam(house: OpenHouse) -> Jam:
    return house.do(Jam.form)


def after(house: OpenHouse, jam: Jam, wait_s: float) -> None:
    house.do(lambda _: jam.last(wait_s))


def picture(page: Page) -> bytes:
    """What moves on the map, and what lies under it there."""
    return page.locator("#plant-map").screenshot()


@pytest.mark.parametrize("scheme", variants(["dark", "light"]))
def test_a_jam_is_one_alert_a_sentence_and_a_place_on_the_map_until_it_is_gone(
    house: OpenHouse, jam: Jam, open_page: OpenPage, screenshot: Screenshot, scheme: str
) -> None:
    page = as_manager(house, open_page, before=watch_words, color_scheme=scheme)
    layer = page.get_by_role("button", name="Right of way")
    expect(layer).to_have_attribute("aria-pressed", "true")
    choose(page, "ATV5")
    note = page.locator(".card.atv .wait-note")
    expect(note.locator("p")).to_have_text(SENTENCE)
    expect(note.get_by_role("listitem")).to_have_count(3)
    expect(page.locator(".inbox")).to_have_count(0)

    after(house, jam, LONG_WAIT_S)
    inbox = page.locator(".inbox")
    expect(inbox.get_by_role("listitem")).to_have_count(1)
    expect(inbox).to_contain_text(
        re.compile(r"Jam: 3 vehicles \(ATV3, ATV5, ATV2\) wait for ATV7 at the dock of M8")
    )
    expect(note.get_by_role("listitem").first).to_contain_text(LONG)
    screenshot(page, f"jam-{scheme}")
    words = words_of(page)
    assert any(word.text.startswith("Jam ") for word in words)
    assert overlapping(words) == []
    shown = picture(page)
    layer.click()
    expect(layer).to_have_attribute("aria-pressed", "false")
    assert picture(page) != shown, "the layer is what shows it"
    layer.click()
    inbox.get_by_role("button", name="Show ATV7").click()
    expect(page.locator(".card.atv h2")).to_contain_text("ATV7")
    choose(page, "ATV5")

    house.do(lambda _: jam.clear())
    expect(note).to_have_count(0)
    expect(inbox).to_have_count(0)


def test_whoever_holds_places_and_was_never_heard_is_shut_out_and_carried_away_where_that_is_told(
    house: OpenHouse, jam: Jam, open_page: OpenPage, screenshot: Screenshot
) -> None:
    async def behind_a_stranger(_: House) -> None:
        waits = jam.vehicles["ATV3"].state
        waits["floor"] = replace(waits["floor"], waits_for="GHOST")
        del jam.vehicles["ATV7"]
        jam.beat()
        await jam.last(UNHEARD_S + 1.0)

    house.do(behind_a_stranger)
    page = as_manager(house, open_page)
    page.evaluate("location.hash = '#alerts'")
    row = page.get_by_role("row", name="Show GHOST")
    expect(row).to_contain_text("Holds places, and was never heard; waiting for it: ATV3")
    screenshot(page, "unheard")
    row.get_by_role("button", name="GHOST is off the floor").click()
    row.get_by_role("button", name="It is off the floor").click()
    expect(row.get_by_role("status")).to_contain_text("Told to all")
    form = page.locator("form.shut-out")
    row.get_by_role("button", name="Shut out").evaluate(
        TYPE_AT_ONCE, "holds places, and is no vehicle of ours"
    )
    expect(form.get_by_role("textbox")).to_be_focused()
    form.get_by_role("button", name="Shut GHOST out").click()
    expect(form).to_be_hidden()

    async def shut_out(inside: House) -> list[str]:
        return [each["agent"] for each in (await inside.get("/api/agents/shut-out"))["items"]]

    assert house.do(shut_out) == ["GHOST"]


@pytest.mark.slow
@pytest.mark.parametrize("look", variants(LOOKS, "upright-dark-de"))
def test_an_operator_reads_for_whom_the_vehicles_of_the_area_wait(
    enter: Enter, house: OpenHouse, jam: Jam, screenshot: Screenshot, look: str
) -> None:
    page = enter(**LOOKS[look])
    after(house, jam, LONG_WAIT_S)
    waits = card(page, "ATV5").locator(".waits")
    words = {
        "en": "waits for ATV3, which waits for ATV7",
        "de": "wartet auf ATV3; dieses wartet auf ATV7",
        "es": "espera a ATV3, que espera a ATV7",
    }
    expect(waits).to_contain_text(words[look[-2:]])
    expect(waits).to_contain_text(LONG)
    expect(card(page, "ATV2")).to_have_count(0)
    expect(card(page, "ATV7").locator(".waits")).to_have_count(0)
    assert "ATV2" not in page.content(), "it stands outside of the area"
    screenshot(page, f"jam-tablet-{look}")
    house.do(lambda _: jam.clear())
    expect(waits).to_have_count(0)


@pytest.mark.slow
def test_without_right_of_way_nothing_of_it_is_there(house: OpenHouse, open_page: OpenPage) -> None:
    async def one(inside: House) -> None:
        await Puppet.join(inside, "ATV1", 7.0, 5.0, node="a1", at_s=inside.wall() - NOW_S)

    house.do(one)
    page = as_manager(house, open_page)
    choose(page, "ATV1")
    expect(page.locator(".card.atv h2")).to_contain_text("ATV1")
    expect(page.get_by_role("button", name="Areas")).to_be_visible()
    expect(page.get_by_role("button", name="Right of way")).to_have_count(0)
    expect(page.locator(".wait-note")).to_have_count(0)

"""Doors before a manager: how they stand on the map as vehicles tell, one that does not open in words, and their sheets in the editor."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from manager_kit import PAD_PX, as_manager
from msgspec import UNSET
from msgspec.structs import replace
from open_house import OpenHouse, open_house
from playwright.sync_api import Page, expect
from playwright.sync_api import TimeoutError as NeverShown
from puppets import LATER_S, Puppet
from variants import variants

from dray.messages import AtvStatus, HelpWanted, ObstacleSeen, Problem, ProblemKind
from dray.plant import Door, LaneEnds, load_plant

from gateway_kit import House  # isort: skip - their folder is on the path since `puppets` is
from fake_bus import KEYS  # isort: skip

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

GATE = Door("GATE", "Hall gate", (LaneEnds("c2", "c3"),), 8.0)
PLANT = replace(load_plant("single-track").file, doors=(GATE,))

X_M, LOW_M, HIGH_M = 27.0, 13.0, 20.0
"""The lane of the door, from c2 up to c3."""

SIZE = {"width": 1600, "height": 1200}
"""On a smaller map a vehicle's name lies on the door before which it stands."""

HALF_M, LEAST_PX = 0.8, 8.0
"""Half of a door on the map (`frontend/src/plant/doors/doors.ts`)."""

LOOKS = {
    "shut": ("ink", "ink", "ink"),
    "opening": ("", "warn", "warn"),
    "open": ("", "", "ink"),
    "failed": ("", "alarm", "alarm"),
}
"""The colours of a door in its middle, where an opening one has gone apart, and at its end; "" for any other, or none."""

LOOK_MS = 100
"""From look to look: sixty a second would leave a busy computer little time to draw."""

LOOK = """([plant, pad, door, look]) => {
    const canvas = [...document.querySelectorAll("#plant-map canvas")].at(-1);
    if (!canvas) return {fits: false, seen: "no map"};
    // Measured at every look: a card that comes meanwhile, or a font, makes the map another size.
    const box = canvas.getBoundingClientRect();
    const [width, height] = [box.width - pad.left - pad.right, box.height - pad.top - pad.bottom];
    const scale = Math.min(width / plant.width, height / plant.height);
    const x = box.left + pad.left + (width - plant.width * scale) / 2 + door.x * scale;
    const y = box.top + pad.top + (height + plant.height * scale) / 2 - door.y * scale;
    const half = Math.max(door.least, door.half * scale);
    const pixel = () => document.createElement("canvas").getContext("2d", {willReadFrequently: true});
    const [told, shown] = [pixel(), pixel()];
    const first = (context) => [...context.getImageData(0, 0, 1, 1).data];
    const rgb = (token) => {
        told.fillStyle = getComputedStyle(document.documentElement).getPropertyValue(`--${token}`).trim();
        told.fillRect(0, 0, 1, 1);
        return first(told);
    };
    const ratio = canvas.width / box.width;
    const seen = [0, 0.45, 0.85].map((part) => {
        const [px, py] = [Math.floor((x + half * part - box.left) * ratio), Math.floor((y - box.top) * ratio)];
        shown.clearRect(0, 0, 1, 1);
        // One pixel: a copy of the whole map at every look takes a page's time from all that it should show.
        shown.drawImage(canvas, px, py, 1, 1, 0, 0, 1, 1);
        return first(shown);
    });
    const is = (token, at) => rgb(token).every((each, channel) => Math.abs(each - seen[at][channel]) < 40);
    const fits = look.every((token, at) => token === "" ? !is("ink", at) && !is("warn", at) : is(token, at));
    return {fits, seen};
}"""


@pytest.fixture
def house(sqlite_url: str) -> Iterator[OpenHouse]:
    with open_house(sqlite_url, plant=PLANT) as house:
        yield house


@pytest.fixture
def vehicle(house: OpenHouse) -> Puppet:
    async def join(inside: House) -> Puppet:
        return await Puppet.join(inside, "ATV5", X_M, LOW_M, node="c2", status=AtvStatus.IDLE)

    return house.do(join)


def moves(house: OpenHouse, vehicle: Puppet, y_m: float, **state: object) -> None:
    """It is somewhere else on the lane, and says so."""

    async def beat(_inside: House) -> None:
        vehicle.y_m = y_m
        vehicle.beat(**state)

    house.do(beat)


def meets_the_door(house: OpenHouse, vehicle: Puppet) -> None:
    """It stands before the door, which does not open, tells the others, and asks for help."""

    async def tell(inside: House) -> None:
        seen = ObstacleSeen(atv=vehicle.atv, start="c2", end="c3", there=True, forget_in_s=600.0)
        inside.bus.join(vehicle.atv, vehicle.on_message).publish(KEYS.obstacle(vehicle.atv), seen)
        about = Problem(kind=ProblemKind.WAY_BLOCKED, needs_person=True)
        reason = f"the door {GATE.name} does not open, and no way leads round it"
        help_ = HelpWanted(until_s=LATER_S)
        vehicle.beat(status=AtvStatus.ERROR, problem=reason, about_problem=about, help=help_, way=())

    house.do(tell)


def stands(page: Page, look: str) -> None:
    """Wait until the door is drawn so.

    Raises:
        AssertionError: it is not; with the colours that are there.
    """
    plant = {"width": PLANT.width_m, "height": PLANT.height_m}
    door = {"x": X_M, "y": (LOW_M + HIGH_M) / 2, "half": HALF_M, "least": LEAST_PX}
    arg = [plant, PAD_PX, door, list(LOOKS[look])]
    try:
        page.wait_for_function(f"arg => ({LOOK})(arg).fits", arg=arg, polling=LOOK_MS)
    except NeverShown:
        raise AssertionError(f"the door is not drawn {look}: {page.evaluate(LOOK, arg)['seen']}") from None


@pytest.mark.parametrize("scheme", variants(["light", "dark"]))
def test_a_door_opens_before_a_vehicle_enters_and_is_shut_behind_it(
    house: OpenHouse, vehicle: Puppet, open_page: OpenPage, screenshot: Screenshot, scheme: str
) -> None:
    page = as_manager(house, open_page, color_scheme=scheme, viewport=SIZE)
    expect(page.locator("#plant-map canvas").first).to_be_visible()
    stands(page, "shut")
    moves(house, vehicle, LOW_M, way=("c3",), status=AtvStatus.WORKING)
    stands(page, "opening")
    moves(house, vehicle, LOW_M + 0.6, speed_mps=1.0)
    stands(page, "open")
    screenshot(page, f"door-open-{scheme}")
    moves(house, vehicle, HIGH_M, node="c3", way=(), speed_mps=0.0, status=AtvStatus.IDLE)
    stands(page, "shut")


@pytest.mark.parametrize("scheme", variants(["dark", "light"]))
def test_a_door_that_does_not_open_is_told_in_words_until_somebody_says_that_it_does(
    house: OpenHouse, vehicle: Puppet, open_page: OpenPage, screenshot: Screenshot, scheme: str
) -> None:
    page = as_manager(house, open_page, color_scheme=scheme, viewport=SIZE)
    stands(page, "shut")
    card = page.locator(".card.closures")
    expect(card).to_have_count(0)
    meets_the_door(house, vehicle)
    stands(page, "failed")
    line = card.get_by_role("listitem")
    expect(line).to_contain_text("Hall gate does not open")
    expect(line).to_contain_text("ATV5 stood before it")
    expect(page.locator(".inbox")).to_contain_text("the door Hall gate does not open")
    screenshot(page, f"door-failed-{scheme}")
    page.get_by_role("button", name="Legend").click()
    signs = page.get_by_role("list", name="What the signs of the map mean")
    for words in ("door that is shut", "door that opens", "door that is open", "door that does not open"):
        expect(signs.get_by_text(words, exact=True)).to_be_visible()
    screenshot(page, f"door-legend-{scheme}")
    page.keyboard.press("Escape")
    moves(house, vehicle, LOW_M, status=AtvStatus.IDLE, problem="", about_problem=UNSET, help=None)
    line.get_by_role("button", name="It opens: Hall gate").click()
    expect(card).to_have_count(0)
    stands(page, "shut")


def test_a_door_is_put_on_a_lane_of_a_draft_changed_kept_and_taken_away(
    house: OpenHouse, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = as_manager(house, open_page, viewport=SIZE)
    page.goto(f"{house.url}/editor")
    page.get_by_label("Name of the draft").fill("Doors")
    page.get_by_role("button", name="Begin with the running plant").click()
    doors = page.locator(".ed-draft .ed-door")
    expect(doors).to_have_count(1)
    # The one that is there, by its lane's sheet; then a new one.
    page.locator(".ed-side").get_by_label("Kind").select_option("lanes")
    lanes = page.locator(".ed-side").get_by_label("Which")
    lanes.select_option(label="c2 – c3")  # noqa: RUF001 (as the panel writes it)
    page.get_by_role("button", name="Times of GATE").click()
    sheet = page.get_by_role("region", name="Door GATE")
    sheet.get_by_label("Opens in, s").fill("8000")
    sheet.get_by_label("Opens in, s").press("Tab")
    expect(sheet).to_contain_text("8000 is not within 0.1 to 600")
    expect(page.locator(".ed-door.faulty")).to_have_count(1)
    screenshot(page, "editor-door-fault")
    sheet.get_by_label("Opens in, s").fill("12")
    sheet.get_by_label("Opens in, s").press("Tab")
    expect(page.locator(".ed-door.faulty")).to_have_count(0)
    expect(page.get_by_text("1 change against the running plant")).to_be_visible()
    sheet.get_by_role("button", name="Done").click()
    lanes.select_option(label="c3 – c4")  # noqa: RUF001 (likewise)
    page.get_by_role("button", name="Put a door here").click()
    expect(doors).to_have_count(2)
    expect(page.get_by_text("2 changes against the running plant")).to_be_visible()
    expect(page.locator(".ed-kept")).to_contain_text("kept as version")
    # Whoever opens the draft again finds both as they were left.
    page.reload()
    expect(doors).to_have_count(2)
    page.locator(".ed-side").get_by_label("Kind").select_option("doors")
    page.locator(".ed-side").get_by_label("Which").select_option(label="GATE")
    expect(sheet.get_by_label("Opens in, s")).to_have_value("12")
    screenshot(page, "editor-door-kept")
    sheet.get_by_role("button", name="Remove", exact=True).click()
    expect(doors).to_have_count(1)
    page.get_by_role("button", name="Undo").click()
    expect(doors).to_have_count(2)

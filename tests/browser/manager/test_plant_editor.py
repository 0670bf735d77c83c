"""The plant editor in a real browser: from a LIF file to a shift that was played in it, by pointer and by keyboard."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path

import ezdxf
import pytest
from playwright.sync_api import Page, Route, expect

from dray.plant import load_plant
from dray.plant.exchange.lif_export import export_lif

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

SIZE = {"viewport": {"width": 1440, "height": 900}}

PLAYED_MS = 240_000
"""Two shifts of a quarter of an hour in the simulator, on a computer that is busy."""


OUTSIDE = """() => [...document.querySelectorAll(".ed-main .card")].flatMap((card) => {
    const edge = card.getBoundingClientRect().right;
    return [...card.querySelectorAll("button, input, select, textarea, p, kbd")]
        .filter((each) => each.checkVisibility() && each.getBoundingClientRect().right > edge + 1)
        .map((each) => each.outerHTML.slice(0, 60));
})"""
"""What reaches out of its card."""


@pytest.fixture(scope="module")
def workshop(start_dray) -> Iterator[str]:
    """A small factory in which nobody orders."""
    dray = start_dray("--plant", "workshop", "--no-demand")
    yield dray.url
    assert dray.stop() == 0, dray.output()


@pytest.fixture
def lif_file(tmp_path: Path) -> Path:
    file = tmp_path / "workshop.json"
    file.write_text(export_lif(load_plant("workshop"), "2026-11-23T08:00:00Z"), encoding="utf-8")
    return file


def at(page: Page, x_m: float, y_m: float) -> tuple[float, float]:
    """Where a spot of the floor is on the screen."""
    x, y = page.evaluate(
        """([x, y]) => {
          const svg = document.querySelector('.ed-canvas svg');
          const high = Number(svg.querySelector('.ed-ground').getAttribute('height'));
          const point = new DOMPoint(x, high - y).matrixTransform(svg.getScreenCTM());
          return [point.x, point.y];
        }""",
        [x_m, y_m],
    )
    return x, y


def click(page: Page, x_m: float, y_m: float) -> None:
    page.mouse.click(*at(page, x_m, y_m))


def lies_on(page: Page, *, width_m: float, height_m: float) -> None:
    """That the picture under the draft covers a piece of the floor from its lower left corner, and nothing else."""
    left, top = at(page, 0.0, height_m)
    right, bottom = at(page, width_m, 0.0)
    box = page.locator(".ed-floor image").bounding_box()
    assert box is not None
    assert (box["x"], box["y"]) == pytest.approx((left, top), abs=1.0)
    assert (box["width"], box["height"]) == pytest.approx((right - left, bottom - top), abs=2.0)


def hold_look(route: Route, held: list[Route]) -> None:
    """Keep a question back how far a shift is."""
    if route.request.method == "GET":
        held.append(route)
    else:
        route.continue_()


@pytest.mark.slow
def test_from_a_lif_file_to_a_played_shift(
    workshop: str, open_page: OpenPage, screenshot: Screenshot, lif_file: Path
) -> None:
    page = open_page(workshop, **SIZE)
    page.get_by_role("link", name="Editor").click()
    expect(page.get_by_role("heading", name="Plant editor")).to_be_visible()
    # Alone, the layout lacks what no layout tells.
    page.get_by_label("Name of the draft").fill("Layout alone")
    # A foreign file brings nothing of this plant, unless somebody wishes so.
    expect(page.get_by_label("what a layout cannot tell")).not_to_be_checked()
    page.get_by_label("Plant file (YAML)").set_input_files(lif_file)
    expect(page.get_by_role("heading", name="Layout alone")).to_be_visible()
    expect(page.locator(".ed-checks li").filter(has_text="is open: what makes products")).to_be_visible()
    expect(page.get_by_role("button", name="Play a shift here")).to_be_disabled()
    screenshot(page, "editor-1-lif-alone")
    # A finding about a whole list leads to the list.
    makers = page.locator(".ed-checks li").filter(has_text="is open: what makes products")
    makers.get_by_role("button", name=re.compile("^Show")).click()
    kind = page.locator(".ed-side").get_by_label("Kind")
    expect(kind).to_be_focused()
    expect(kind).to_have_value("machines")
    screenshot(page, "editor-1-finding-list")
    page.get_by_role("button", name="Close", exact=True).click()
    # The rest is taken from the running plant.
    page.get_by_label("Name of the draft").fill("New hall")
    page.get_by_label("what a layout cannot tell").check()
    page.get_by_label("Plant file (YAML)").set_input_files(lif_file)
    expect(page.get_by_role("heading", name="New hall")).to_be_visible()
    expect(page.get_by_text("0 changes against the running plant")).to_be_visible()
    # A parking place more, and no way there yet: the checks say so.
    page.keyboard.press("p")
    click(page, 3.0, 3.0)
    expect(page.locator(".ed-checks li").filter(has_text="cannot be reached")).to_be_visible()
    screenshot(page, "editor-2-not-reached")
    # Its repair is offered with the measure at the place, and can be undone.
    repair = page.locator(".ed-checks").get_by_role("button", name="Draw a two-way road to")
    expect(page.locator(".ed-measures text")).to_have_count(1)
    repair.click()
    expect(page.locator(".ed-checks li").filter(has_text="cannot be reached")).to_have_count(0)
    expect(page.locator(".ed-kept")).to_contain_text("kept as version")
    screenshot(page, "editor-2-repaired")
    page.get_by_role("button", name="Undo").click()
    expect(page.locator(".ed-checks li").filter(has_text="cannot be reached")).to_be_visible()
    page.get_by_role("button", name="Show finding 1").click()
    expect(page.locator(".ed-side .ed-error, .ed-side .ed-said").first).to_be_visible()
    # A road from there to the nearest node that there was. What is typed now belongs to the field that was led to.
    node = load_plant("workshop").file.nodes[0]
    page.locator(".ed-tool").filter(has_text="Two-way road").click()
    click(page, 3.0, 3.0)
    click(page, node.x_m, node.y_m)
    page.keyboard.press("Escape")
    expect(page.locator(".ed-checks li").filter(has_text="cannot be reached")).to_have_count(0)
    expect(page.get_by_text("3 changes against the running plant")).to_be_visible()
    page.get_by_role("button", name="Undo").click()
    expect(page.locator(".ed-checks li").filter(has_text="cannot be reached")).to_be_visible()
    page.get_by_role("button", name="Redo").click()
    expect(page.locator(".ed-checks li").filter(has_text="cannot be reached")).to_have_count(0)
    expect(page.locator(".ed-kept")).to_contain_text("kept as version")
    screenshot(page, "editor-3-drawn")
    page.get_by_label("Hours").fill("0.25")
    page.get_by_label("Hours").press("Tab")
    held: list[Route] = []
    # How far it is nobody hears before the bar was seen.
    page.route("**/play", lambda route: hold_look(route, held))
    page.get_by_role("button", name="Play a shift here").click()
    expect(page.get_by_role("progressbar")).to_be_visible()
    for look in held:
        look.continue_()
    held.clear()
    page.unroute("**/play")
    expect(page.get_by_text("Bottleneck:")).to_be_visible(timeout=PLAYED_MS)
    expect(page.get_by_role("progressbar")).to_have_count(0)
    expect(page.locator(".ed-figures div")).to_have_count(4)
    # Of what the number of transports is, which Figures tell of the running plant's own hours; and how one drives by this file.
    expect(page.locator(".ed-figures")).to_contain_text("handed over an hour, on average")
    expect(page.locator(".ed-play")).to_contain_text("own orders and figures are others.")
    expect(page.locator(".ed-next")).to_contain_text("dray up --plant FILE")
    screenshot(page, "editor-4-played")
    page.locator(".top select").select_option("de")
    expect(page.locator(".ed-play p").filter(has_text="Engpass:")).to_have_text(
        re.compile(r"Engpass: .*(knapp|zu wenig|zu klein|zu eng)")
    )
    page.locator(".top select").select_option("en")
    # An answer that is older than the draft says so.
    page.keyboard.press("n")
    click(page, 5.0, 3.0)
    expect(page.get_by_text("played before the last change")).to_be_visible()
    with page.expect_download() as saved:
        page.get_by_role("link", name="Save as file").click()
    assert "unassigned" not in Path(saved.value.path()).read_text(encoding="utf-8").partition("nodes")[0]


@pytest.mark.slow
def test_a_plant_begins_on_an_empty_floor(workshop: str, open_page: OpenPage, screenshot: Screenshot) -> None:
    page = open_page(f"{workshop}/editor", **SIZE)
    page.get_by_label("Name of the draft").fill("Hall 4")
    page.get_by_role("spinbutton", name="width, m").fill("30")
    page.get_by_role("spinbutton", name="depth, m").fill("20")
    screenshot(page, "editor-start")
    page.get_by_role("button", name="Begin with nothing on it").click()
    expect(page.get_by_role("heading", name="Hall 4")).to_be_visible()
    checks = page.locator(".ed-checks li")
    expect(checks.filter(has_text="is open: what makes products")).to_be_visible()
    page.get_by_role("button", name="Draft alone").click()
    page.locator(".ed-tool").filter(has_text="Two-way road").click()
    expect(page.get_by_text("the last node again ends the row")).to_be_visible()
    click(page, 8.0, 10.0)
    click(page, 12.0, 10.0)
    page.locator(".ed-tool").filter(has_text="Machine").click()
    click(page, 8.0, 10.0)
    expect(checks.filter(has_text="Machine M1 · Working station is open")).to_be_visible()
    side = page.locator(".ed-side")
    side.get_by_label("Kind").select_option("Machine")
    side.get_by_label("Which").select_option(index=1)
    expect(side.locator(".ed-said").first).to_contain_text("Working station is open")
    screenshot(page, "editor-empty-floor")
    expect(page.locator(".ed-kept")).to_contain_text("kept as version")
    with page.expect_download() as saved:
        page.get_by_role("link", name="Save as file").click()
    assert saved.value.suggested_filename == "hall-4.yaml"
    assert "width_m: 30" in Path(saved.value.path()).read_text(encoding="utf-8")


@pytest.mark.slow
def test_what_a_layout_leaves_open_is_shown_empty_and_filled_in_by_choice(
    workshop: str, open_page: OpenPage, screenshot: Screenshot, lif_file: Path
) -> None:
    page = open_page(f"{workshop}/editor", **SIZE)
    page.get_by_label("Name of the draft").fill("Filled in")
    page.get_by_label("Plant file (YAML)").set_input_files(lif_file)
    expect(page.get_by_role("heading", name="Filled in")).to_be_visible()
    side, kept = page.locator(".ed-side"), page.locator(".ed-kept")
    lists = side.get_by_role("group", name="Lists of the plant file")
    for section in ("Materials", "Products", "Working stations", "Vehicle types", "Fleet"):
        lists.get_by_label("List").select_option(section)
        written = lists.locator("input, textarea").evaluate_all("all => all.map((each) => each.value)")
        assert not [each for each in written if "null" in each], section
    lists.get_by_label("List").select_option("Materials")
    lists.get_by_role("button", name="New entry").click()
    lists.get_by_label("Name").fill("Shaft")
    lists.get_by_label("Pieces in a container").fill("20")
    lists.get_by_label("Pieces in a machine").fill("60")
    lists.get_by_label("List").select_option("Products")
    lists.get_by_role("button", name="New entry").click()
    lists.get_by_role("button", name="One more").click()
    lists.get_by_role("combobox", name="Material", exact=True).select_option("material1")
    lists.get_by_label("Pieces", exact=True).fill("3")
    lists.get_by_label("Pieces", exact=True).press("Tab")
    expect(kept).to_contain_text("kept as version")
    screenshot(page, "editor-lists")
    side.get_by_label("Kind").select_option("Station without a purpose")
    side.get_by_label("Which").select_option(index=1)
    side.get_by_role("button", name="Machine").click()
    expect(side.get_by_label("Working station")).to_have_value("")
    side.get_by_role("group", name="Makes").get_by_role("button", name="One more").click()
    expect(side.get_by_role("combobox", name="Product", exact=True)).to_have_value("product1")
    side.get_by_label("Cycle, s").fill("45")
    side.get_by_label("Cycle, s").press("Tab")
    expect(kept).to_contain_text("kept as version")
    side.get_by_role("group", name="Shifts", exact=True).get_by_role("button", name="One more").click()
    side.get_by_label("To", exact=True).fill("15:30")
    side.get_by_role("checkbox", name="Fri").uncheck()
    expect(kept).to_contain_text("kept as version")
    screenshot(page, "editor-machine")
    # Findings are told in the reader's language, and all of it fits on every screen.
    checks = page.locator(".ed-checks li")
    expect(checks.filter(has_text="is open").first).to_be_visible()
    # Each says where it is in the words of the forms, and leads to the field.
    assert not [said for said in checks.all_inner_texts() if re.search(r"\w\[\d+\]", said)]
    shows = page.get_by_role("button", name=re.compile("^Show"))
    missing = checks.filter(has_text="is open").filter(has=shows).first
    label = missing.locator(".ed-where").inner_text().split(" · ")[-1]
    missing.get_by_role("button", name=re.compile("^Show")).click()
    expect(page.locator(".ed-side :focus")).to_have_count(1)
    expect(page.locator(".ed-side [data-at]:has(:focus)").last).to_contain_text(label)
    screenshot(page, "editor-finding-field")
    page.locator(".top select").select_option("es")
    expect(checks.filter(has_text="está abierto").first).to_be_visible()
    expect(checks.filter(has_text="is open")).to_have_count(0)
    for width in (390, 800, 1024):
        page.set_viewport_size({"width": width, "height": 900})
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), width
        assert page.evaluate(OUTSIDE) == [], width
    screenshot(page, "editor-machine-phone-es")
    draft = page.request.get(f"{workshop}/api/plant-drafts/{page.evaluate('location.hash.slice(1)')}").json()[
        "data"
    ]
    assert draft["materials"] == [{"id": "material1", "name": "Shaft", "lot": 20, "buffer": 60}]
    assert draft["products"][0]["bill"] == [{"material": "material1", "quantity": 3}]
    assert draft["machines"][0]["makes"] == [{"product": "product1", "cycle_s": 45}]
    shift = {"start": "06:00", "end": "15:30", "days": ["mon", "tue", "wed", "thu"]}
    assert draft["machines"][0]["working_time"] == {"shifts": [shift]}


@pytest.mark.slow
def test_it_is_drawn_with_the_keyboard_alone_in_the_dark_and_in_german(
    workshop: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(f"{workshop}/editor", **SIZE, locale="de-DE", color_scheme="dark")
    page.get_by_label("Name des Entwurfs").fill("Tastatur")
    page.get_by_role("button", name="Mit dem laufenden Werk beginnen").press("Enter")
    canvas = page.get_by_role("application")
    canvas.focus()
    page.keyboard.press("n")
    for _ in range(4):
        page.keyboard.press("ArrowRight")
        page.keyboard.press("ArrowUp")
    page.keyboard.press("Enter")
    expect(page.get_by_text("1 Änderung gegenüber dem laufenden Werk")).to_be_visible()
    page.keyboard.press("v")
    page.keyboard.press("Enter")
    expect(page.get_by_role("heading", name="Knoten n1")).to_be_visible()
    page.keyboard.press("Shift+ArrowRight")
    expect(page.get_by_label("x, m")).to_have_value("2.5")
    page.keyboard.press("Delete")
    expect(page.get_by_text("0 Änderungen gegenüber dem laufenden Werk")).to_be_visible()
    page.keyboard.press("Control+z")
    expect(page.get_by_text("1 Änderung gegenüber dem laufenden Werk")).to_be_visible()
    screenshot(page, "editor-dark-german")
    page.get_by_role("button", name="Schließen").click()
    expect(page.get_by_role("button", name="Tastatur", exact=True)).to_be_visible()


@pytest.mark.slow
def test_two_who_draw_at_once_do_not_write_over_one_another(workshop: str, open_page: OpenPage) -> None:
    one = open_page(f"{workshop}/editor", **SIZE)
    one.get_by_label("Name of the draft").fill("Shared")
    one.get_by_role("button", name="Begin with the running plant").click()
    expect(one.get_by_role("heading", name="Shared")).to_be_visible()
    other = open_page(one.url, **SIZE)
    expect(other.get_by_role("heading", name="Shared")).to_be_visible()
    one.keyboard.press("n")
    click(one, 3.0, 3.0)
    expect(one.locator(".ed-kept")).to_contain_text("version 2")
    answer = other.request.put(
        f"{workshop}/api/plant-drafts/{other.url.rpartition('#')[2]}",
        data={"name": "Shared", "data": {}},
        headers={"If-Match": '"1"', "Origin": workshop},
    )
    assert answer.status == 412


@pytest.mark.slow
def test_a_floor_plan_in_dxf_lies_under_the_draft_and_a_place_that_is_too_narrow_is_repaired(
    workshop: str, open_page: OpenPage, screenshot: Screenshot, tmp_path: Path
) -> None:
    plan = tmp_path / "hall.dxf"
    document = ezdxf.new()
    document.header["$INSUNITS"] = 4
    document.modelspace().add_lwpolyline([(0, 0), (24_000, 0), (24_000, 14_000), (0, 14_000)], close=True)
    document.modelspace().add_line((2000, 800), (22_000, 9_500))
    document.modelspace().add_text("Hall 3")
    document.saveas(plan)
    page = open_page(f"{workshop}/editor", **SIZE)
    page.get_by_label("Name of the draft").fill("On a plan")
    page.get_by_role("button", name="Begin with the running plant").click()
    page.get_by_label("floor plan (DXF)").set_input_files(plan)
    expect(page.get_by_text("14.0 m, as the plan says")).to_be_visible(timeout=60_000)
    expect(page.get_by_text("left out: TEXT, 1 times")).to_be_visible()
    page.locator(".top select").select_option("es")
    expect(page.get_by_text("omitido: TEXT, 1 veces")).to_be_visible()
    page.locator(".top select").select_option("en")
    expect(page.get_by_label("Width, m")).to_have_value("24")
    picture = page.locator(".ed-floor image")
    expect(picture).to_have_attribute("width", "24")
    load = "async (it) => { const seen = new Image(); seen.src = it.getAttribute('href'); await seen.decode(); return seen.naturalWidth; }"
    assert picture.evaluate(load) == 24_000
    lies_on(page, width_m=24.0, height_m=14.0)
    # Two places nearer to one another than a vehicle is long, on a road of their own.
    page.keyboard.press("r")
    click(page, 3.0, 3.0)
    click(page, 6.0, 3.0)
    page.keyboard.press("Escape")
    click(page, 6.0, 3.0)
    # The plan has an x of its own, which is there until the node is.
    node = page.get_by_role("region", name=re.compile("^Node "))
    node.get_by_label("x, m").fill("3.4")
    node.get_by_label("x, m").press("Tab")
    found = page.locator(".ed-checks li").filter(has_text="nearer to one another")
    expect(found).to_be_visible()
    page.get_by_role("button", name="Done", exact=True).click()
    screenshot(page, "editor-5-dxf-and-narrow")
    found.get_by_role("button", name="so that vehicles have room").click()
    expect(found).to_have_count(0)
    screenshot(page, "editor-6-mended")
    # A drawing of somebody's own, which lies in the middle of whatever it is shown in, as SVG does unless it says otherwise.
    own = tmp_path / "own.svg"
    own.write_text('<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 40 10"><path d="M0 0L40 10"/></svg>')
    page.get_by_label("floor plan (DXF)").set_input_files(own)
    expect(page.get_by_label("Width, m")).to_have_value("24")
    shown = "async (it) => { for (let at = 0; at < 600 && it.getBBox().height > 10; at += 1) await new Promise(requestAnimationFrame); }"
    picture.evaluate(shown)
    lies_on(page, width_m=24.0, height_m=6.0)


@pytest.mark.slow
def test_a_storage_is_refilled_by_vehicles_from_a_warehouse_that_gets_stocks(
    workshop: str, open_page: OpenPage
) -> None:
    page = open_page(f"{workshop}/editor", **SIZE)
    page.get_by_label("Name of the draft").fill("Refills")
    page.get_by_role("button", name="Begin with the running plant").click()
    choose(page, "Storage", "RACK")
    page.get_by_label("Material comes").select_option("by vehicles, from warehouses")
    missing = page.locator(".ed-checks li").filter(has_text="no source warehouse has")
    expect(missing).to_have_count(2)
    expect(page.get_by_text("no warehouse has it")).to_have_count(2)
    page.get_by_role("group", name="screws").get_by_label("Orders at").fill("40")
    page.get_by_role("button", name="Done").click()
    choose(page, "Warehouse", "IN")
    for _ in range(2):
        page.get_by_role("button", name="One more stock").click()
    page.get_by_label("machines fetch here, too").check()
    expect(missing).to_have_count(0)
    page.get_by_role("button", name="Done").click()
    choose(page, "Storage", "RACK")
    expect(page.get_by_text("brought from IN")).to_have_count(2)
    expect(page.get_by_role("group", name="screws").get_by_label("Orders at")).to_have_value("40")


def choose(page: Page, kind: str, name: str) -> None:
    """Choose something by the lists beside the floor."""
    lists = page.locator(".ed-side select")
    lists.nth(0).select_option(kind)
    lists.nth(1).select_option(name)

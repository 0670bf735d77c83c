"""The plant editor in a real browser: from a LIF file to a shift that was played in it, by pointer and by keyboard."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from dray.plant import load_plant
from dray.plant.exchange.lif_export import export_lif

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

SIZE = {"viewport": {"width": 1440, "height": 900}}

PLAYED_MS = 240_000
"""Two shifts of a quarter of an hour in the simulator, on a computer that is busy."""


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


@pytest.mark.slow
def test_from_a_lif_file_to_a_played_shift(
    workshop: str, open_page: OpenPage, screenshot: Screenshot, lif_file: Path
) -> None:
    page = open_page(workshop, **SIZE)
    page.get_by_role("link", name="Editor").click()
    expect(page.get_by_role("heading", name="Plant editor")).to_be_visible()
    # Alone, the layout lacks what no layout tells.
    page.get_by_label("Name of the draft").fill("Layout alone")
    page.get_by_label("what a layout cannot tell").uncheck()
    page.get_by_label("Plant file (YAML)").set_input_files(lif_file)
    expect(page.get_by_role("heading", name="Layout alone")).to_be_visible()
    expect(page.locator(".ed-checks li").filter(has_text="is open: what makes products")).to_be_visible()
    expect(page.get_by_role("button", name="Play a shift here")).to_be_disabled()
    screenshot(page, "editor-1-lif-alone")
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
    page.get_by_role("button", name="Show finding 1").click()
    expect(page.locator(".ed-side .ed-error, .ed-side .ed-said").first).to_be_visible()
    # A road from there to the nearest node that there was.
    node = load_plant("workshop").file.nodes[0]
    page.keyboard.press("r")
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
    page.get_by_role("button", name="Play a shift here").click()
    expect(page.get_by_text("Bottleneck:")).to_be_visible(timeout=PLAYED_MS)
    expect(page.locator(".ed-figures div")).to_have_count(4)
    screenshot(page, "editor-4-played")
    # An answer that is older than the draft says so.
    page.keyboard.press("n")
    click(page, 5.0, 3.0)
    expect(page.get_by_text("played before the last change")).to_be_visible()
    with page.expect_download() as saved:
        page.get_by_role("link", name="Save as file").click()
    assert "unassigned" not in Path(saved.value.path()).read_text(encoding="utf-8").partition("nodes")[0]


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

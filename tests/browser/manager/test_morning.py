"""A manager's morning without a terminal, done twice: with the mouse alone, and with the keyboard alone."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Protocol

import pytest
from complaints import Complaints
from playwright.sync_api import Locator, Page, expect
from tablet_kit import forgive

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]


@pytest.fixture
def factory(quiet: Any) -> Iterator[str]:
    """Time goes on while somebody works."""
    with quiet.going():
        yield str(quiet.url)


MOST_TABS = 300
"""On one page: more than any has, and less than anybody would press."""

COUNT_PRINTS = "window.printed = 0; window.print = () => { window.printed += 1; };"
"""A headless browser has no dialog for the printer."""

UNHURRIED = "AbortSignal.timeout = () => new AbortController().signal;"
"""Waits for an answer, and for the words of a refusal, as long as a busy computer takes: a PIN is hashed slowly on purpose."""

IS_FOCUSED = "here => here === document.activeElement"

SEEN = """here => {
    const drawn = [here, ...(here.closest("label")?.children ?? [])].map((each) => getComputedStyle(each));
    const box = here.getBoundingClientRect();
    return drawn.some((style) => style.outlineStyle !== "none" && parseFloat(style.outlineWidth) >= 2)
        && box.bottom > 0 && box.top < innerHeight && box.right > 0 && box.left < innerWidth;
}"""
"""Whether what has the focus shows it, and is in sight."""


class Hand(Protocol):
    """How somebody works at the page."""

    def press(self, button: Locator) -> None: ...

    def write(self, field: Locator, text: str) -> None: ...

    def tick(self, box: Locator) -> None: ...

    def choose(self, field: Locator, label: str) -> None: ...

    def has_focus(self, expected: Locator) -> None:
        """What somebody goes on from, now that something is closed."""


class Mouse:
    """Points and clicks; the keyboard is for letters only."""

    def __init__(self, page: Page) -> None:
        self._page = page

    def press(self, button: Locator) -> None:
        button.click()

    def write(self, field: Locator, text: str) -> None:
        field.click(click_count=3)
        self._page.keyboard.type(text)

    def tick(self, box: Locator) -> None:
        box.click()

    def choose(self, field: Locator, label: str) -> None:
        # The browser draws the list of choices outside of the page.
        field.select_option(label=label)

    def has_focus(self, expected: Locator) -> None:
        """Nothing: the next click goes anywhere."""


class Keyboard:
    """Tab to it, and use it; nothing is focused in any other way."""

    def __init__(self, page: Page) -> None:
        self._page = page

    def press(self, button: Locator) -> None:
        self._reach(button)
        self._page.keyboard.press("Enter")

    def write(self, field: Locator, text: str) -> None:
        self._reach(field)
        self._page.keyboard.press("Control+a")
        self._page.keyboard.type(text)

    def tick(self, box: Locator) -> None:
        self._reach(box)
        self._page.keyboard.press("Space")

    def choose(self, field: Locator, label: str) -> None:
        self._reach(field)
        self._page.keyboard.press("Home")
        choices = field.locator("option").all_inner_texts()
        for _ in choices:
            if field.locator("option:checked").inner_text() == label:
                return
            self._page.keyboard.press("ArrowDown")
        assert field.locator("option:checked").inner_text() == label, choices

    def has_focus(self, expected: Locator) -> None:
        expect(expected).to_be_focused()

    def _reach(self, wanted: Locator) -> None:
        """Go on from where the keyboard is, all round the page if need be."""
        expect(wanted).to_be_visible()
        for _ in range(MOST_TABS):
            if wanted.evaluate(IS_FOCUSED):
                break
            self._page.keyboard.press("Tab")
        else:
            raise AssertionError(f"the keyboard does not reach {wanted}")
        assert wanted.evaluate(SEEN), f"{wanted} has the focus, and nobody sees it"


@pytest.mark.parametrize("by", [Mouse, Keyboard])
def test_a_morning_needs_no_terminal(
    factory: str,
    open_page: OpenPage,
    screenshot: Screenshot,
    complaints: Complaints,
    by: Callable[[Page], Hand],
) -> None:
    page = open_page("about:blank", visits=factory, viewport={"width": 1440, "height": 900})
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    page.add_init_script(COUNT_PRINTS)
    page.add_init_script(UNHURRIED)
    page.goto(factory)
    expect(page.locator("#plant-map canvas").first).to_be_visible()
    morning = Morning(page, by(page), by.__name__.lower(), factory, screenshot)
    morning.people()
    morning.keys()
    morning.orders()
    morning.faults()
    morning.report()
    # A PIN was too easy.
    forgive(complaints, "422")


class Morning:
    """What is done on it, whatever the hand."""

    def __init__(self, page: Page, hand: Hand, by: str, factory: str, screenshot: Screenshot) -> None:
        self._page, self._hand, self._by = page, hand, by
        self._factory, self._screenshot = factory, screenshot

    def people(self) -> None:
        """Somebody new comes in by a link, has a PIN, and is locked out."""
        page, hand, login = self._page, self._hand, f"ana-{self._by}"
        hand.press(page.locator("[popovertarget=person-menu]").first)
        hand.press(page.locator("#person-menu").get_by_role("button", name="People and keys"))
        expect(page.get_by_role("heading", level=1)).to_have_text("People and keys")
        add = page.get_by_role("button", name="Add somebody…")
        hand.press(add)
        sheet = page.locator("#person-sheet")
        hand.write(sheet.get_by_label("Typed to log in"), login)
        hand.write(sheet.get_by_label("Name (as people say it)"), "Ana")
        hand.tick(sheet.get_by_role("checkbox", name="North", exact=True))
        hand.press(sheet.get_by_role("button", name="Add", exact=True))
        expect(sheet.get_by_role("status").last).to_contain_text("Added")
        hand.press(sheet.get_by_role("button", name="Make a login link"))
        link = sheet.get_by_label("Login link", exact=True)
        expect(link).to_have_value(re.compile(re.escape(self._factory) + r"/login/\S+"))
        hand.press(sheet.get_by_role("button", name="Copy"))
        expect(sheet).to_contain_text("Copied.")
        assert page.evaluate("navigator.clipboard.readText()") == link.input_value()
        hand.press(sheet.get_by_role("button", name="Close"))
        hand.has_focus(add)

        row = page.get_by_role("row").filter(has_text=login)
        change = row.get_by_role("button", name="Change Ana")
        hand.press(change)
        hand.write(sheet.get_by_label("New PIN, 6 to 12 digits"), "123456")
        hand.press(sheet.get_by_role("button", name="Give it"))
        expect(sheet.locator(".complaint").filter(has_text="too easy")).to_be_visible()
        hand.write(sheet.get_by_label("New PIN, 6 to 12 digits"), "402719")
        hand.press(sheet.get_by_role("button", name="Give it"))
        expect(sheet.get_by_role("status").last).to_contain_text("Given")
        self._screenshot(page, f"morning-person-{self._by}")
        hand.press(sheet.get_by_role("button", name="Lock out"))
        hand.has_focus(sheet.get_by_role("button", name="Keep"))
        hand.press(sheet.get_by_role("button", name="Lock out"))
        expect(sheet.get_by_role("status").last).to_contain_text("Locked out")
        hand.press(sheet.get_by_role("button", name="Close"))
        hand.has_focus(change)
        expect(row).to_contain_text("may not log in")

    def keys(self) -> None:
        """Another system gets a key, uses it, and loses it."""
        page, hand, name = self._page, self._hand, f"ERP by {self._by}"
        make = page.get_by_role("button", name="Make a key…")
        hand.press(make)
        sheet = page.locator("#key-sheet")
        hand.write(sheet.get_by_label("For what"), name)
        hand.tick(sheet.get_by_label("see orders"))
        hand.press(sheet.get_by_role("button", name="Make the key"))
        token = sheet.get_by_label("The key", exact=True).input_value()
        header = {"Authorization": f"Bearer {token}"}
        assert page.request.get(f"{self._factory}/api/orders", headers=header).ok
        hand.press(sheet.get_by_role("button", name="Close"))
        hand.has_focus(make)
        row = page.get_by_role("row").filter(has_text=name)
        hand.press(row.get_by_role("button", name=f"Take back {name}"))
        hand.has_focus(row.get_by_role("button", name="Keep it"))
        hand.press(row.get_by_role("button", name="Take back"))
        expect(row).to_contain_text("taken back")
        self._screenshot(page, f"morning-people-{self._by}")

    def orders(self) -> None:
        """An order is published and changed, its customer gets a link and loses it, and it is cancelled."""
        page, hand, reference = self._page, self._hand, f"PO-{self._by}"
        menu = page.get_by_role("navigation", name="Views")
        hand.press(menu.get_by_role("link", name="Plant"))
        form = page.locator(".publish")
        hand.write(form.get_by_label("Quantity"), "300")
        hand.write(form.get_by_label("Customer"), "Waterworks South")
        hand.write(form.get_by_label("Reference"), reference)
        hand.press(form.get_by_role("button", name="Publish", exact=True))
        expect(page.locator(".outcome-good")).to_contain_text("Published as")

        hand.press(menu.get_by_role("link", name="Orders"))
        hand.press(page.get_by_role("link", name=reference))
        expect(page.get_by_role("heading", level=1)).to_have_text(reference)
        change = page.locator(".order-change")
        hand.write(change.get_by_label("Reference"), f"{reference}-B")
        hand.choose(change.get_by_label("Priority"), "urgent")
        hand.press(change.get_by_role("button", name="Save changes"))
        expect(page.get_by_role("heading", level=1)).to_have_text(f"{reference}-B")

        links = page.locator(".order-links")
        hand.press(links.get_by_role("button", name="Make a link"))
        address = links.get_by_label("Address of the customer").input_value()
        hand.press(links.get_by_role("button", name="Copy"))
        expect(links).to_contain_text("Copied")
        assert page.request.get(address).ok
        hand.press(links.get_by_role("button", name="Take all back"))
        hand.has_focus(links.get_by_role("button", name="Keep links"))
        hand.press(links.get_by_role("button", name="Take links back"))
        expect(links).to_contain_text("0 valid")
        hand.has_focus(links.get_by_role("button", name="Make a link"))

        head = page.locator(".order-head")
        hand.press(head.get_by_role("button", name="Cancel", exact=True))
        hand.has_focus(head.get_by_role("button", name="Keep order"))
        hand.press(head.get_by_role("button", name="Cancel order"))
        expect(head.locator(".tag").first).to_have_text("cancelled")

    def faults(self) -> None:
        """A vehicle loses its WLAN, and has it again."""
        page, hand = self._page, self._hand
        hand.press(page.get_by_role("navigation", name="Views").get_by_role("link", name="Fleet"))
        hand.press(page.get_by_role("row").filter(has_text="ATV2").get_by_role("button").first)
        card = page.locator(".card.atv")
        expect(card.get_by_role("heading")).to_contain_text("ATV2")
        faults = card.get_by_role("button", name="Faults")
        hand.press(faults)
        hand.press(page.get_by_role("button", name="Cut its WLAN"))
        hand.has_focus(faults)
        hand.press(card.get_by_role("button", name="Bring back: WLAN cut"))
        expect(card).not_to_contain_text("Bring back")

    def report(self) -> None:
        """The last shift is printed for the hand-over."""
        page, hand = self._page, self._hand
        hand.press(page.get_by_role("navigation", name="Views").get_by_role("link", name="Figures"))
        hand.press(page.get_by_role("link", name="Shift report"))
        hand.press(page.get_by_role("button", name="Print or PDF"))
        assert page.evaluate("window.printed") == 1


@pytest.mark.parametrize(
    ("locale", "add", "wrong", "missing"),
    [
        ("de-DE", "Hinzufügen", "Nur kleine Buchstaben", "Bediener brauchen einen Bereich"),
        ("es-ES", "Añadir", "Solo letras minúsculas", "Un operario necesita una zona"),
    ],
)
def test_what_is_wrong_with_a_field_is_told_in_the_readers_language(
    factory: str,
    open_page: OpenPage,
    screenshot: Screenshot,
    complaints: Complaints,
    locale: str,
    add: str,
    wrong: str,
    missing: str,
) -> None:
    page = open_page("about:blank", visits=factory, locale=locale)
    page.add_init_script(UNHURRIED)
    page.goto(f"{factory}/#people")
    page.locator("[popovertarget=person-sheet]").first.click()
    sheet = page.locator("#person-sheet")
    sheet.locator("#people-id").fill("Ana Weber")
    sheet.get_by_role("button", name=add, exact=True).click()
    expect(sheet.locator("#people-id-wrong")).to_contain_text(wrong)
    expect(sheet.locator("#people-areas-wrong")).to_contain_text(missing)
    screenshot(page, f"people-wrong-{locale}")
    forgive(complaints, "422")

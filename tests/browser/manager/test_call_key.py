"""The key of a call button is made in the panel: its page is told with a code, and a sign to be hung up at the station."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Locator, Page, expect

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

PHONE = {"width": 390, "height": 844}


def made(page: Page, *places: str) -> Locator:
    """The sheet, when it shows the key of these places."""
    page.get_by_role("button", name="Make a key…").click()
    sheet = page.locator("#key-sheet")
    sheet.get_by_label("For what").fill("Button")
    sheet.get_by_label("call for transports").check()
    for place in places:
        sheet.locator("fieldset", has_text="Only to and from").get_by_label(
            re.compile(f"^{place}\\b")
        ).check()
    sheet.get_by_role("button", name="Make the key").click()
    expect(sheet.get_by_label("The key", exact=True)).to_have_value(re.compile("^dray_"))
    return sheet


def expect_drawn(image: Locator) -> None:
    """The image has come from the gateway."""
    image.scroll_into_view_if_needed()
    image.evaluate("image => image.decode()")
    assert image.evaluate("image => image.naturalWidth") > 0


def test_the_key_of_a_station_is_shown_with_its_page_and_a_sign_to_print(
    forms: Any, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(f"{forms.url}/#people")
    sheet = made(page, "M8")
    token = sheet.get_by_label("The key", exact=True).input_value()
    address = f"{forms.url}/call/{token}"
    expect(sheet.get_by_label("Address of the page")).to_have_value(address)
    expect_drawn(sheet.get_by_role("img", name="QR code of the page"))
    screenshot(page, "call-key")
    with page.expect_popup() as opened:
        sheet.get_by_role("link", name="Sign to print").click()
    sign = opened.value
    expect(sign.get_by_role("heading", level=1)).to_have_text("M8")
    expect(sign.get_by_text(address)).to_be_visible()
    expect_drawn(sign.get_by_role("img", name="QR code"))
    screenshot(sign, "call-sign")
    sign.emulate_media(media="print")
    expect(sign.get_by_text("Print this page")).to_be_hidden()
    expect(sign.get_by_role("navigation")).to_be_hidden()
    screenshot(sign, "call-sign-printed", audited=False)


def test_a_key_of_two_stations_has_no_page(forms: Any, open_page: OpenPage) -> None:
    sheet = made(open_page(f"{forms.url}/#people"), "M8", "M9")
    expect(sheet.get_by_label("Address of the page")).to_have_count(0)
    expect(sheet.get_by_role("img")).to_have_count(0)


@pytest.mark.parametrize(
    ("locale", "words"), [("de-DE", "Mit dem Handy einlesen"), ("es-ES", "Escanéelo con un móvil")]
)
def test_a_sign_needs_no_script_and_fits_a_phone(
    forms: Any, open_page: OpenPage, screenshot: Screenshot, locale: str, words: str
) -> None:
    wanted = {"name": "Button", "scopes": ["transports:call"], "places": ["M8"]}
    url = forms.ask("/api/keys", wanted)["page_url"]
    sign = open_page(f"{url}/sign", who=None, locale=locale, viewport=PHONE, java_script_enabled=False)
    expect(sign.get_by_text(words)).to_be_visible()
    expect(sign.get_by_text(url)).to_be_visible()
    screenshot(sign, f"call-sign-{locale}", whole=True)


@pytest.mark.parametrize(
    ("locale", "words", "bring", "called"),
    [
        ("en-GB", "Something else, as an empty container", "Bring it here", "called"),
        ("de-DE", "Etwas anderes, zum Beispiel ein leerer Behälter", "Hierher bringen", "gerufen"),
        ("es-ES", "Otra cosa, por ejemplo un contenedor vacío", "Traer aquí", "pedido"),
    ],
)
def test_a_thing_is_called_for_on_a_phone_without_a_script(
    forms: Any, open_page: OpenPage, screenshot: Screenshot, locale: str, words: str, bring: str, called: str
) -> None:
    wanted = {"name": "Button", "scopes": ["transports:call"], "places": ["M8"]}
    url = forms.ask("/api/keys", wanted)["page_url"]
    page = open_page(url, who=None, locale=locale, viewport=PHONE, java_script_enabled=False)
    page.locator("summary", has_text=words).click()
    form = page.locator(".call-thing form")
    screenshot(page, f"call-thing-{locale}", whole=True)
    form.locator("input[name=thing]").fill("pump housing <Meier>")
    form.locator("select[name=place]").select_option("S3")
    form.get_by_role("button", name=bring).click()
    job = page.locator(".call-list li", has_text="pump housing <Meier>")
    expect(job).to_contain_text(called)
    # What was called is in sight, also once it is looked at again.
    expect(job).to_be_in_viewport()
    page.locator(".call-list p > a").first.click()
    expect(job).to_be_in_viewport()
    job.get_by_role("button").click()
    screenshot(page, f"call-thing-called-{locale}", whole=True)

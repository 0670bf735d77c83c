"""A scanner at a tablet: a keyboard that types a code and ends it with Enter."""

from __future__ import annotations

from playwright.sync_api import Page

KEYS = """keys => keys.forEach(key => {
  (document.activeElement ?? document.body).dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true }));
})"""


def scan(page: Page, code: str) -> None:
    """All keys at one moment, however busy the computer is: so fast that no person could."""
    page.evaluate(KEYS, [*code, "Enter"])

"""A factory that runs at ten times the pace of the clock on the wall: its figures say by which clock they are."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect


@pytest.fixture
def factory(busy: Any) -> str:
    return str(busy.url)


def test_figures_and_prices_say_that_they_are_factory_time(
    factory: str, open_page: Callable[..., Page], screenshot: Callable[..., Path]
) -> None:
    page = open_page(factory)
    expect(page.locator(".auction .bid .num").first).to_be_visible()
    expect(page.locator(".auction .why")).to_contain_text("Durations here are factory time.")
    expect(page.locator(".auction .bid-bar").first).to_have_accessible_name(re.compile("of factory time"))
    expect(page.locator(".factory").get_by_role("heading")).to_have_text("Factory (factory time)")
    screenshot(page, "clock-manager")

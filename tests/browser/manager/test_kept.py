"""What is kept for how long, in a real browser: managers are told, and a list that reaches back further says so."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from complaints import Complaints
from playwright.sync_api import Page, expect

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]


def test_a_manager_is_told_what_is_kept_for_how_long(
    forms: Any, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(f"{forms.url}/#audit")
    page.get_by_role("button", name="What is kept").click()
    sheet = page.get_by_role("dialog", name="What is kept for how long")
    expect(sheet.get_by_role("row")).to_have_count(11)
    expect(sheet.get_by_role("row", name="Log of what vehicles and machines told")).to_contain_text("14 days")
    expect(sheet.get_by_role("row", name="Orders")).to_contain_text("as long as the database")
    screenshot(page, "kept")


@pytest.mark.parametrize("view", ["audit", "tasks", "alerts"])
def test_a_list_that_reaches_back_beyond_what_is_kept_says_so(
    forms: Any, open_page: OpenPage, view: str
) -> None:
    page = open_page(f"{forms.url}/#{view}?since=2020-01-01T00:00")
    expect(page.get_by_role("status").filter(has_text="are no longer kept (400 days)")).to_be_visible()


def test_a_moment_that_is_no_longer_kept_says_since_when_there_is_something(
    forms: Any, open_page: OpenPage, screenshot: Screenshot, complaints: Complaints
) -> None:
    page = open_page(f"{forms.url}/#replay/1577836800.0")
    expect(page.get_by_role("status").filter(has_text="is no longer kept (14 days)")).to_be_visible()
    expect(page.get_by_text(re.compile(r"Nothing is kept of \d"))).to_be_visible()
    screenshot(page, "replay-no-longer-kept")
    # The browser tells of every 404 by itself, and of nothing else; none comes after the page is left.
    page.goto("about:blank")
    assert all("status of 404" in each for each in complaints)
    complaints.clear()

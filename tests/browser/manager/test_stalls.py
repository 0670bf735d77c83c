"""The management panel before a slow server and a stream that stalls: it says so, and catches up."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page, Route, WebSocketRoute, expect

OpenPage = Callable[..., Page]


class Stream:
    """The stream of a page, which can be stalled: it stays open, and nothing comes any more."""

    def __init__(self, page: Page) -> None:
        self.stalled = False
        page.route_web_socket("**/api/stream", self._route)

    def _route(self, browser: WebSocketRoute) -> None:
        server = browser.connect_to_server()
        server.on_message(lambda frame: None if self.stalled else browser.send(frame))


@pytest.mark.slow
def test_a_stream_that_stalls_is_shown_as_old_with_its_age_and_afterwards_as_new(
    forms: Any, open_page: OpenPage
) -> None:
    page = open_page("about:blank", visits=forms.url)
    page.clock.install()
    stream = Stream(page)
    page.goto(forms.url)
    expect(page.locator(".live-live").first).to_be_visible()
    stream.stalled = True
    page.clock.run_for(6_000)
    expect(page.locator(".map-age")).to_be_visible()
    stream.stalled = False
    # The next frame does not follow the last one that came: only a fresh snapshot helps.
    page.clock.run_for(1_000)
    expect(page.locator(".map-age")).to_be_hidden()
    expect(page.locator(".live-live").first).to_be_visible()


@pytest.mark.slow
def test_a_server_that_takes_its_time_leaves_a_page_that_says_what_it_waits_for(
    forms: Any, open_page: OpenPage
) -> None:
    page, held = open_page("about:blank", visits=forms.url), list[Route]()

    def hold(route: Route) -> None:
        held.append(route)

    page.route("**/api/plant", hold)
    page.goto(forms.url)
    waiting = page.locator(".map-waiting")
    expect(waiting).to_be_visible()
    expect(waiting).not_to_be_empty()
    for route in held:
        route.continue_()
    expect(page.locator("#plant-map canvas").first).to_be_visible()
    expect(waiting).to_be_hidden()

"""What there is to complain of in a page: errors, other hosts, and what breaks WCAG 2.2 AA."""

from __future__ import annotations

from urllib.parse import urlsplit

from accessibility import violations
from playwright.sync_api import ConsoleMessage, Page, Request, WebSocket


class Complaints(list[str]):
    """The complaints about all pages of one test."""

    def __init__(self) -> None:
        super().__init__()
        self.without_script: list[Page] = []

    def watch(self, page: Page) -> None:
        page.on("console", self._console)
        page.on("pageerror", lambda error: self.append(f"exception: {error}"))
        page.on("request", self._asked)
        page.on("requestfailed", self._failed)
        page.on("websocket", lambda socket: self._streamed(page, socket))

    def audit(self, page: Page) -> None:
        """Add what the page breaks of WCAG 2.2 AA as it is now."""
        # Without scripts there is nothing to run axe in; such a page is audited with them.
        if page not in self.without_script and not page.is_closed() and page.url != "about:blank":
            self.extend(violations(page))

    def _console(self, message: ConsoleMessage) -> None:
        if message.type in {"error", "warning"}:
            self.append(f"console {message.type}: {message.text}")

    def _asked(self, request: Request) -> None:
        if not request.is_navigation_request():
            self._only_its_server(request.frame.url, request.url)

    def _streamed(self, page: Page, socket: WebSocket) -> None:
        self._only_its_server(page.url, socket.url)

    def _only_its_server(self, page_url: str, url: str) -> None:
        if urlsplit(url).scheme != "data" and urlsplit(url).netloc != urlsplit(page_url).netloc:
            self.append(f"{page_url} asked another host: {url}")

    def _failed(self, request: Request) -> None:
        self.append(f"request failed: {request.method} {request.url}: {request.failure}")

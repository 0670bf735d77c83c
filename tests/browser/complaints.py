"""What there is to complain of in a page: errors, other hosts, and what breaks WCAG 2.2 AA."""

from __future__ import annotations

from urllib.parse import urlsplit

from accessibility import AUDITED, violations
from playwright.sync_api import ConsoleMessage, Page, Request, WebSocket

GIVEN_UP = "WebSocket is closed before the connection is established"


class Complaints(list[str]):
    """The complaints about all pages of one test."""

    def __init__(self) -> None:
        super().__init__()
        self.without_script: list[Page] = []
        """There is nothing to run axe in; such pages are audited with their scripts."""

    def watch(self, page: Page) -> None:
        page.on("console", self._console)
        page.on("pageerror", lambda error: self.append(f"exception: {error}"))
        page.on("request", self._asked)
        page.on("requestfailed", self._failed)
        page.on("websocket", lambda socket: self._streamed(page, socket))

    def audit(self, page: Page) -> None:
        """Add what the page breaks of WCAG 2.2 AA as it is now."""
        if page not in self.without_script and not page.is_closed() and page.url != "about:blank":
            self.extend(violations(page))

    def audit_once(self, page: Page) -> None:
        """Audit it, unless that has been done in some state of it."""
        if page not in AUDITED:
            self.audit(page)

    def _console(self, message: ConsoleMessage) -> None:
        page = message.page
        # A page that is itself the answer 410, say, tells so in its text.
        if page is not None and message.location["url"] == page.url and "status of 4" in message.text:
            return
        # A page gives a stream up that takes too long to open, and tries anew: so it should on a computer that is busy.
        if GIVEN_UP in message.text and "/api/stream" in message.text:
            return
        if message.type in {"error", "warning"}:
            self.append(f"console {message.type}: {message.text}")

    def _asked(self, request: Request) -> None:
        if not request.is_navigation_request() and not _is_stop(request):
            self._only_its_server(request.frame.url, request.url)

    def _streamed(self, page: Page, socket: WebSocket) -> None:
        self._only_its_server(page.url, socket.url)

    def _only_its_server(self, page_url: str, url: str) -> None:
        if urlsplit(url).scheme != "data" and urlsplit(url).netloc != urlsplit(page_url).netloc:
            self.append(f"{page_url} asked another host: {url}")

    def _failed(self, request: Request) -> None:
        # A page that leaves lets go of what it was asking.
        if request.failure != "net::ERR_ABORTED":
            self.append(f"request failed: {request.method} {request.url}: {request.failure}")


def _is_stop(request: Request) -> bool:
    """Whether it is a stop, which goes another way as well: to another port of the same host, and nothing else does."""
    asked, page = urlsplit(request.url), urlsplit(request.frame.url)
    path = asked.path.startswith("/api/atvs/") and asked.path.endswith("/commands")
    return path and asked.hostname == page.hostname and '"kind":"stop"' in (request.post_data or "")

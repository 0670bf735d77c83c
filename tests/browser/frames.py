"""What comes over a page's stream, whichever socket it comes by: on a busy computer a page may connect anew."""

from __future__ import annotations

from collections.abc import Callable

from playwright.sync_api import Page, WebSocket

LOOK_MS = 50
"""From look to look whether it has come; Playwright hands on frames meanwhile."""


class Frames:
    """Waits for a frame.

    Args:
        page: has not gone anywhere yet.
        wanted: is asked about each frame until one is wanted.
    """

    def __init__(self, page: Page, wanted: Callable[[str | bytes], bool]) -> None:
        self._page, self._wanted, self._come = page, wanted, False
        page.on("websocket", self._opened)

    def wait(self, timeout_ms: float) -> None:
        """Until it has come, or came before.

        Raises:
            AssertionError: it has not come in time.
        """
        for _ in range(int(timeout_ms / LOOK_MS)):
            if self._come:
                return
            self._page.wait_for_timeout(LOOK_MS)
        raise AssertionError(f"no frame within {timeout_ms:.0f} ms is the one that was waited for")

    def _opened(self, socket: WebSocket) -> None:
        socket.on("framereceived", self._take)

    def _take(self, payload: str | bytes) -> None:
        self._come = self._come or self._wanted(payload)

"""What comes over a page's stream, whichever socket it comes by: on a busy computer a page may connect anew."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from playwright.sync_api import Page, WebSocket

from dray.gateway.live.frames import COLLECTIONS

LOOK_MS = 50
"""From look to look whether it has come; Playwright hands on frames meanwhile."""


class Frames:
    """Waits for a frame. What has changed of an entity is laid over what was told of it before, so that each is whole.

    Args:
        page: has not gone anywhere yet.
        wanted: is asked about each frame until one is wanted.
    """

    def __init__(self, page: Page, wanted: Callable[[dict[str, Any]], bool]) -> None:
        self._page, self._wanted, self._come = page, wanted, False
        self._whole: dict[tuple[str, str], dict[str, Any]] = {}
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

    def wait_while(self, passes: Callable[[], object], times: int) -> None:
        """Let something pass, time at a factory that stands, say, until it has come.

        Raises:
            AssertionError: it has not come after so many times.
        """
        for _ in range(times):
            if self._come:
                return
            passes()
            # A frame comes ten times a second at most.
            self._page.wait_for_timeout(2 * LOOK_MS)
        raise AssertionError(f"no frame of {times} is the one that was waited for")

    def _opened(self, socket: WebSocket) -> None:
        socket.on("framereceived", self._take)

    def _take(self, payload: str | bytes) -> None:
        if self._come:
            return
        frame = json.loads(payload)
        for kind in COLLECTIONS.values() & frame.keys():
            frame[kind] = [self._laid_over(kind, told) for told in frame[kind]]
        self._come = self._wanted(frame)

    def _laid_over(self, kind: str, told: dict[str, Any]) -> dict[str, Any]:
        whole = self._whole[kind, told["id"]] = self._whole.get((kind, told["id"]), {}) | told
        return whole

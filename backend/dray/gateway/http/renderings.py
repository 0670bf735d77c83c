"""Renderings: results of side work that stay right as long as their subject has the same version.

One piece of work serves all who ask for the same rendering meanwhile, and what it made is kept for later
ones. Nobody waits for a turn of somebody else: only work that has begun is shared.
"""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from collections.abc import Callable
from typing import TypeVarTuple

from dray.gateway.http.side_work import SideWork

Ts = TypeVarTuple("Ts")

KEPT_BYTES = 32 * 1024**2
"""Maximum bytes of what is kept; the one that was asked for longest ago goes first. The longest draft of a
plant takes 1 MiB as JSON, some more as YAML."""

Key = tuple[object, ...]
"""What was rendered, of which version, and how."""


class Renderings:
    """Makes renderings once, and keeps them.

    Args:
        side_work: does the work.
        kept_bytes: maximum bytes of what is kept.
    """

    def __init__(self, side_work: SideWork, kept_bytes: int = KEPT_BYTES) -> None:
        self._side_work, self._kept_bytes = side_work, kept_bytes
        self._kept: OrderedDict[Key, bytes] = OrderedDict()
        """The one asked for last comes last."""
        self._bytes = 0
        self._begun: dict[Key, asyncio.Event] = {}
        """Set when the work on it is over, whether well or not."""

    def get(self, key: Key) -> bytes | None:
        """A rendering that is kept; None if it is not."""
        made = self._kept.get(key)
        if made is not None:
            self._kept.move_to_end(key)
        return made

    def keep(self, key: Key, made: bytes) -> None:
        """Keep a rendering; one that is larger than all together may be is not kept."""
        if len(made) > self._kept_bytes:
            return
        self._bytes += len(made) - len(self._kept.pop(key, b""))
        self._kept[key] = made
        while self._bytes > self._kept_bytes:
            self._bytes -= len(self._kept.popitem(last=False)[1])

    async def of(self, key: Key, caller: str, work: Callable[[*Ts], bytes], *given: *Ts) -> bytes:
        """A rendering: the one that is kept, the one that is being made, or a new one.

        A failure is told to the caller whose work it was; others try themselves.

        Args:
            key: names the subject with its version, and the way of rendering.
            caller: the caller, for `SideWork.do`.
            work: makes it; see `SideWork.do`.
            given: its arguments.

        Raises:
            Problem: see `SideWork.do`.
            Exception: any exception of `work`.
        """
        while (made := self.get(key)) is None:
            begun = self._begun.get(key)
            if begun is not None:
                await begun.wait()
                continue
            async with self._side_work.turn(caller):
                # It may have been made, or begun, while this one waited.
                if key not in self._kept and key not in self._begun:
                    return await self._make(key, work, *given)
        return made

    async def _make(self, key: Key, work: Callable[[*Ts], bytes], *given: *Ts) -> bytes:
        over = self._begun[key] = asyncio.Event()
        try:
            made = await self._side_work.run(work, *given)
        finally:
            del self._begun[key]
            over.set()
        self.keep(key, made)
        return made

"""Calls from the gateway's loop into the thread of a simulated factory."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TypeVar

from dray.errors import UnavailableError

T = TypeVar("T")

ANSWER_S = 10.0
"""Timeout in wall seconds: a call takes a moment, but the factory may be busy."""


async def inside(loop: asyncio.AbstractEventLoop, call: Callable[[], T]) -> T:
    """Call something in the factory's thread.

    Args:
        loop: the factory's loop.
        call: the function to run there.

    Returns:
        Its result.

    Raises:
        UnavailableError: the factory has ended, or is too busy.
        Exception: any that `call` raises.
    """

    async def called() -> T:
        return call()

    coroutine = called()
    try:
        answer = asyncio.run_coroutine_threadsafe(coroutine, loop)
    except RuntimeError:
        # The loop is closed.
        coroutine.close()
        raise _away("it has ended") from None
    try:
        async with asyncio.timeout(ANSWER_S):
            return await asyncio.wrap_future(answer)
    except TimeoutError:
        raise _away(f"no answer within {ANSWER_S:g} s") from None


def _away(reason: str) -> UnavailableError:
    return UnavailableError("the simulated factory", reason, "look at the log of `dray up`")

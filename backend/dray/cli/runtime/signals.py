"""Signals that end a process: a graceful shutdown where possible, then an immediate end."""

from __future__ import annotations

import asyncio
import contextlib
import signal
from collections.abc import Callable, Generator

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


@contextlib.contextmanager
def stopped_by_signals(stop: Callable[[], None]) -> Generator[None]:
    """Call `stop` on the running loop at Ctrl-C or SIGTERM; a second one ends the process at once."""
    loop = asyncio.get_running_loop()

    def first() -> None:
        _leave_signals_alone(loop)
        stop()

    for each in _SIGNALS:
        loop.add_signal_handler(each, first)
    try:
        yield
    finally:
        _leave_signals_alone(loop)


@contextlib.contextmanager
def asked_by_signals(leave: Callable[[], None], stop: Callable[[], None], within_s: float) -> Generator[None]:
    """Call `leave` on the running loop at SIGTERM, and `stop` when that takes too long.

    Args:
        leave: begins a graceful shutdown.
        stop: ends it at once: at Ctrl-C, at a second SIGTERM, or after the timeout. The next signal
            ends the process.
        within_s: the timeout from the first SIGTERM (real seconds).
    """
    loop = asyncio.get_running_loop()
    waiting: list[asyncio.TimerHandle] = []

    def ask() -> None:
        loop.add_signal_handler(signal.SIGTERM, stop_now)
        waiting.append(loop.call_later(within_s, stop_now))
        leave()

    def stop_now() -> None:
        _leave_signals_alone(loop)
        stop()

    loop.add_signal_handler(signal.SIGTERM, ask)
    loop.add_signal_handler(signal.SIGINT, stop_now)
    try:
        yield
    finally:
        _leave_signals_alone(loop)
        for each in waiting:
            each.cancel()


def _leave_signals_alone(loop: asyncio.AbstractEventLoop) -> None:
    for each in _SIGNALS:
        loop.remove_signal_handler(each)

"""Spares: second declarations for the same keys, each made anew from time to time.

A router may lose another one's declaration, and then passes nothing on to it for as long as both run. That happens when a link
was closed and opened again, as after a kill or a pause of the computer: the router misses the declaration, or keeps a route
without it, and Zenoh never repeats it (eclipse-zenoh/zenoh#1886). A declaration that is withdrawn and made again reaches every
router, but messages in between would be lost. So the declaration itself stays, and a spare beside it is made anew. It matches
the same keys in another form: `X/**` beside `X`. What comes by either reaches the process once, and goes to the callback of the
declaration itself.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from typing import Protocol

import zenoh
from zenoh.handlers import Callback, RingChannel

RENEWED_S = 5.0
"""Time between two turns, each of two spares (s). In a plant of 300 agents a process takes in 240 messages a second of these,
and three times as many with a simulated floor. One costs it 0.03 ms."""

ANY = "/**"
"""The end of a pattern for all keys below."""


class Declaration(Protocol):
    """A Zenoh subscriber, token or queryable."""

    def undeclare(self) -> object:
        """Withdraw it."""


def other_form(pattern: str) -> str:
    """Another pattern for the keys of this one.

    A pattern that ends with `/**` also matches what stands before that; no message has such a key.
    """
    return f"{pattern.removesuffix(ANY)}/*{ANY}" if pattern.endswith(ANY) else f"{pattern}{ANY}"


class Spares:
    """The spares of one session's declarations, by key.

    Each turn makes the first spare anew, as that of an agent's own key, because answers depend on it, and one of the others. None
    is made before its first turn: who leaves sooner needs none. Turns are on the event loop that runs when it is created, and end
    with the Zenoh session.

    Args:
        inner: Zenoh's session.
    """

    def __init__(self, inner: zenoh.Session) -> None:
        self._inner = inner
        self._lock = threading.Lock()
        """A process that ends withdraws the spares of all its threads."""
        self._makes: dict[str, Callable[[], Declaration]] = {}
        """By key, what makes its spare."""
        self._made: dict[str, Declaration] = {}
        """By key, the spare that is declared now."""
        self._turns = 0
        """Turns so far; the other spares' turns go round by it."""
        self._ended = False
        self._turn_later()

    def of_subscription(self, key: str) -> None:
        """Keep a spare of a subscription."""
        # The channel is Zenoh's own: Python is not called for a message a second time.
        self._makes[key] = lambda: self._inner.declare_subscriber(other_form(key), RingChannel(1))

    def of_queryable(self, key: str) -> None:
        """Keep a spare of a queryable."""
        silence = Callback(_leave_it, indirect=False)
        self._makes[key] = lambda: self._inner.declare_queryable(other_form(key), silence)

    def of_token(self, key: str) -> None:
        """Keep a liveliness token that is a spare of another one."""
        self._makes[key] = lambda: self._inner.liveliness().declare_token(key)

    def withdraw(self, key: str) -> None:
        """Withdraw a spare; it is not made again."""
        with self._lock:
            del self._makes[key]
            self._undeclare(key)

    def end(self) -> None:
        """Withdraw all. Twice is harmless."""
        with self._lock:
            self._ended = True
            for key in tuple(self._made):
                self._undeclare(key)

    def _renew(self, key: str) -> None:
        self._undeclare(key)
        self._made[key] = self._makes[key]()

    def _undeclare(self, key: str) -> None:
        made = self._made.pop(key, None)
        if made is not None:
            made.undeclare()

    def _turn_later(self) -> None:
        asyncio.get_running_loop().call_later(RENEWED_S, self._turn)

    def _turn(self) -> None:
        with self._lock:
            if self._ended or self._inner.is_closed():
                return
            if self._makes:
                first, *others = self._makes
                self._renew(first)
                if others:
                    self._renew(others[self._turns % len(others)])
                self._turns += 1
        self._turn_later()


def _leave_it(query: zenoh.Query) -> None:
    """Give no answer: the queryable itself gives it."""
    query.drop()

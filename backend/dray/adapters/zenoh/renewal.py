"""Renewal: a session's declarations, each made anew from time to time.

A router may lose another one's declaration, and then passes nothing on to it for as long as both run: when a link was closed and
opened again, as after a kill or a pause of the computer, a router may miss a declaration, or keep a route without it, and
Zenoh never repeats it (eclipse-zenoh/zenoh#1886). A declaration that is withdrawn and made again reaches every router.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Protocol

RENEWED_S = 5.0
"""Time between two renewals of a session, each of one declaration (s). In a plant of 300 agents a process takes in 120 such messages
a second."""


class Declaration(Protocol):
    """A Zenoh subscriber, token or queryable."""

    def undeclare(self) -> None:
        """Withdraw it."""


class Renewal:
    """The declarations of one session, by key. Use it on the loop on which it was created.

    Every second renewal is of the first declaration, as of an agent's own key: answers depend on it. The others take turns. What comes
    between withdrawal and declaration is lost, as on any link.
    """

    def __init__(self) -> None:
        self._made: dict[str, tuple[Declaration, Callable[[], Declaration]]] = {}
        self._turns = 0

    def declare(self, key: str, make: Callable[[], Declaration]) -> None:
        """Make a declaration, now and again until it is withdrawn."""
        is_first = not self._made
        self._made[key] = make(), make
        if is_first:
            self._renew_later()

    def withdraw(self, key: str) -> None:
        """Withdraw a declaration."""
        made, _ = self._made.pop(key)
        made.undeclare()

    def end(self) -> None:
        """Withdraw all, the latest first."""
        for key in reversed(tuple(self._made)):
            self.withdraw(key)

    def _renew_later(self) -> None:
        asyncio.get_running_loop().call_later(RENEWED_S, self._renew)

    def _renew(self) -> None:
        if not self._made:
            return
        first, *others = self._made
        turn, is_others = divmod(self._turns, 2)
        self._turns += 1
        key = others[turn % len(others)] if others and is_others else first
        made, make = self._made[key]
        made.undeclare()
        self._made[key] = make(), make
        self._renew_later()

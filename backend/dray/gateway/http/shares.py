"""Shares: where all callers have one bound together, one of them may use up a part of it.

So a program that asks in a loop, or a key that was stolen, takes nothing from the others.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from http import HTTPStatus

from dray.gateway.http.problems import FieldError, Problem

PARTS = 4
"""One caller has one of them: three others can do the same at the same time."""

AGAIN_S = 600
"""When to try again where things are open for hours or days."""


def share_of(most: int, parts: int = PARTS) -> int:
    """How much of a bound for all callers is for one of them: at least one."""
    return max(1, most // parts)


def share_used(what: str, most: int, do: str, *, again_s: int = AGAIN_S, parts: int = PARTS) -> Problem:
    """One caller has as much as it may have.

    Args:
        what: in the plural, as `open transports`.
        most: how many all callers may have together.
        do: what to do about it.
        again_s: seconds after which it is worth while to try again.
        parts: in how many shares the bound is cut.
    """
    share = share_of(most, parts)
    return Problem(
        HTTPStatus.TOO_MANY_REQUESTS,
        "share-used",
        "You have as many as one caller may have",
        f"of {most} {what} one caller may have {share}, and you do; {do}",
        errors=[FieldError.of("caller", "share_used", most=share)],
        headers={"Retry-After": str(again_s)},
    )


class Shares:
    """How much of a bound for all callers each of them has at this moment.

    Args:
        most: the bound.
        what: of what, in the plural, as `files that are being read`.
        again_s: seconds after which it is worth while to try again.
    """

    def __init__(self, most: int, what: str, *, again_s: int) -> None:
        self._share, self._most = share_of(most), most
        self._what, self._again_s = what, again_s
        self._taken: Counter[str] = Counter()

    def take(self, caller: str) -> None:
        """Take one; `give_back` is for when it is done with.

        Args:
            caller: by kind and id (`Principal.key`).

        Raises:
            Problem: 429, the caller has its share.
        """
        if self._taken[caller] >= self._share:
            raise share_used(
                self._what, self._most, "wait until one of yours has ended", again_s=self._again_s
            )
        self._taken[caller] += 1

    def give_back(self, caller: str) -> None:
        """One is done with."""
        self._taken[caller] -= 1
        if not self._taken[caller]:
            del self._taken[caller]

    @contextmanager
    def taken(self, caller: str) -> Iterator[None]:
        """Have one for as long as this is open.

        Raises:
            Problem: 429, the caller has its share.
        """
        self.take(caller)
        try:
            yield
        finally:
            self.give_back(caller)

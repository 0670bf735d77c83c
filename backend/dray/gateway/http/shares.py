"""Shares: where all callers have one bound together, one of them may use up a part of it.

So a program that asks in a loop, or a key that was stolen, takes nothing from the others.
"""

from __future__ import annotations

from http import HTTPStatus

from dray.gateway.http.problems import FieldError, Problem

PARTS = 4
"""One caller has one of them: three others can do the same at the same time."""

AGAIN_S = 600
"""When to try again where things are open for hours or days."""


def share_of(most: int, parts: int = PARTS) -> int:
    """How much of a bound for all callers is for one of them: at least one."""
    return max(1, most // parts)


def share_used(
    what: str, most: int, do: str, *, again_s: int | None = AGAIN_S, parts: int = PARTS
) -> Problem:
    """One caller has as much as it may have.

    Args:
        what: in the plural, as `open transports`.
        most: how many all callers may have together.
        do: what to do about it.
        again_s: seconds after which it is worth while to try again; None where time alone changes nothing.
        parts: in how many shares the bound is cut.
    """
    share = share_of(most, parts)
    return Problem(
        HTTPStatus.TOO_MANY_REQUESTS,
        "share-used",
        "You have as many as one caller may have",
        f"of {most} {what} one caller may have {share}, and you do; {do}",
        errors=[FieldError.of("caller", "share_used", most=share)],
        headers=None if again_s is None else {"Retry-After": str(again_s)},
    )

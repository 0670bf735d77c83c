"""Shares: of a limit for all callers together, one caller may use only a part.

So a program in a loop, or a stolen key, takes nothing from the others.
"""

from __future__ import annotations

from http import HTTPStatus

from dray.gateway.http.problems import FieldError, Problem

PARTS = 4
"""Number of shares of a limit: three other callers can do the same at the same time."""

AGAIN_S = 600
"""Seconds before a retry where things stay open for hours or days."""


def share_of(most: int, parts: int = PARTS) -> int:
    """One caller's share of a limit: at least one."""
    return max(1, most // parts)


def share_used(
    what: str, most: int, do: str, *, again_s: int | None = AGAIN_S, parts: int = PARTS
) -> Problem:
    """The problem of a caller who has used up its share.

    Args:
        what: the things in the plural, such as `open transports`.
        most: the limit of all callers together.
        do: what to do about it.
        again_s: seconds before a retry makes sense; None where time alone changes nothing.
        parts: number of shares of the limit.
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

"""A finding: whether one thing is there that service needs, what was seen of it, and what to do."""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum

import msgspec

NAMED_MOST = 8
"""Names in one finding; of more the number is told."""


class Verdict(StrEnum):
    """Whether something is there."""

    OK = "ok"
    MISSING = "missing"
    UNKNOWN = "unknown"
    """It cannot be told from here."""


class Finding(msgspec.Struct, frozen=True):
    """What was found of one thing.

    Attributes:
        name: of the thing.
        verdict: whether it is there.
        seen: what was seen.
        todo: what to do, with the command; empty where there is nothing to do.
    """

    name: str
    verdict: Verdict
    seen: str
    todo: str = ""


def ok(name: str, seen: str, todo: str = "") -> Finding:
    """It is there; `todo` may say what would be better still."""
    return Finding(name, Verdict.OK, seen, todo)


def missing(name: str, seen: str, todo: str) -> Finding:
    """It is not there, or not as it must be."""
    return Finding(name, Verdict.MISSING, seen, todo)


def unknown(name: str, seen: str, todo: str = "") -> Finding:
    """Nobody can tell from here."""
    return Finding(name, Verdict.UNKNOWN, seen, todo)


def named(names: Iterable[str]) -> str:
    """Names in a sentence; of many the first ones, and how many more there are."""
    all_ = list(names)
    more = len(all_) - NAMED_MOST
    return ", ".join(all_[:NAMED_MOST]) + (f" and {more} more" if more > 0 else "")

"""A finding: one requirement for service, the observation, and the remedy."""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum

import msgspec

NAMED_MOST = 8
"""Maximum names in one finding; further ones are only counted."""


class Verdict(StrEnum):
    """Whether a requirement is met."""

    OK = "ok"
    MISSING = "missing"
    UNKNOWN = "unknown"
    """It cannot be checked from here."""


class Finding(msgspec.Struct, frozen=True):
    """The result for one requirement.

    Attributes:
        name: the requirement's name.
        verdict: whether it is met.
        seen: the observation.
        todo: the remedy, with the command; empty for none.
    """

    name: str
    verdict: Verdict
    seen: str
    todo: str = ""


def ok(name: str, seen: str, todo: str = "") -> Finding:
    """The requirement is met; `todo` may suggest an improvement."""
    return Finding(name, Verdict.OK, seen, todo)


def missing(name: str, seen: str, todo: str) -> Finding:
    """The requirement is not met."""
    return Finding(name, Verdict.MISSING, seen, todo)


def unknown(name: str, seen: str, todo: str = "") -> Finding:
    """It cannot be checked from here."""
    return Finding(name, Verdict.UNKNOWN, seen, todo)


def named(names: Iterable[str]) -> str:
    """Names in a sentence; of many only the first ones, and the number of the others."""
    all_ = list(names)
    more = len(all_) - NAMED_MOST
    return ", ".join(all_[:NAMED_MOST]) + (f" and {more} more" if more > 0 else "")

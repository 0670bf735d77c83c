"""Closures for tests, sealed as vehicles in tests trust it."""

from __future__ import annotations

from typing import Any

from seals import seal

from dray.messages import Closure, ClosureKind, Closures, closed_words


def closure(name: str = "K1", kind: ClosureKind = ClosureKind.CLOSED, **what: Any) -> Closure:
    """A decision of the manager: a lane (`start`, `end`), a node or an area."""
    return Closure(closure=name, kind=kind, by="manager", **what)


def closures(number: int, *closed: Closure) -> Closures:
    """The whole list."""
    return Closures(number=number, signature=seal(closed_words(number, closed)), closures=closed)

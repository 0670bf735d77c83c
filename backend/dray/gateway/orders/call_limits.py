"""What a key may not call for, and when it has called for enough.

Whoever has the key of a call button can do what its button can, and no more: something is brought to its places or taken away from them,
of its materials, no sooner than its priority allows, and only so much at once.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime
from http import HTTPStatus

from dray.gateway.access.principal import CallLimits
from dray.gateway.http.problems import FieldError, Problem
from dray.gateway.orders.transport_draft import TransportDraft
from dray.priorities import TRANSPORT_WITHIN_S, Priority

AGAIN_S = 60
"""Seconds after which it is worth while to call again: a transport takes some minutes."""

LATE_S = 30.0
"""By which a due time may be sooner than the priority allows: a request is on its way for some seconds, and clocks differ."""


def refuse_beyond(
    limits: CallLimits, draft: TransportDraft, source: str, destination: str, begin_s: float, speed: float
) -> None:
    """Refuse what a key may not call for.

    Args:
        limits: of the key.
        draft: what it calls for.
        source: from where, also where the draft leaves that open.
        destination: to where, likewise.
        begin_s: when it begins; wall clock.
        speed: plant seconds in a wall second.

    Raises:
        Problem: 403; it names each field, and what the key may.
    """
    errors = []
    if limits.places and limits.places.isdisjoint((source, destination)):
        field = "to" if draft.to is not None else "from"
        errors.append(FieldError.of(field, "only_for", place=", ".join(sorted(limits.places))))
    if limits.items and (draft.item is None or draft.item not in limits.items):
        errors.append(FieldError.of("item", "only_items", items=", ".join(sorted(limits.items))))
    within_s = TRANSPORT_WITHIN_S[limits.priority]
    if TRANSPORT_WITHIN_S[draft.priority] < within_s:
        errors.append(FieldError.of("priority", "only_priority", most=limits.priority.value))
    soonest_s = -math.inf if limits.priority is Priority.URGENT else begin_s + within_s / speed
    if draft.due_at is not None and draft.due_at.timestamp() < soonest_s - LATE_S:
        soonest = datetime.fromtimestamp(soonest_s, UTC).isoformat(timespec="seconds")
        errors.append(FieldError.of("due_at", "only_later", most=limits.priority.value, soonest=soonest))
    if errors:
        raise Problem(
            HTTPStatus.FORBIDDEN,
            "beyond-key",
            "This key may not call for that",
            "; ".join(f"{each.field}: {each.reason}" for each in errors),
            errors=errors,
        )


def refuse_full(
    limits: CallLimits, source: str, destination: str, open_ends: Sequence[tuple[str, str]]
) -> None:
    """Refuse a call of a key of which as much is open as may be.

    Args:
        limits: of the key.
        source: from where.
        destination: to where.
        open_ends: source and destination of what it has open.

    Raises:
        Problem: 429; it names the bound.
    """
    errors = []
    if len(open_ends) >= limits.open_max:
        errors.append(FieldError.of("key", "key_full", most=limits.open_max))
    at_places = Counter(place for ends in open_ends for place in _counted(limits, ends))
    for place in sorted(_counted(limits, (source, destination))):
        if at_places[place] >= limits.open_each_max:
            field = "to" if place == destination else "from"
            errors.append(FieldError.of(field, "key_full_at", place=place, most=limits.open_each_max))
    if errors:
        raise Problem(
            HTTPStatus.TOO_MANY_REQUESTS,
            "key-full",
            "As many calls of this key are open as may be",
            "; ".join(each.reason for each in errors),
            errors=errors,
            headers={"Retry-After": str(AGAIN_S)},
        )


def _counted(limits: CallLimits, ends: Iterable[str]) -> set[str]:
    """The places at which a transport counts: those of the key; of a key of all places the one to which it goes."""
    source, destination = ends
    return {source, destination} & limits.places if limits.places else {destination}

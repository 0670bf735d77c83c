"""Limits of a key for transports: what it may call for, and how much at once.

A stolen call button's key can do no more than the button: transports to or from its places, of its materials,
no sooner than its priority allows, and a limited number at once.
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
"""Seconds after which a new call is worth while: a transport takes some minutes."""

LATE_S = 30.0
"""Tolerance in seconds for a due time sooner than the priority allows: requests take seconds, and clocks
differ."""


def refuse_beyond(
    limits: CallLimits, draft: TransportDraft, source: str, destination: str, begin_s: float, speed: float
) -> None:
    """Refuse a call beyond a key's limits.

    Args:
        limits: the key's limits.
        draft: the call.
        source: its source, even if the draft leaves it open.
        destination: its destination, likewise.
        begin_s: its begin, wall clock.
        speed: plant seconds per wall second.

    Raises:
        Problem: 403; names each field and its limit.
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
    """Refuse a call of a key that has reached its maximum of open calls.

    Args:
        limits: the key's limits.
        source: the call's source.
        destination: the call's destination.
        open_ends: source and destination of each open call.

    Raises:
        Problem: 429; names the limit.
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
            "This key has its maximum of open calls",
            "; ".join(each.reason for each in errors),
            errors=errors,
            headers={"Retry-After": str(AGAIN_S)},
        )


def _counted(limits: CallLimits, ends: Iterable[str]) -> set[str]:
    """A transport's places that count: the key's, or the destination if the key has all."""
    source, destination = ends
    return {source, destination} & limits.places if limits.places else {destination}

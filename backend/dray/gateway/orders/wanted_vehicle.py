"""Why the only vehicle that may carry a transport does not: by its own last words, and its last answer to the announcement."""

from __future__ import annotations

from typing import Literal

from dray.gateway.live.projection import Projection
from dray.gateway.live.views import AtvView
from dray.store.orders.transports import TransportRow

Unwilling = Literal[
    "gone",
    "silent",
    "shut_out",
    "carried_away",
    "out_of_service",
    "error",
    "stopped",
    "busy",
    "battery",
    "charging",
]
"""What a vehicle is by its own words, or by its silence, and so carries nothing."""


def why_not(row: TransportRow, projection: Projection, now_s: float) -> str | None:
    """Why the wanted vehicle does not carry a transport that waits for it.

    Args:
        row: the transport.
        projection: what the vehicle has told.
        now_s: wall clock.

    Returns:
        What it is (`Unwilling`), or the reason for which it has not bid (`Refusal`). None where no vehicle is wanted any more, it is not to begin yet, somebody carries it, or nothing keeps it that is known.
    """
    if not row.vehicle or row.carrier or row.has_ended or row.is_held:
        return None
    if row.vehicle_until_s is not None and row.vehicle_until_s <= now_s:
        return None
    view = projection.atvs.view(row.vehicle)
    if view is None:
        return "gone"
    silent_s = (now_s - view.seen_at_s) * projection.speed
    if view.shut_out is None and view.removal is None and silent_s > view.silence.lost_after_s:
        return "silent"
    return _by_its_words(view) or _by_its_answer(row, projection)


def _by_its_words(view: AtvView) -> Unwilling | None:
    states: dict[Unwilling, bool] = {
        "shut_out": view.shut_out is not None,
        "carried_away": view.removal is not None,
        "out_of_service": view.out_of_service is not None,
        "error": view.status == "error",
        "stopped": view.status == "stopped",
        "busy": view.task is not None,
        "battery": view.battery_low,
        "charging": view.sent_to_charge,
    }
    return next((name for name, holds in states.items() if holds), None)


def _by_its_answer(row: TransportRow, projection: Projection) -> str | None:
    task = projection.tasks.view(row.task)
    answers = () if task is None else task.refusals
    return next((each.reason for each in reversed(answers) if each.agent == row.vehicle), None)

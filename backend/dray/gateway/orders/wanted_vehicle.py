"""Why the only permitted vehicle does not carry a transport: by its last report and its last answer."""

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
"""States in which a vehicle carries nothing, by its own report or its silence."""


def why_not(row: TransportRow, projection: Projection, now_s: float) -> str | None:
    """Why the wanted vehicle does not carry a waiting transport.

    Args:
        row: the transport.
        projection: the vehicle's reports.
        now_s: wall clock.

    Returns:
        The vehicle's state (`Unwilling`), or its reason not to bid (`Refusal`). None if no vehicle is wanted
        any more, the transport is held or carried, or no obstacle is known.
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

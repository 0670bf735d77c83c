"""The customer's view as JSON: the page's content, with times in ISO 8601."""

from __future__ import annotations

from typing import Literal

import msgspec

from dray.gateway.tracking.texts.clock import Clock
from dray.gateway.tracking.track import Track, TrackedItem


class TrackStage(msgspec.Struct, frozen=True):
    """A stage of the order."""

    name: Literal["placed", "planned", "in_production", "on_its_way", "delivered"]
    reached: bool
    at: str | None
    """None if not reached, or if the time is unknown."""


class TrackEta(msgspec.Struct, frozen=True):
    """Expected delivery."""

    earliest: str
    latest: str


class TrackAnswer(msgspec.Struct, frozen=True):
    """The customer's view."""

    status: Literal["stored", "released", "in_production", "in_delivery", "delivered", "cancelled"]
    reference: str | None
    items: tuple[TrackedItem, ...]
    stages: tuple[TrackStage, ...]
    eta: TrackEta | None
    """None if no honest estimate is possible."""
    late: Literal["", "maybe", "yes"]
    """Estimate against `due_at`."""
    reasons: tuple[
        Literal[
            "not_released",
            "no_machine",
            "repair",
            "handed_on",
            "material",
            "held_up",
            "overtaken",
            "started_anew",
        ],
        ...,
    ]
    """Why it waits; empty when it goes on."""
    materials: tuple[str, ...]
    """Names of the missing materials, with the reason `material`; empty if unknown."""
    created_at: str
    due_at: str | None
    delivered_at: str | None


def answer(told: Track) -> TrackAnswer:
    """The customer's view in its JSON form."""
    return TrackAnswer(
        status=told.status.value,
        reference=told.reference,
        items=told.items,
        stages=tuple(TrackStage(stage.name.value, stage.reached, _iso(stage.at_s)) for stage in told.stages),
        eta=None if told.eta is None else TrackEta(Clock.iso(told.eta.from_s), Clock.iso(told.eta.to_s)),
        late=told.late.value,
        reasons=tuple(reason.value for reason in told.reasons),
        materials=told.materials,
        created_at=Clock.iso(told.created_at_s),
        due_at=_iso(told.due_at_s),
        delivered_at=_iso(told.delivered_at_s),
    )


def _iso(at_s: float | None) -> str | None:
    return None if at_s is None else Clock.iso(at_s)

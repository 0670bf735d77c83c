"""Drafts: what an order must look like before it is taken, and what it must not ask for."""

from __future__ import annotations

from collections.abc import Collection
from datetime import UTC, datetime
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, WithJsonSchema
from pydantic_core import PydanticCustomError

from dray.gateway.http.problems import FieldError
from dray.gateway.http.request_bodies import Line
from dray.priorities import Priority

MAX_ITEMS = 50
"""Lines of one order: more than a person reads; larger orders come as several."""

MAX_QUANTITY = 10_000
"""Pieces of one line: some weeks of the default plant; a slip of the keyboard should not block it."""


def _written_moment(value: Any) -> datetime:
    if not isinstance(value, str):
        raise PydanticCustomError("moment_text", "write it as text, as 2030-05-17T14:30:00Z")
    try:
        moment = datetime.fromisoformat(value)
    except ValueError:
        reason = "it is no ISO 8601 time; write it as 2030-05-17T14:30:00Z"
        raise PydanticCustomError("moment_unreadable", reason) from None
    if moment.tzinfo is None:
        reason = "it lacks its time zone; add Z or an offset, as 2030-05-17T14:30:00+02:00"
        raise PydanticCustomError("moment_no_zone", reason)
    return moment


def _in_utc(moment: datetime) -> datetime:
    try:
        return moment.astimezone(UTC)
    except (OverflowError, ValueError):
        raise PydanticCustomError("moment_off_calendar", "it is out of the calendar") from None


LATEST = datetime(2100, 1, 1, tzinfo=UTC)
"""A later due time is a slip of the keyboard, and reckoning with it leaves the calendar."""


def _before_latest(moment: datetime) -> datetime:
    if moment >= LATEST:
        reason = f"it is out of the calendar; give a time before {LATEST.year}"
        raise PydanticCustomError("moment_off_calendar", reason)
    return moment


Moment = Annotated[
    datetime,
    BeforeValidator(_written_moment),
    AfterValidator(_in_utc),
    WithJsonSchema({"type": "string", "format": "date-time"}),
]
"""A moment with its time zone, as ISO 8601 writes it; numbers are refused, for nobody knows their unit."""

DueMoment = Annotated[Moment, AfterValidator(_before_latest)]
"""A moment for which something may be due."""


class ItemDraft(BaseModel):
    """A line of a new order."""

    model_config = ConfigDict(extra="forbid")

    product: Annotated[str, Field(min_length=1, max_length=32, pattern=r"^[A-Za-z][A-Za-z0-9_.-]*$")]
    """A product's id; `GET /api/products` lists them."""
    quantity: Annotated[int, Field(strict=True, ge=1, le=MAX_QUANTITY)]
    """Pieces."""


class WorkDraft(BaseModel):
    """What is to be made. One product may stand in several lines; they are delivered as they are written."""

    model_config = ConfigDict(extra="forbid")

    items: Annotated[list[ItemDraft], Field(min_length=1, max_length=MAX_ITEMS)]
    due_at: DueMoment | None = None
    """When all of it should be in the delivery warehouse, with a time zone; not in the past."""


class OrderDraft(WorkDraft):
    """A new order."""

    customer: Line
    reference: Line | None = None
    """The customer's own number."""
    priority: Priority = Priority.NORMAL
    """What is urgent is wanted within a quarter of an hour of the plant's clock, high within three quarters; low stands back for a shift."""
    release: Annotated[bool, Field(strict=True)] = True
    """False: only store it; `POST /api/orders/{id}/release` starts it."""


def nonsense(draft: WorkDraft, known: Collection[str], now_s: float) -> list[FieldError]:
    """What has the right shape and still means nothing in a plant where these products are known, or at this time."""
    errors = [
        FieldError.of(
            f"items[{index}].product", "not_made", product=item.product, products=", ".join(sorted(known))
        )
        for index, item in enumerate(draft.items)
        if item.product not in known
    ]
    if draft.due_at is not None and draft.due_at.timestamp() <= now_s:
        now = datetime.fromtimestamp(now_s, UTC).isoformat(timespec="seconds")
        errors.append(FieldError.of("due_at", "past", now=now))
    return errors

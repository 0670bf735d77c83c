"""Drafts: the shape of an order, and what it must not ask for."""

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
"""Maximum lines of one order: more than a person reads; larger orders come as several."""

MAX_QUANTITY = 10_000
"""Maximum pieces per line: some weeks of the default plant; a typing error should not block it."""


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
"""Limit for due times: a later one is a typing error, and calculations would leave the calendar."""


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
"""An ISO 8601 time with a time zone; numbers are refused, because their unit is unknown."""

DueMoment = Annotated[Moment, AfterValidator(_before_latest)]
"""A time at which something may be due."""


class ItemDraft(BaseModel):
    """A line of a new order."""

    model_config = ConfigDict(extra="forbid")

    product: Annotated[str, Field(min_length=1, max_length=32, pattern=r"^[A-Za-z][A-Za-z0-9_.-]*$")]
    """A product's id; `GET /api/products` lists them."""
    quantity: Annotated[int, Field(strict=True, ge=1, le=MAX_QUANTITY)]
    """Pieces."""


class WorkDraft(BaseModel):
    """The products to make.

    One product may stand in several lines; they are delivered in the order written.
    """

    model_config = ConfigDict(extra="forbid")

    items: Annotated[list[ItemDraft], Field(min_length=1, max_length=MAX_ITEMS)]
    due_at: DueMoment | None = None
    """When all should be in the delivery warehouse, with a time zone; not in the past."""


class OrderDraft(WorkDraft):
    """A new order."""

    customer: Line
    reference: Line | None = None
    """The customer's own number."""
    priority: Priority = Priority.NORMAL
    """An urgent order is wanted within a quarter of an hour of the plant's clock, a high one within three
    quarters; a low one waits up to a shift."""
    release: Annotated[bool, Field(strict=True)] = True
    """False to store the order only; `POST /api/orders/{id}/release` starts it."""


def nonsense(draft: WorkDraft, known: Collection[str], now_s: float) -> list[FieldError]:
    """Faults of a well-formed draft: unknown products, or a due time in the past."""
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

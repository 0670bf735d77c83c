"""Recurring work as written by people."""

from __future__ import annotations

from datetime import UTC, date, datetime
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    WithJsonSchema,
    model_validator,
)
from pydantic_core import PydanticCustomError

from dray.gateway.http.request_bodies import NOTE, Line
from dray.gateway.orders.drafts import MAX_ITEMS, DueMoment, ItemDraft, OrderDraft
from dray.gateway.orders.transport_draft import TransportDraft
from dray.priorities import Priority

HOLIDAYS_MAX = 400
"""Maximum holidays per calendar: the days of a year, and some."""

RUNS_MAX = 50
"""Maximum moments of a preview: more than a person reads."""


DAY_WRONG = "it is no day of the calendar; write it as 2030-12-25"


def _written_day(value: Any) -> date:
    if not isinstance(value, str):
        raise PydanticCustomError("day_unreadable", DAY_WRONG)
    try:
        return date.fromisoformat(value)
    except ValueError:
        raise PydanticCustomError("day_unreadable", DAY_WRONG) from None


Day = Annotated[date, BeforeValidator(_written_day), WithJsonSchema({"type": "string", "format": "date"})]


def _without_time(draft: TransportDraft) -> TransportDraft:
    if draft.due_at is not None:
        raise ValueError("leave due_at out: each run is due by its priority, from its own moment on")
    if draft.not_before is not None:
        raise ValueError("leave not_before out: each run begins at its own moment")
    return draft


Recurring = Annotated[TransportDraft, AfterValidator(_without_time)]
"""The transport each time, without `due_at` and `not_before`."""

DUE_AFTER_S = (600.0, 366 * 86_400.0)
"""Minimum and maximum wall seconds until a recurring order is due. The minimum exceeds the latest use of a
moment (`PUNCTUAL_S`); the maximum is a year."""


class RecurringOrder(BaseModel):
    """The order placed each time."""

    model_config = ConfigDict(extra="forbid")

    customer: Line
    items: Annotated[list[ItemDraft], Field(min_length=1, max_length=MAX_ITEMS)]
    reference: Line | None = None
    """The customer's own number, the same each time."""
    priority: Priority = Priority.NORMAL
    due_after_s: (
        Annotated[float, Field(strict=True, ge=DUE_AFTER_S[0], le=DUE_AFTER_S[1], allow_inf_nan=False)] | None
    ) = None
    """Wall seconds from each moment to the due time, at least ten minutes; for a late run, from the run."""

    def draft(self, begin_s: float) -> OrderDraft:
        """The order of one moment, wall clock seconds."""
        due_at = None
        if self.due_after_s is not None:
            due_at = datetime.fromtimestamp(begin_s + self.due_after_s, UTC).isoformat()
        fields = self.model_dump(exclude={"due_after_s"})
        return OrderDraft.model_validate(fields | {"due_at": due_at} if due_at else fields)


Expression = Annotated[Line, Field(max_length=120)]
"""Five cron fields: minute, hour, day of the month, month, day of the week, as `0 6 * * MON-FRI`."""

Zone = Annotated[Line, Field(max_length=64)]
"""IANA name, such as `Europe/Berlin`."""

Holidays = Annotated[list[Day], Field(max_length=HOLIDAYS_MAX)]
"""Days in the time zone that are left out."""

Region = Annotated[str, Field(max_length=40, pattern=NOTE)]
"""Country or region whose public holidays are left out too, as `DE` or `DE-BW` (ISO 3166); empty for none."""

SKIPPED_MAX = 50
"""Maximum single moments left out; beyond that, use holidays or a pause."""

Skipped = Annotated[list[DueMoment], Field(max_length=SKIPPED_MAX)]
"""Moments of the calendar that are left out."""

_ONE = "say either transport, what is brought, or order, what is made"

Missed = Literal["skip", "catch_up"]

Name = Annotated[Line, Field(max_length=80)]


class PreviewDraft(BaseModel):
    """A calendar."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={"examples": [{"calendar": "0 6 * * MON-FRI", "time_zone": "Europe/Berlin"}]},
    )

    calendar: Expression
    time_zone: Zone
    holidays: Holidays = Field(default_factory=list)
    holidays_of: Region = ""
    count: Annotated[int, Field(strict=True, ge=1, le=RUNS_MAX)] = 10
    """Number of moments to return."""


class ScheduleDraft(BaseModel):
    """A new schedule."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "examples": [
                {
                    "name": "Bearings for the early shift",
                    "calendar": "45 5 * * MON-FRI",
                    "time_zone": "Europe/Berlin",
                    "holidays": ["2030-12-24", "2030-12-31"],
                    "holidays_of": "DE-BW",
                    "transport": {"from": "S5", "to": "M8", "item": "bearing", "quantity": 40},
                },
                {
                    "name": "Gear units for hall 3",
                    "calendar": "0 6 * * MON",
                    "time_zone": "Europe/Berlin",
                    "order": {
                        "customer": "Hall 3",
                        "items": [{"product": "gear-unit-g1", "quantity": 20}],
                        "due_after_s": 28800.0,
                    },
                },
            ]
        },
    )

    name: Name
    """Unique name."""
    calendar: Expression
    time_zone: Zone
    holidays: Holidays = Field(default_factory=list)
    holidays_of: Region = ""
    missed: Missed = "skip"
    """Treatment of moments that passed without a gateway: none, or the last one once."""
    paused: Annotated[bool, Field(strict=True)] = False
    transport: Recurring | None = None
    """The transport each time; either this or `order`."""
    order: RecurringOrder | None = None
    """The order placed each time; either this or `transport`."""

    @model_validator(mode="after")
    def _one(self) -> ScheduleDraft:
        if (self.transport is None) == (self.order is None):
            raise ValueError(_ONE)
        return self


class ScheduleChange(BaseModel):
    """Changes to a schedule; fields left out stay."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"examples": [{"paused": True}]})

    name: Name | None = None
    calendar: Expression | None = None
    time_zone: Zone | None = None
    holidays: Holidays | None = None
    holidays_of: Region | None = None
    skipped: Skipped | None = None
    """All moments to leave out from now on: adding one leaves it out, removing one restores it."""
    missed: Missed | None = None
    paused: Annotated[bool | None, Field(strict=True)] = None
    transport: Recurring | None = None
    """Replaces an order, if there was one; and the other way round."""
    order: RecurringOrder | None = None

    @model_validator(mode="after")
    def _something(self) -> ScheduleChange:
        if self.transport is not None and self.order is not None:
            raise ValueError(_ONE)
        if not self.model_fields_set:
            raise ValueError("name at least one field that is to be changed")
        return self

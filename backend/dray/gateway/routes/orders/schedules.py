"""Recurring work: plain transports and orders, repeated by a calendar."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Iterator, Sequence
from http import HTTPStatus
from typing import Annotated

import msgspec
from fastapi import APIRouter, Depends, Header, Path, Response

from dray.gateway.access.audit_log import Noted
from dray.gateway.access.caller import Caller
from dray.gateway.http.csv_tables import Format, Row, table, with_csv
from dray.gateway.http.problems import not_found, unusable
from dray.gateway.http.provided import Now, Provided
from dray.gateway.http.request_bodies import json_only
from dray.gateway.http.responses import (
    PAGE,
    Cursor,
    Json,
    Limit,
    described,
    iso,
    list_of,
    listing_in_turns,
    part,
    problems,
)
from dray.gateway.http.versions import version_tag
from dray.gateway.schedules.calendar import Calendar, CalendarError
from dray.gateway.schedules.drafts import PreviewDraft, ScheduleChange, ScheduleDraft
from dray.gateway.schedules.scheduler import Scheduler, calendar_of, days_of, may_see, ready, skipped_of
from dray.store import Store
from dray.store.orders.schedules import ScheduleRow

router = APIRouter(tags=["transports"])

NEXT_RUNS = 3
"""Next moments per schedule in a list; a preview has more."""

LISTED = "GET /api/schedules"

ScheduleId = Annotated[str, Path(max_length=64)]

IfMatch = Annotated[
    str | None, Header(alias="If-Match", description="The `ETag` of the schedule as it was read, or *")
]


class RecurringTransport(msgspec.Struct, frozen=True, kw_only=True, rename={"source": "from"}):
    """The transport each time, as in `POST /api/transports`."""

    source: str | None = None
    to: str | None = None
    item: str | None = None
    thing: str | None = None
    """A thing without master data, instead of an item."""
    quantity: int | None = None
    priority: str = "normal"
    vehicle: str | None = None
    vehicle_only: bool = True
    ability: str | None = None


class RecurringItem(msgspec.Struct, frozen=True):
    """A line of a recurring order."""

    product: str
    quantity: int


class RecurringOrderAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """The order placed each time."""

    customer: str
    items: tuple[RecurringItem, ...]
    reference: str | None = None
    priority: str = "normal"
    due_after_s: float | None = None
    """Wall seconds from each moment to its due time."""


class LastRun(msgspec.Struct, frozen=True, kw_only=True):
    """The result of the last moment used."""

    planned_at: str
    transport: str | None = None
    """See GET /api/transports; null if there was none."""
    order: str | None = None
    """See GET /api/orders; null if there was none."""
    refused: str | None = None
    """Reason if it was refused."""
    made_up_at: str | None = None
    """When it was made up for, because the gateway or its database was away at its moment; null if it was
    in time."""


class ScheduleAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """Recurring work."""

    id: str
    etag: str
    """For `If-Match`."""
    name: str
    calendar: str
    time_zone: str
    holidays: tuple[str, ...]
    holidays_of: str = ""
    """Country or region whose public holidays are left out too, as DE-BW; empty for none."""
    skipped: tuple[str, ...] = ()
    """Moments of its calendar that are left out, in its time zone."""
    missed: str
    """skip or catch_up: treatment of moments that passed without a gateway."""
    paused: bool
    transport: RecurringTransport | None = None
    """The transport each time; null for orders."""
    order: RecurringOrderAnswer | None = None
    """The order each time; null for transports."""
    next_runs: tuple[str, ...]
    """In the calendar's time zone; empty while paused."""
    owner_gone: bool = False
    """Whether its owner has lost all rights: the key was revoked or expired, or the person may not log in. It
    pauses then. A person who resumes it becomes its owner."""
    last: LastRun | None = None
    missed_at: str | None = None
    """The last moment skipped because it had passed."""
    changed_by: str
    changed_at: str


class RunsPreview(msgspec.Struct, frozen=True):
    """The moments of a calendar."""

    runs: tuple[str, ...]
    """In its time zone, each with its offset."""


EXAMPLES = (
    ScheduleAnswer(
        id="S-5f0c81d2a94e",
        etag='"1-1893473100-1893213900"',
        name="Bearings for the early shift",
        calendar="45 5 * * MON-FRI",
        time_zone="Europe/Berlin",
        holidays=("2030-12-24", "2030-12-31"),
        holidays_of="DE-BW",
        missed="skip",
        paused=False,
        transport=RecurringTransport(source="S5", to="M8", item="bearing", quantity=40),
        next_runs=("2030-01-02T05:45:00+01:00", "2030-01-03T05:45:00+01:00", "2030-01-04T05:45:00+01:00"),
        last=LastRun(planned_at="2029-12-31T04:45:00.000Z", transport="T-1M9K3X2A4-K7QM"),
        changed_by="Early shift",
        changed_at="2029-12-20T13:02:11.000Z",
    ),
    RunsPreview(("2030-01-01T05:45:00+01:00", "2030-01-02T05:45:00+01:00")),
)
"""One example per answer."""


COLUMNS = (
    *("name", "calendar", "time_zone", "holidays", "holidays_of", "skipped", "missed", "paused", "kind"),
    *(
        "from",
        "to",
        "customer",
        "reference",
        "item",
        "quantity",
        "priority",
        "vehicle",
        "ability",
        "due_after_s",
    ),
    *("next_run", "last_planned_at", "last", "last_refused"),
)


@router.get(
    "/schedules",
    responses={200: with_csv(list_of(ScheduleAnswer, "Recurring work, by id"))},
    response_class=Json,
)
async def list_schedules(
    store: Provided[Store],
    caller: Caller,
    now_s: Now,
    cursor: Cursor = None,
    limit: Limit = PAGE,
    format: Format = "json",  # noqa: A002 - the word that others use
) -> Response:
    """Recurring work: calendars, next moments, and last results.

    As a table, it has a row per transport and per item of an order. Without `orders:read`, only your own
    orders are listed.
    """
    async with store.read() as work:
        rows = [row for row in await work.schedules.all() if may_see(row, caller)]
        gone = await work.schedules.owners_gone(now_s)
    await ready(rows)
    if format == "csv":
        return table("recurring", COLUMNS, _rows(rows, gone))
    shown, next_cursor = part(rows, lambda row: row.id, cursor, limit)
    answers = [answer async for answer in _answers(shown, gone)]
    return await listing_in_turns(answers, lambda answer: answer, next_cursor)


@router.post(
    "/schedules",
    status_code=HTTPStatus.CREATED,
    dependencies=[Depends(json_only)],
    responses={
        201: described(ScheduleAnswer, "The new schedule", EXAMPLES[0])
        | {"headers": {"Location": {"description": "The schedule", "schema": {"type": "string"}}}},
        **problems(p409="There is one of this name, or there are too many"),
    },
    response_class=Json,
)
async def add_schedule(
    scheduler: Provided[Scheduler], caller: Caller, note: Noted, draft: ScheduleDraft
) -> Json:
    """Repeat a transport or an order at every moment of a calendar, once for each.

    Orders also need the right to place them (`orders:write`).

    A repeated request is refused, since names are unique.
    """
    note.detail |= draft.model_dump(mode="json", exclude_none=True, by_alias=True)
    row = await scheduler.define(draft, caller)
    note.target = row.id
    headers = {"Location": f"/api/schedules/{row.id}", "ETag": version_tag(row.revision)}
    return Json(_answer(row), HTTPStatus.CREATED, headers=headers)


@router.post(
    "/schedules/preview",
    dependencies=[Depends(json_only)],
    responses={200: described(RunsPreview, "The next moments", EXAMPLES[1])},
    response_class=Json,
)
async def preview_runs(now_s: Now, draft: PreviewDraft) -> Json:
    """The next moments of a calendar; nothing is stored."""

    def runs() -> tuple[str, ...]:
        calendar = Calendar(
            draft.calendar, draft.time_zone, frozenset(draft.holidays), holidays_of=draft.holidays_of
        )
        return tuple(calendar.local(at_s).isoformat() for at_s in calendar.preview(now_s, draft.count))

    try:
        return Json(RunsPreview(await asyncio.to_thread(runs) if draft.holidays_of else runs()))
    except CalendarError as error:
        raise unusable(error.error) from None


@router.get(
    "/schedules/{schedule}",
    responses={
        200: described(ScheduleAnswer, "The schedule", EXAMPLES[0]),
        **problems(p404="There is no such schedule"),
    },
    response_class=Json,
)
async def get_schedule(store: Provided[Store], caller: Caller, now_s: Now, schedule: ScheduleId) -> Json:
    """One schedule; its `ETag` is for changing it.

    Another owner's recurring order also needs `orders:read`.
    """
    async with store.read() as work:
        row = await work.schedules.get(schedule)
        gone = await work.schedules.owners_gone(now_s)
    if row is None or not may_see(row, caller):
        raise not_found("schedule", schedule, LISTED)
    await ready([row])
    return Json(_answer(row, gone), headers={"ETag": version_tag(row.revision)})


@router.patch(
    "/schedules/{schedule}",
    dependencies=[Depends(json_only)],
    responses={
        200: described(ScheduleAnswer, "The schedule as it is now", EXAMPLES[0]),
        **problems(
            p404="There is no such schedule",
            p409="There is another one of this name",
            p412="Somebody has changed it since",
            p428="It is not said which state of it is changed",
        ),
    },
    response_class=Json,
)
async def change_schedule(
    store: Provided[Store],
    scheduler: Provided[Scheduler],
    caller: Caller,
    note: Noted,
    now_s: Now,
    schedule: ScheduleId,
    draft: ScheduleChange,
    if_match: IfMatch = None,
) -> Json:
    """Change, pause or resume a schedule, or leave out single moments.

    Moments during a pause are never made up for.

    A caller who changes its content or calendar becomes its owner; so does one who resumes it after its owner
    was gone (`owner_gone`). Changing one with orders also needs the right to place orders (`orders:write`).
    """
    note.target = schedule
    note.detail |= draft.model_dump(mode="json", exclude_none=True, by_alias=True)
    row = await scheduler.change(schedule, draft, if_match, caller)
    if row is None:
        raise not_found("schedule", schedule, LISTED)
    async with store.read() as work:
        gone = await work.schedules.owners_gone(now_s)
    return Json(_answer(row, gone), headers={"ETag": version_tag(row.revision)})


@router.delete(
    "/schedules/{schedule}",
    status_code=HTTPStatus.NO_CONTENT,
    responses={
        **problems(
            p404="There is no such schedule",
            p412="Somebody has changed it since",
            p428="It is not said which state of it is removed",
        )
    },
)
async def remove_schedule(
    scheduler: Provided[Scheduler],
    caller: Caller,
    note: Noted,
    schedule: ScheduleId,
    if_match: IfMatch = None,
) -> Response:
    """Remove a schedule; work already requested continues.

    One with orders also needs the right to place orders.
    """
    note.target = schedule
    if not await scheduler.remove(schedule, if_match, caller):
        raise not_found("schedule", schedule, LISTED)
    return Response(status_code=HTTPStatus.NO_CONTENT)


async def _answers(rows: Sequence[ScheduleRow], gone: frozenset[str]) -> AsyncIterator[ScheduleAnswer]:
    """Answers one by one, letting other work run.

    Next moments of a calendar with many holidays take milliseconds.
    """
    for row in rows:
        yield _answer(row, gone)
        await asyncio.sleep(0)


async def _rows(rows: Sequence[ScheduleRow], gone: frozenset[str]) -> AsyncIterator[Row]:
    async for answer in _answers(rows, gone):
        for line in _lines(answer):
            yield line


def _answer(row: ScheduleRow, gone: frozenset[str] = frozenset()) -> ScheduleAnswer:
    """A schedule as its readers see it; `gone` holds owners without rights."""
    last = None
    if row.last_at_s is not None:
        last = LastRun(
            planned_at=iso(row.last_at_s),
            transport=row.last_transport or None,
            order=row.last_order or None,
            refused=row.last_refused or None,
            made_up_at=None if row.made_up_at_s is None else iso(row.made_up_at_s),
        )
    return ScheduleAnswer(
        id=row.id,
        etag=version_tag(row.revision),
        name=row.name,
        calendar=row.calendar,
        time_zone=row.time_zone,
        holidays=tuple(day.isoformat() for day in days_of(row)),
        holidays_of=row.holidays_of,
        skipped=_skipped(row),
        missed="catch_up" if row.make_up else "skip",
        paused=row.paused,
        transport=msgspec.json.decode(row.transport, type=RecurringTransport) if row.transport else None,
        order=msgspec.json.decode(row.order_draft, type=RecurringOrderAnswer) if row.order_draft else None,
        next_runs=_next_runs(row),
        owner_gone=row.owner in gone,
        last=last,
        missed_at=None if row.missed_at_s is None else iso(row.missed_at_s),
        changed_by=row.by,
        changed_at=iso(row.at_s),
    )


def _lines(each: ScheduleAnswer) -> Iterator[Row]:
    """A schedule as table rows with the cells of COLUMNS."""
    days, skipped = " ".join(each.holidays), " ".join(each.skipped)
    begin = (
        each.name,
        each.calendar,
        each.time_zone,
        days,
        each.holidays_of,
        skipped,
        each.missed,
        each.paused,
    )
    last = LastRun(planned_at="") if each.last is None else each.last
    came = last.transport or last.order
    end = (next(iter(each.next_runs), None), last.planned_at, came, last.refused)
    if (one := each.transport) is not None:
        what = (one.item or one.thing, one.quantity or 1, one.priority, one.vehicle, one.ability)
        yield (*begin, "transport", one.source, one.to, None, None, *what, None, *end)
    if (order := each.order) is not None:
        for item in order.items:
            what = (item.product, item.quantity, order.priority, None, None)
            yield (
                *(*begin, "order", None, None, order.customer, order.reference),
                *(*what, order.due_after_s, *end),
            )


def _skipped(row: ScheduleRow) -> tuple[str, ...]:
    moments = skipped_of(row)
    try:
        local = calendar_of(row).local
    except CalendarError:
        return tuple(map(iso, moments))
    return tuple(local(at_s).isoformat() for at_s in moments)


def _next_runs(row: ScheduleRow) -> tuple[str, ...]:
    if row.next_at_s is None:
        return ()
    try:
        calendar = calendar_of(row)
    except CalendarError:
        return (iso(row.next_at_s),)
    moments = [row.next_at_s, *calendar.preview(row.next_at_s, NEXT_RUNS - 1)]
    return tuple(calendar.local(at_s).isoformat() for at_s in moments)

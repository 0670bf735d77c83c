"""The scheduler: places the work of every moment that has come, at most once.

Moments are on the wall clock, like all times in REST: a simulated factory at twenty times real time is asked
for its morning's work in the morning. A moment is used in one transaction: its schedule advances, and the
transport or order gets a key made of schedule and moment. So neither a second gateway nor a crash in between
places it again.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import math
import secrets
from collections.abc import Callable, Iterable
from datetime import date
from http import HTTPStatus

import msgspec

from dray.errors import UnavailableError
from dray.gateway.access.gate import forbidden
from dray.gateway.access.principal import Principal, Scope
from dray.gateway.http.problems import FieldError, Problem, unusable
from dray.gateway.http.shares import share_of, share_used
from dray.gateway.http.versions import changed_since, check_version
from dray.gateway.live.timescale import wait_until
from dray.gateway.orders.idempotency import own_key
from dray.gateway.orders.transport_draft import TransportDraft
from dray.gateway.schedules import public_holidays
from dray.gateway.schedules.calendar import Calendar, CalendarError
from dray.gateway.schedules.drafts import RecurringOrder, ScheduleChange, ScheduleDraft
from dray.gateway.schedules.runs import Run, Runs, principal
from dray.store import Store
from dray.store.access.audit import AuditRow
from dray.store.orders.schedules import ScheduleRow

SCHEDULES_MAX = 500
"""Maximum schedules: more than people can watch."""

PUNCTUAL_S = 300.0
"""Wall seconds by which a moment may be late without being missed: a restart of the gateway or its
database."""

LOOK_EVERY_S = 10.0
"""Seconds between two reads of SQL: another gateway may have a new schedule, or the clock was set."""

REFUSED_MAX = 300
"""Maximum characters stored of a refusal."""

_log = logging.getLogger(__name__)


class Scheduler:
    """Keeps schedules and executes them.

    Args:
        store: the database.
        runs: makes their requests.
        wall_s: the wall clock.
    """

    def __init__(self, store: Store, runs: Runs, wall_s: Callable[[], float]) -> None:
        self._store, self._runs, self._wall_s = store, runs, wall_s
        self._news = asyncio.Event()

    # --- people's requests ---

    async def define(self, draft: ScheduleDraft, by: Principal) -> ScheduleRow:
        """Add a schedule.

        Raises:
            Problem: 422, its calendar or work is invalid; 409, its name is taken or there are too many; 429,
                the caller has too many; 403, the caller may not place orders.
        """
        now_s = self._wall_s()
        row = ScheduleRow(
            id=f"S-{secrets.token_hex(6)}",
            name=draft.name,
            calendar=draft.calendar,
            time_zone=draft.time_zone,
            holidays=_kept_days(draft.holidays),
            holidays_of=draft.holidays_of,
            make_up=draft.missed == "catch_up",
            paused=draft.paused,
            transport=_kept_transport(draft.transport),
            order_draft=_kept_order(draft.order),
            revision=1,
            by=by.name,
            at_s=now_s,
            next_at_s=None,
            owner=by.key,
        )
        _refuse_orders(row, by)
        row = await self._begun(row, now_s)
        self._runs.check(row, now_s)
        async with self._store.write() as work:
            kept = await work.schedules.all()
            _refuse_beyond_share(kept, row.owner)
            if len(kept) >= SCHEDULES_MAX:
                raise _too_many()
            if await work.schedules.named(row.name) is not None or not await work.schedules.add(row):
                raise _name_taken(row.name)
        self._news.set()
        return row

    async def change(
        self, schedule: str, change: ScheduleChange, version: str | None, by: Principal
    ) -> ScheduleRow | None:
        """Change a schedule. A new calendar, or the end of a pause, begins with the next moment from now.

        A caller who changes its request or calendar becomes its owner, whose share it uses. So does one who
        resumes it after its owner has lost all rights.

        Returns:
            The schedule now; None if it does not exist.

        Raises:
            Problem: as `define`, 403 also if it was for orders before; 412, its version has changed; 428, no
                version is given.
        """
        async with self._store.write() as work:
            row = await work.schedules.get(schedule)
            if row is None:
                return None
            _refuse_orders(row, by)
            if not may_see(row, by):
                return None
            check_version(row.revision, version, changed_since("schedule", row.id))
            is_orphan = row.owner in await work.schedules.owners_gone(self._wall_s())
            after = await self._changed(row, change, by, is_orphan=is_orphan)
            if after.owner != row.owner:
                _refuse_beyond_share(await work.schedules.all(), after.owner)
            if after.name != row.name and await work.schedules.named(after.name) is not None:
                raise _name_taken(after.name)
            if not await work.schedules.change(row, after):
                raise changed_since("schedule", row.id)
        self._news.set()
        return after

    async def remove(self, schedule: str, version: str | None, by: Principal) -> bool:
        """Remove a schedule; its earlier requests continue. False if it does not exist.

        Raises:
            Problem: 403, it is for orders and the caller may not place them; 412, its version has changed;
                428, no version is given.
        """
        async with self._store.write() as work:
            row = await work.schedules.get(schedule)
            if row is None:
                return False
            _refuse_orders(row, by)
            if not may_see(row, by):
                return False
            check_version(row.revision, version, changed_since("schedule", row.id))
            if not await work.schedules.remove(row):
                raise changed_since("schedule", row.id)
        return True

    async def _changed(
        self, row: ScheduleRow, change: ScheduleChange, by: Principal, *, is_orphan: bool
    ) -> ScheduleRow:
        now_s = self._wall_s()
        fields = change.model_dump(exclude_none=True, exclude={"transport", "order", "missed", "skipped"})
        if change.holidays is not None:
            fields["holidays"] = _kept_days(change.holidays)
        other_work = change.transport is not None or change.order is not None
        if other_work:
            fields["transport"] = _kept_transport(change.transport)
            fields["order_draft"] = _kept_order(change.order)
        if change.missed is not None:
            fields["make_up"] = change.missed == "catch_up"
        after = msgspec.structs.replace(row, **fields, revision=row.revision + 1, by=by.name, at_s=now_s)
        if _asked(after) != _asked(row) or (is_orphan and change.paused is False):
            after = msgspec.structs.replace(after, owner=by.key)
        _refuse_orders(after, by)
        if _moments(after) != _moments(row):
            after = await self._begun(after, now_s)
        await ready([after])
        wanted = None if change.skipped is None else [moment.timestamp() for moment in change.skipped]
        after = self._skipping(after, wanted, now_s)
        if other_work:
            self._runs.check(after, now_s)
        return after

    # --- execution ---

    async def run(self) -> None:
        """Use every moment as it comes, until cancelled."""
        renewed = False
        while True:
            self._news.clear()
            next_s = None
            try:
                if not renewed:
                    await self.renew()
                    renewed = True
                await self.look()
                async with self._store.read() as work:
                    next_s = await work.schedules.next_s()
            except UnavailableError as error:
                _log.info("recurring work waits for the database: %s", error)
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(LOOK_EVERY_S):
                    await wait_until(math.inf if next_s is None else next_s, self._wall_s, self._news)

    async def renew(self) -> None:
        """Plan the next moments by the public holidays as they are known now: a newer library may differ.

        Raises:
            UnavailableError: the database cannot be read or written.
        """
        async with self._store.read() as work:
            rows = [row for row in await work.schedules.all() if row.holidays_of]
        await ready(rows)
        for row in rows:
            if row.next_at_s is None:
                continue
            with contextlib.suppress(CalendarError):
                # Keep a moment that has just come.
                next_s = calendar_of(row).after(min(self._wall_s(), row.next_at_s - 1.0))
                if next_s != row.next_at_s:
                    await self._move(row, msgspec.structs.replace(row, next_at_s=next_s))
            await asyncio.sleep(0)

    async def look(self) -> None:
        """Use every moment that has come, and pause schedules whose owner has lost all rights.

        Raises:
            UnavailableError: the database cannot be read or written.
        """
        now_s = self._wall_s()
        await self._pause_orphans(now_s)
        async with self._store.read() as work:
            due = await work.schedules.due(now_s)
        await ready(due)
        for row in due:
            await self._use(row, now_s)

    async def _pause_orphans(self, now_s: float) -> None:
        async with self._store.read() as work:
            gone = await work.schedules.owners_gone(now_s)
            rows = [row for row in await work.schedules.all() if row.owner in gone] if gone else []
        for row in rows:
            if row.paused:
                continue
            after = msgspec.structs.replace(row, paused=True, next_at_s=None, revision=row.revision + 1)
            async with self._store.write() as work:
                if await work.schedules.change(row, after):
                    await work.audit.add(_paused_line(row, now_s))

    async def _use(self, row: ScheduleRow, now_s: float) -> None:
        try:
            calendar = calendar_of(row)
        except CalendarError as error:
            # This computer's time zones or holidays differ from those of the one that accepted it.
            await self._move(row, msgspec.structs.replace(row, next_at_s=None, last_refused=str(error)))
            return
        assert row.next_at_s is not None  # noqa: S101 - it is due
        moment_s = calendar.newest(row.next_at_s, now_s)
        coming = [moment_s for moment_s in skipped_of(row) if moment_s > now_s]
        after = msgspec.structs.replace(row, next_at_s=calendar.after(now_s), skipped=_kept_moments(coming))
        if now_s - moment_s > PUNCTUAL_S and not row.make_up:
            await self._move(row, msgspec.structs.replace(after, missed_at_s=moment_s))
            return
        if moment_s > row.next_at_s:
            after = msgspec.structs.replace(after, missed_at_s=calendar.newest(row.next_at_s, moment_s - 1))
        await self._place(row, after, moment_s, now_s)

    async def _place(self, row: ScheduleRow, after: ScheduleRow, moment_s: float, now_s: float) -> None:
        after = msgspec.structs.replace(
            after,
            last_at_s=moment_s,
            last_transport="",
            last_order="",
            last_refused="",
            made_up_at_s=now_s if now_s - moment_s > PUNCTUAL_S else None,
        )
        key = own_key(principal(row), f"{moment_s:.0f}")
        try:
            with self._runs.run(row, moment_s if now_s - moment_s <= PUNCTUAL_S else now_s) as run:
                async with self._store.write() as work:
                    # A clock that was set back leads to used moments again.
                    known = await run.known(work, key)
                    if not await work.schedules.change(row, run.of(after, known or run.id)):
                        return
                    if known is None:
                        await run.keep(work, key)
                        await work.audit.add(_line(row, run, moment_s, now_s))
                if known is None:
                    run.begin()
        except Problem as problem:
            _log.warning("recurring work %s (%s) is refused: %s", row.id, row.name, problem.detail)
            await self._move(row, msgspec.structs.replace(after, last_refused=problem.detail[:REFUSED_MAX]))

    async def _move(self, row: ScheduleRow, after: ScheduleRow) -> None:
        async with self._store.write() as work:
            await work.schedules.change(row, after)

    # --- reading ---

    def _skipping(self, row: ScheduleRow, wanted: list[float] | None, now_s: float) -> ScheduleRow:
        """Leave out some coming moments; earlier ones that are no longer in the calendar are forgotten.

        Raises:
            Problem: 422, one is not a moment of the calendar, or the calendar is unusable here.
        """
        known = skipped_of(row)
        try:
            calendar = calendar_of(msgspec.structs.replace(row, skipped="[]"))
        except CalendarError as error:
            raise unusable(error.error) from None
        skipped = []
        for index, moment_s in enumerate(known if wanted is None else wanted):
            if moment_s > now_s and calendar.has(moment_s):
                skipped.append(moment_s)
            elif wanted is not None and moment_s not in known:
                next_s = calendar.after(now_s)
                coming = "none" if next_s is None else calendar.local(next_s).isoformat()
                raise unusable(FieldError.of(f"skipped[{index}]", "no_run", next=coming))
        kept = _kept_moments(skipped)
        if kept == row.skipped or row.next_at_s is None:
            return msgspec.structs.replace(row, skipped=kept)
        # Keep a moment that has just come.
        since_s = min(now_s, row.next_at_s - 1.0)
        after = msgspec.structs.replace(row, skipped=kept)
        return msgspec.structs.replace(after, next_at_s=calendar_of(after).after(since_s))

    async def _begun(self, row: ScheduleRow, now_s: float) -> ScheduleRow:
        def first() -> float | None:
            return calendar_of(row).after(now_s)

        try:
            # A calendar without a moment asks for the public holidays of all years.
            next_s = await asyncio.to_thread(first) if row.holidays_of else first()
        except CalendarError as error:
            raise unusable(error.error) from None
        if next_s is None:
            raise unusable(FieldError.of("calendar", "never"))
        return msgspec.structs.replace(row, next_at_s=None if row.paused else next_s)


def calendar_of(row: ScheduleRow) -> Calendar:
    """The calendar of a schedule.

    Raises:
        CalendarError: its time zone or its holidays are unknown here.
    """
    return Calendar(
        row.calendar,
        row.time_zone,
        frozenset(days_of(row)),
        frozenset(skipped_of(row)),
        row.holidays_of,
    )


async def ready(rows: Iterable[ScheduleRow]) -> None:
    """Load what `calendar_of` needs for some schedules, without blocking the event loop."""
    if any(row.holidays_of for row in rows):
        await public_holidays.load()


def days_of(row: ScheduleRow) -> list[date]:
    """The holidays of a schedule."""
    return msgspec.json.decode(row.holidays, type=list[date])


def skipped_of(row: ScheduleRow) -> list[float]:
    """The moments left out, in wall clock seconds."""
    return msgspec.json.decode(row.skipped, type=list[float])


def _moments(row: ScheduleRow) -> tuple[str, str, str, str, bool]:
    return row.calendar, row.time_zone, row.holidays, row.holidays_of, row.paused


def _asked(row: ScheduleRow) -> tuple[str, ...]:
    """The request and calendar of a schedule."""
    return row.transport, row.order_draft, row.calendar, row.time_zone, row.holidays, row.holidays_of


def _kept_days(days: list[date]) -> str:
    return msgspec.json.encode(sorted(set(days))).decode()


def _kept_moments(moments: Iterable[float]) -> str:
    return msgspec.json.encode(sorted(set(moments))).decode()


def _kept_transport(draft: TransportDraft | None) -> str:
    return "" if draft is None else draft.model_dump_json(by_alias=True, exclude_none=True)


def _kept_order(draft: RecurringOrder | None) -> str:
    return "" if draft is None else draft.model_dump_json(exclude_none=True)


def _line(row: ScheduleRow, run: Run, moment_s: float, now_s: float) -> AuditRow:
    """The audit log line of a run: the caller is the schedule."""
    return AuditRow(
        at_s=now_s,
        who=row.id,
        who_kind="schedule",
        action=run.action,
        target=run.id,
        result="done",
        detail={"schedule": row.name, "planned_at_s": moment_s},
    )


def _paused_line(row: ScheduleRow, now_s: float) -> AuditRow:
    """The audit log line of a schedule paused because of its owner."""
    return AuditRow(
        at_s=now_s,
        who=row.id,
        who_kind="schedule",
        action="schedule.change",
        target=row.id,
        result="done",
        detail={"schedule": row.name, "paused": True, "owner_gone": row.owner},
    )


def may_see(row: ScheduleRow, caller: Principal) -> bool:
    """Whether a caller may see a schedule: like orders, one with orders names a customer."""
    return not row.order_draft or caller.may(Scope.ORDERS_READ) or row.owner == caller.key


def _refuse_orders(row: ScheduleRow, by: Principal) -> None:
    """Refuse recurring orders, and changes to them, to callers who may not place orders.

    Raises:
        Problem: 403.
    """
    if row.order_draft and not by.may(Scope.ORDERS_WRITE):
        raise forbidden(
            f"an order that recurs asks for the right {Scope.ORDERS_WRITE.value}; ask somebody who may place orders"
        )


def _refuse_beyond_share(kept: Iterable[ScheduleRow], owner: str) -> None:
    """Refuse a schedule of a caller who has its maximum.

    Raises:
        Problem: 429.
    """
    if sum(each.owner == owner for each in kept) >= share_of(SCHEDULES_MAX):
        raise share_used(
            "pieces of recurring work", SCHEDULES_MAX, "remove one (GET /api/schedules lists them)"
        )


def _name_taken(name: str) -> Problem:
    return Problem(
        HTTPStatus.CONFLICT,
        "name-taken",
        "There is recurring work of this name",
        f"{name} exists already: take another name, or change what exists (GET /api/schedules lists it)",
    )


def _too_many() -> Problem:
    return Problem(
        HTTPStatus.CONFLICT,
        "too-many-schedules",
        "There is too much recurring work",
        f"{SCHEDULES_MAX} are kept: remove one (GET /api/schedules lists them)",
    )

"""Plain transports: called for once, repeated to their destination until it answers, and followed to the end.

A transport and its Idempotency-Key are one row; the answer follows its commit. Repetitions are not stored. At
the start and regularly, every transport open in SQL is asked for again, like orders.

A transport for later is held: its row says so (`HELD`), and no place knows of it. When its time comes, the
row is changed first, and the place is asked afterwards. So a held row was never asked for by any gateway, and
cancelling it ends it here.
"""

from __future__ import annotations

import asyncio
import hashlib
import logging
import math
from collections import Counter
from collections.abc import Callable
from contextlib import nullcontext, suppress
from datetime import UTC, datetime
from http import HTTPStatus

import msgspec

from dray.errors import UnavailableError
from dray.gateway.access.principal import CallLimits, Principal, Scope
from dray.gateway.http.problems import FieldError, Problem, unusable
from dray.gateway.http.shares import share_of, share_used
from dray.gateway.live.projection import Projection
from dray.gateway.live.timescale import TimeScale
from dray.gateway.orders.call_limits import AGAIN_S, refuse_beyond, refuse_full
from dray.gateway.orders.idempotency import AtWork, alone, key_at_work, refuse_other_body
from dray.gateway.orders.order_ids import Ids
from dray.gateway.orders.outbox import Reminders
from dray.gateway.orders.transport_draft import WISH_S, TransportDraft
from dray.gateway.orders.transport_places import misplaced, places_for, thing_misplaced
from dray.messages import (
    THING,
    TRANSPORT_ENDED,
    Message,
    TransportAnswered,
    TransportCancelled,
    TransportOrdered,
    TransportState,
)
from dray.plant import Plant
from dray.priorities import TRANSPORT_WITHIN_S, Priority
from dray.store import Store
from dray.store.orders.idempotency_keys import KeptAnswer
from dray.store.orders.transports import HELD, TransportRow
from dray.store.work import Work

OPEN_MAX = 5_000
"""Maximum open transports: days of a large fleet's work."""

RECONCILE_EVERY_S = 60.0
"""Wall seconds between two times that all open ones are asked for: people wait for them, and they are few."""

LOOK_AGAIN_S = 1.0
"""Wall seconds between two looks at held transports that are due: the database may be away."""

_log = logging.getLogger(__name__)


class PlainTransports:
    """Takes plain transports and follows them to the end.

    Args:
        store: the database.
        projection: the places and vehicles.
        send: sends a message to one agent.
        time: plant clock and wall clock.
        wall_s: the wall clock.
    """

    def __init__(
        self,
        store: Store,
        projection: Projection,
        send: Callable[[str, Message], None],
        time: TimeScale,
        wall_s: Callable[[], float],
    ) -> None:
        self._store, self._projection, self._send = store, projection, send
        self._time, self._wall_s = time, wall_s
        self._ids = Ids("T")
        self._reminders = Reminders()
        self._places: dict[str, str] = {}
        """Per transport with a repeated message, the place asked."""
        self._heard: dict[str, TransportAnswered] = {}
        """Answers with ends to write."""
        self._held: dict[str, float] = {}
        """Held transports -> their begin, wall clock."""
        self._news = asyncio.Event()
        self._keys_at_work: AtWork = {}

    # --- people's requests ---

    async def call(
        self,
        draft: TransportDraft,
        caller: Principal,
        key: str | None,
        render: Callable[[TransportRow], bytes],
        *,
        waits: bool = False,
    ) -> tuple[KeptAnswer, bool]:
        """Take a transport, or return the earlier answer to the same request.

        Args:
            draft: the draft.
            caller: the caller.
            key: the Idempotency-Key; None for none.
            render: writes the answer.
            waits: whether to wait for another request with the key instead of refusing this one.

        Returns:
            The answer, and whether it is an earlier one.

        Raises:
            Problem: it names unknown or unsuitable places or materials, it exceeds the key's limits, too many
                are open, or the Idempotency-Key was used for another body.
        """
        body = f"transport {draft.text()}"
        fingerprint = hashlib.sha256(body.encode()).hexdigest()
        turn = alone(self._keys_at_work, key, waits=waits) if key else nullcontext()
        async with turn, self._store.write() as work:
            if key and (known := await work.transports.of_key(key)) is not None:
                refuse_other_body(_kept(known), fingerprint)
                return _kept(known), True
            row = self.row(draft, caller)
            row = msgspec.structs.replace(row, key=key, fingerprint=fingerprint, answer=render(row).decode())
            if caller.calls is not None:
                await work.api_keys.hold(caller.id)
            await self.keep(work, row, caller.calls)
        self.ask(row)
        return _kept(row), False

    async def keep(self, work: Work, row: TransportRow, limits: CallLimits | None = None) -> None:
        """Store a transport in a transaction; call `ask` afterwards.

        Args:
            work: the transaction.
            row: the transport.
            limits: limits of the caller's key, if any.

        Raises:
            Problem: 503, too many are open; 429, too many of this caller are; 409, its Idempotency-Key was
                just used. The transaction must be rolled back.
        """
        open_ends = await work.transports.open_ends_of(row.caller)
        if limits is not None:
            refuse_full(limits, row.source, row.destination, open_ends)
        if len(open_ends) >= share_of(OPEN_MAX):
            raise share_used(
                "open transports", OPEN_MAX, "call some off, or wait until some have ended", again_s=AGAIN_S
            )
        if await work.transports.open_count() >= OPEN_MAX:
            raise _too_many()
        if not await work.transports.add(row):
            raise key_at_work()

    async def cancel(self, transport: str, caller: Principal) -> TransportRow | None:
        """Cancel a transport; a cancelled one stays so.

        Returns:
            The transport now, cancelled only once the factory has confirmed, or if the factory does not know
            it; None if the caller sees no such transport.

        Raises:
            Problem: 409, it is on board or delivered.
        """
        async with self._store.write() as work:
            row = await work.transports.get(transport)
            if row is None or not self.may_see(row, caller):
                return None
            if row.status in (TransportState.ON_BOARD, TransportState.DELIVERED):
                raise _too_late(row)
            now_s = self._wall_s()
            if row.is_held:
                self._held.pop(row.id, None)
                row = _ended_here(row, now_s)
                await work.transports.put(row)
            elif row.status is not TransportState.CANCELLED and row.cancel_at_s is None:
                row = msgspec.structs.replace(row, cancel_at_s=now_s, updated_at_s=now_s)
                await work.transports.put(row)
        if not row.has_ended:
            self.ask(row)
        return row

    def may_see(self, row: TransportRow, caller: Principal) -> bool:
        """Whether a caller sees a transport: one in its areas, or its own."""
        if not caller.may(Scope.FACTORY_READ):
            return row.caller == caller.key
        places = self.places_of(caller)
        return places is None or row.source in places or row.destination in places

    def places_of(self, caller: Principal) -> frozenset[str] | None:
        """The places whose transports a caller sees and, if limited to areas, may call for; None for all."""
        if caller.areas is None:
            return None
        plant, areas = self._plant, caller.areas
        return frozenset(
            place
            for place in (*plant.machines, *plant.stores)
            if not areas.isdisjoint(plant.areas_near(*plant.position_of(place), 0.0))
        )

    def abilities(self) -> tuple[str, ...]:
        """The ways in which a thing can be carried: the vehicles' abilities, most frequent first."""
        counts = Counter(each for has in self._abilities() for each in has)
        return tuple(sorted(counts, key=lambda each: (-counts[each], each)))

    # --- places' answers ---

    def on_answered(self, sender: str, answer: TransportAnswered) -> bool:
        """Take a place's answer; returns whether it was asked."""
        if self._places.get(answer.transport) != sender:
            return False
        if answer.state in TRANSPORT_ENDED:
            self._heard[answer.transport] = answer
        else:
            self._forget(answer.transport)
        self._news.set()
        return True

    async def start(self) -> None:
        """Ask for all open transports.

        Raises:
            UnavailableError: the database cannot be read.
        """
        async with self._store.read() as work:
            rows = await work.transports.open()
        for row in rows:
            if row.id not in self._reminders:
                self.ask(row)

    async def run(self) -> None:
        """Repeat unanswered messages and store ends until cancelled."""
        clock = asyncio.get_running_loop()
        reconcile_s = clock.time() + RECONCILE_EVERY_S
        while True:
            self._news.clear()
            next_s = self._reminders.next_s()
            wakes_s = min(reconcile_s, clock.time() + self._held_for_s())
            if next_s is not None:
                wakes_s = min(next_s, wakes_s)
            with suppress(TimeoutError):
                async with asyncio.timeout_at(wakes_s):
                    await self._news.wait()
            await self._write_ends()
            await self.begin_due()
            self._say_due(clock.time())
            if clock.time() >= reconcile_s:
                reconcile_s = clock.time() + RECONCILE_EVERY_S
                try:
                    await self.start()
                except UnavailableError as error:
                    _log.info("open transports are not reconciled this time: %s", error)

    async def begin_due(self) -> None:
        """Ask for held transports whose time has come."""
        now_s = self._wall_s()
        for name in [name for name, begin_s in self._held.items() if begin_s <= now_s]:
            try:
                async with self._store.write() as work:
                    row = await work.transports.get(name)
                    if row is not None and row.is_held:
                        row = msgspec.structs.replace(row, wait="", updated_at_s=now_s)
                        await work.transports.put(row)
            except UnavailableError as error:
                _log.warning("transport %s, whose time has come, cannot be begun yet: %s", name, error)
                return
            self._held.pop(name, None)
            if row is not None and not row.has_ended and name not in self._reminders:
                self.ask(row)

    # --- internals ---

    @property
    def _plant(self) -> Plant:
        return self._projection.site.plant

    async def _write_ends(self) -> None:
        while self._heard:
            name, answer = self._heard.popitem()
            try:
                async with self._store.write() as work:
                    row = await work.transports.get(name)
                    if row is not None and not row.has_ended:
                        now_s = self._wall_s()
                        await work.transports.put(
                            msgspec.structs.replace(
                                row,
                                status=answer.state,
                                refused=answer.refused or "",
                                wait="",
                                ended_at_s=now_s,
                                updated_at_s=now_s,
                            )
                        )
                self._forget(name)
            except UnavailableError as error:
                # It is asked for again in some seconds.
                _log.warning("how transport %s has ended cannot be written: %s", name, error)
                return

    def ask(self, row: TransportRow) -> None:
        """Ask a place for a stored transport, or cancel it there, until it answers; a held one waits."""
        if row.is_held:
            self._held[row.id] = row.created_at_s if row.not_before_s is None else row.not_before_s
            self._news.set()
            return
        message: Message = TransportCancelled(row.id)
        if row.cancel_at_s is None:
            due_s = self._time.to_plant_s(row.due_at_s)
            message = TransportOrdered(
                row.id,
                row.source,
                row.item,
                row.quantity,
                due_s,
                row.vehicle,
                self._until_s(row),
                row.ability,
            )
        now_s = asyncio.get_running_loop().time()
        self._places[row.id] = row.destination
        self._reminders.add(row.id, message, now_s)
        self._say_due(now_s)
        self._news.set()

    def _held_for_s(self) -> float:
        """Wall seconds until the next held transport begins."""
        return max(LOOK_AGAIN_S, min(self._held.values(), default=math.inf) - self._wall_s())

    def _until_s(self, row: TransportRow) -> float | None:
        return None if row.vehicle_until_s is None else self._time.to_plant_s(row.vehicle_until_s)

    def _say_due(self, now_s: float) -> None:
        for message in self._reminders.due(now_s):
            if isinstance(message, TransportOrdered | TransportCancelled):
                self._send(self._places[message.transport], message)

    def _forget(self, transport: str) -> None:
        self._reminders.forget(transport)
        self._places.pop(transport, None)

    def row(self, draft: TransportDraft, caller: Principal) -> TransportRow:
        """The row of a draft now; not stored yet.

        Raises:
            Problem: 422, it names unknown or unsuitable places or materials; 403, it exceeds the key's
                limits.
        """
        now_s = self._wall_s()
        item, quantity = (draft.item or "", draft.quantity or 0) if draft.thing is None else (THING, 1)
        source, destination = places_for(
            self._plant,
            self._projection.stations,
            item,
            quantity,
            draft.source or "",
            draft.to or "",
        )
        if errors := self._nonsense(draft, source, destination, caller, now_s):
            raise unusable(*errors)
        speed = self._projection.speed
        begin_s = now_s if draft.not_before is None else max(now_s, draft.not_before.timestamp())
        if caller.calls is not None:
            refuse_beyond(caller.calls, draft, source, destination, begin_s, speed)
        within_s = begin_s + TRANSPORT_WITHIN_S[draft.priority] / speed
        due_s = within_s if draft.due_at is None else draft.due_at.timestamp()
        if draft.priority in (Priority.HIGH, Priority.URGENT):
            due_s = min(due_s, within_s)
        return TransportRow(
            id=self._ids.next(now_s),
            source=source,
            destination=destination,
            item=item,
            thing=draft.thing or "",
            quantity=quantity,
            priority=draft.priority.value,
            vehicle=draft.vehicle or "",
            vehicle_until_s=begin_s + WISH_S / speed if draft.vehicle and not draft.vehicle_only else None,
            ability=draft.ability or "",
            called_by=caller.name,
            caller=caller.key,
            created_at_s=now_s,
            due_at_s=due_s,
            not_before_s=None if draft.not_before is None else draft.not_before.timestamp(),
            wait=HELD if begin_s > now_s else "",
            updated_at_s=now_s,
        )

    def _nonsense(
        self, draft: TransportDraft, source: str, to: str, caller: Principal, now_s: float
    ) -> list[FieldError]:
        """Faults of a well-formed draft."""
        plant, item, quantity = self._plant, draft.item, draft.quantity
        if draft.thing is not None:
            carried = draft.ability or ""
            errors = self._nonsense_of_thing(draft, source, to)
            return errors + self._nonsense_beside(draft, {carried} - {""}, source, to, caller, now_s)
        if item is None or quantity is None:
            return [FieldError("item" if item is None else "quantity", "it is missing", "missing")]
        if item in plant.products and item not in plant.parts:
            return [FieldError.of("item", "item_is_product", item=item)]
        if item not in plant.materials:
            return [FieldError.of("item", "material_unknown", item=item)]
        errors, spec = misplaced(plant, item, source, to), plant.materials[item]
        if quantity > spec.lot:
            loads = loads_text(quantity, spec.lot)
            errors.append(FieldError.of("quantity", "load_too_large", item=item, most=spec.lot, loads=loads))
        errors += self._nobody_able(draft.ability, spec.ability)
        wanted = {spec.ability, draft.ability or spec.ability}
        return errors + self._nonsense_beside(draft, wanted, source, to, caller, now_s)

    def _nonsense_of_thing(self, draft: TransportDraft, source: str, to: str) -> list[FieldError]:
        """Faults of a draft for a thing without master data."""
        errors = thing_misplaced(self._plant, source, to)
        if draft.item is not None:
            errors.append(FieldError.of("item", "thing_alone"))
        if draft.quantity not in (None, 1):
            errors.append(FieldError.of("quantity", "thing_is_one"))
        if draft.ability is None or not any(draft.ability in has for has in self._abilities()):
            named = ", ".join(sorted({each for has in self._abilities() for each in has}))
            errors.append(FieldError.of("ability", "thing_ability", abilities=named))
        return errors

    def _nonsense_beside(
        self, draft: TransportDraft, wanted: set[str], source: str, to: str, caller: Principal, now_s: float
    ) -> list[FieldError]:
        """Faults of a draft in caller, vehicle (which needs the abilities `wanted`) and times."""
        errors, places = [], self.places_of(caller)
        if places is not None and places.isdisjoint((source, to)):
            errors.append(FieldError.of("to", "not_your_area"))
        if draft.vehicle is not None:
            errors += self._unfit(draft.vehicle, wanted)
        if draft.due_at is not None and draft.due_at.timestamp() <= now_s:
            now = datetime.fromtimestamp(now_s, UTC).isoformat(timespec="seconds")
            errors.append(FieldError.of("due_at", "past", now=now))
        elif draft.due_at is not None and draft.not_before is not None and draft.due_at <= draft.not_before:
            due = draft.due_at.isoformat(timespec="seconds")
            errors.append(FieldError.of("not_before", "not_after_due", due=due))
        return errors

    def _abilities(self) -> list[tuple[str, ...]]:
        """Abilities by type of vehicle, for the plant file's vehicles and those that have joined."""
        kinds = self._plant.vehicle_types
        types = {each.type for each in self._plant.fleet.values()}
        types |= {each.type for each in self._projection.atvs.views()}
        return [kinds[each].abilities for each in sorted(types & kinds.keys())]

    def _nobody_able(self, wanted: str | None, carried: str) -> list[FieldError]:
        """The fault if no vehicle carries the material, or none of those has the extra ability."""
        has = self._abilities()
        if any({wanted or carried, carried} <= set(abilities) for abilities in has):
            return []
        named = sorted({ability for abilities in has for ability in abilities if carried in abilities})
        if not named:
            return [FieldError.of("item" if wanted is None else "ability", "ability_nobody", carried=carried)]
        return [
            FieldError.of(
                "ability", "ability_unknown", carried=carried, wanted=wanted, abilities=", ".join(named)
            )
        ]

    def _unfit(self, vehicle: str, wanted: set[str]) -> list[FieldError]:
        view = self._projection.atvs.view(vehicle)
        if view is None:
            return [FieldError.of("vehicle", "vehicle_unknown", vehicle=vehicle)]
        kind = self._plant.vehicle_types.get(view.type)
        if kind is not None and (lacking := wanted.difference(kind.abilities)):
            abilities = ", ".join(sorted(lacking))
            return [FieldError.of("vehicle", "vehicle_lacks", vehicle=vehicle, abilities=abilities)]
        return []


def loads_text(pieces: int, most: int) -> str:
    """The loads of so many pieces, with a maximum per load: as ``2 x 40 + 20``."""
    full, rest = divmod(pieces, most)
    return f"{full} x {most}" + (f" + {rest}" if rest else "")


def _kept(row: TransportRow) -> KeptAnswer:
    return KeptAnswer(row.key or "", row.fingerprint, row.id, row.answer, row.created_at_s)


def _ended_here(row: TransportRow, now_s: float) -> TransportRow:
    """A transport that was cancelled before any place was asked."""
    return msgspec.structs.replace(
        row,
        status=TransportState.CANCELLED,
        wait="",
        cancel_at_s=now_s,
        ended_at_s=now_s,
        updated_at_s=now_s,
    )


def _too_many() -> Problem:
    return Problem(
        HTTPStatus.SERVICE_UNAVAILABLE,
        "too-many-transports",
        "Too many transports are open",
        f"{OPEN_MAX} have not ended; call some off, or try again later",
        headers={"Retry-After": "600"},
    )


def _too_late(row: TransportRow) -> Problem:
    return Problem(
        HTTPStatus.CONFLICT,
        "transport-on-its-way",
        "The transport cannot be called off any more",
        f"transport {row.id} is {row.status.value}; what has arrived can be taken away by another transport",
    )

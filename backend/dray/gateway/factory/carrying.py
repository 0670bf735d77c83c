"""Carrying: vehicles that people have carried away and put back, in SQL, on the panels and on the bus.

A removal is published (`announced.py`) with a grant for a limited time, until the vehicle is heard. The
keepers of reservation tables decide whether to believe it (`dray.messages.floor.removal`). They report places
freed and kept as facts, and why they refuse it.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from http import HTTPStatus

import msgspec

from dray.adapters.security.signing import SigningKey
from dray.gateway.access.principal import Principal
from dray.gateway.factory.announced import Announced
from dray.gateway.http.problems import Problem
from dray.gateway.live.projection import Projection
from dray.gateway.live.projection.agents.removals import Removals as ShownRemovals
from dray.gateway.live.timescale import TimeScale
from dray.gateway.live.views import RemovalView
from dray.messages import AtvHeartbeat, Event, Removals
from dray.messages.base import CLOCKS_AGREE_S
from dray.messages.fact import AnyFact
from dray.messages.floor.removal import MAX_REMOVALS
from dray.protocol.liveness.suspicion import LATENESS_MAX_S, gone_s, interval_s
from dray.store import Store
from dray.store.factory.removals import RemovalRow
from dray.store.history.events import EventFilter

_log = logging.getLogger(__name__)

GRANT_S = 60.0
"""Validity of one publication in wall seconds."""

SURELY_AFTER_S = CLOCKS_AGREE_S + LATENESS_MAX_S
"""A vehicle's word this long after a report (s) is surely later than the report, whatever its numbers."""

FACTS = 1_000
"""Maximum answers of machines that are read at the start: several from each machine for each vehicle that is off the floor."""


class Carrying(Announced):
    """Stores and publishes removals.

    Args:
        store: the database.
        projection: shows removals, and knows when vehicles were heard.
        authority: signs removals.
        say: publishes to all agents.
        time: plant clock and wall clock.
        wall_s: the wall clock.
    """

    EVERY_S = 2.0

    WHAT = "which vehicles were carried away"

    def __init__(
        self,
        store: Store,
        projection: Projection,
        authority: SigningKey,
        say: Callable[[Removals], None],
        *,
        time: TimeScale,
        wall_s: Callable[[], float],
    ) -> None:
        super().__init__(store, wall_s)
        self._projection, self._authority = projection, authority
        self._say, self._time = say, time
        self._rows: list[RemovalRow] = []
        self._logged: set[tuple[str, int, str, str]] = set()
        """Refusals in the log: vehicle, number of the report, who refuses it, and why."""

    async def restore(self) -> None:
        """See `Announced.restore`. Machines tell their answers once: those to valid reports come from SQL."""
        await super().restore()
        if not self._rows:
            return
        wanted = EventFilter(kinds=tuple(kind.__name__ for kind in ShownRemovals.heeded))
        async with self._store.read() as work:
            rows = await work.events.page(wanted, None, FACTS, newest_first=True)
        for row in reversed(rows):
            try:
                fact = msgspec.json.decode(row.fact, type=AnyFact)
            except msgspec.MsgspecError:
                continue  # It was written by another version of Dray.
            event = Event(
                agent=row.agent, incarnation=row.incarnation, number=row.number, at_s=row.plant_s, fact=fact
            )
            self._projection.atvs.mark(self._projection.removals.fold(event))

    async def carry_away(self, atv: str, by: Principal) -> None:
        """Note that a vehicle is off the floor.

        Raises:
            Problem: 409, the vehicle is heard.
            UnavailableError: it could not be stored, and nothing was done.
        """
        self._refuse_if_heard(atv)
        await self._put(atv, "", by)

    async def put_back(self, atv: str, node: str, by: Principal) -> None:
        """Note that a removed vehicle is being put back at a node.

        Raises:
            Problem: 409, the vehicle is heard, nobody has reported it as removed, or another vehicle holds
                that place.
            UnavailableError: it could not be stored, and nothing was done.
        """
        self._refuse_if_heard(atv)
        if self._projection.removals.view(atv) is None:
            raise Problem(
                HTTPStatus.CONFLICT,
                "not-carried-away",
                "The vehicle is on the floor",
                f"nobody has said that {atv} was carried away; POST /api/atvs/{atv}/carried-away first",
            )
        for other in self._projection.atvs.views():
            if other.id != atv and node in (*other.holds, other.node) and other.removal is None:
                raise Problem(
                    HTTPStatus.CONFLICT,
                    "place-held",
                    "Another vehicle holds this place",
                    f"{other.id} holds {node}; choose another place, or wait until it has driven on",
                )
        await self._put(atv, node, by)

    def _refuse_if_heard(self, atv: str) -> None:
        heard_s = self._heard_s(atv)
        if heard_s is not None:
            raise Problem(
                HTTPStatus.CONFLICT,
                "is-heard",
                "The vehicle is heard",
                f"{atv} was heard {heard_s:.0f} s ago: switch it off, and say so when nobody hears it any more",
            )

    def _heard_s(self, atv: str) -> float | None:
        """Factory seconds since a live vehicle was heard.

        None if it is silent or was never heard.
        """
        view, last = self._projection.atvs.view(atv), self._projection.atvs.last(atv)
        if view is None or last is None:
            return None
        silent_s = (self._wall_s() - self._told_at_s(last)) * self._time.speed
        return max(silent_s, 0.0) if silent_s <= view.silence.lost_after_s else None

    async def _put(self, atv: str, node: str, by: Principal) -> None:
        last = self._projection.atvs.last(atv)
        areas = None if by.areas is None else sorted(by.areas)
        row = RemovalRow(
            atv=atv,
            number=0,
            life=0 if last is None else last.incarnation,
            seq=0 if last is None else last.seq,
            node=node,
            areas=msgspec.json.encode(areas).decode(),
            by=by.name,
            person=f"{by.kind}:{by.id}",
            at_s=self._wall_s(),
        )
        async with self._store.write() as work:
            await work.removals.put(row)
        await self.look()

    async def _read(self) -> None:
        async with self._store.read() as work:
            rows = await work.removals.all()
        rows = [await self._completed(row) for row in rows]
        back = [row for row in rows if self._is_back(row)]
        if back:
            async with self._store.write() as work:
                for row in back:
                    await work.removals.end(row.atv, row.number, self._wall_s())
        self._rows = [row for row in rows if row not in back]
        self._projection.show_removals((row.atv, self._view(row)) for row in self._rows)
        self._log_refusals()

    def _log_refusals(self) -> None:
        """Log each refusal once: whoever uses `dray carried-away` has no panel."""
        refused: set[tuple[str, int, str, str]] = set()
        for row in self._rows:
            view = self._projection.removals.view(row.atv)
            for each in () if view is None else view.refused:
                name = (row.atv, row.number, each.agent, each.reason)
                refused.add(name)
                if name not in self._logged:
                    _log.warning(
                        "%s does not believe that %s was carried away: %s", each.agent, row.atv, each.text
                    )
        self._logged = refused

    async def _completed(self, row: RemovalRow) -> RemovalRow:
        """Complete a removal entered elsewhere.

        One from a console gets the last heartbeat; for a live vehicle it stays void. One from the future, by a computer whose clock is
        wrong, counts from now on: a vehicle that is heard until then is on the floor.
        """
        last, now_s = self._projection.atvs.last(row.atv), self._wall_s()
        full = row
        if row.is_bare and last is not None and self._heard_s(row.atv) is None:
            full = msgspec.structs.replace(full, life=last.incarnation, seq=last.seq)
        if row.at_s > now_s + CLOCKS_AGREE_S:
            full = msgspec.structs.replace(full, at_s=now_s)
        if full is row:
            return row
        async with self._store.write() as work:
            return await work.removals.put(full)

    def _is_back(self, row: RemovalRow) -> bool:
        """Whether the vehicle was heard after the report.

        By the time, if its numbers are lower: its journal is lost, or a thief has sent the named heartbeat.
        """
        last = self._projection.atvs.last(row.atv)
        if last is None:
            return False
        return (last.incarnation, last.seq) > row.heard or self._told_at_s(last) > row.at_s + SURELY_AFTER_S

    def _told_at_s(self, last: AtvHeartbeat) -> float:
        """When a vehicle has told its last heartbeat (wall clock): not after it came, however far its clock is ahead."""
        came_s = self._projection.atvs.heard_s(last.atv)
        return self._time.to_wall_s(last.at_s if came_s is None else min(last.at_s, came_s))

    def _view(self, row: RemovalRow) -> RemovalView:
        last = self._projection.atvs.last(row.atv)
        believed_s = row.at_s
        if last is not None:
            believed_s = max(believed_s, self._told_at_s(last) + gone_s(interval_s(last)) / self._time.speed)
        return RemovalView(
            number=row.number, by=row.by, at_s=row.at_s, believed_at_s=believed_s, node=row.node
        )

    def say(self) -> None:
        """Publish the removals of vehicles that are not back."""
        now_s = self._time.to_plant_s(self._wall_s())
        removals = [
            self._authority.remove(
                row.atv,
                row.number,
                heard=row.heard,
                node=row.node,
                person=row.person,
                areas=row.granted_in,
                reported_s=self._time.to_plant_s(row.at_s),
                now_s=now_s,
                valid_until_s=now_s + GRANT_S * self._time.speed,
            )
            for row in self._rows
            if not self._is_back(row)
        ]
        for first in range(0, len(removals), MAX_REMOVALS):
            self._say(Removals(removals=tuple(removals[first : first + MAX_REMOVALS])))

"""Closings: what people have closed to vehicles, in SQL, on the panels and on the bus.

The list is signed and published (`announced.py`). The gateway ends an expired closure, and so does every
vehicle itself.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from http import HTTPStatus
from secrets import token_hex

import msgspec
from msgspec.structs import replace

from dray.adapters.security.signing import SigningKey
from dray.gateway.factory.announced import Announced
from dray.gateway.http.problems import Problem, not_found
from dray.gateway.live.projection import Projection
from dray.gateway.live.timescale import TimeScale
from dray.gateway.live.views import ClosureView, CornerView, LaneView
from dray.messages import Closure, ClosureKind, Closures
from dray.messages.floor.closure import MAX_CLOSURES, Corner
from dray.plant import Plant
from dray.protocol.closures.closure_rules import cut_off, lanes_of, restrictions_of, shut_in
from dray.store import Store
from dray.store.factory.closures import ClosureRow


class Outlook(msgspec.Struct, frozen=True, kw_only=True):
    """The effect of a closure, together with those in force."""

    cut_off: tuple[str, ...]
    """Places that this closure, and none before, would cut off."""
    shut_in: tuple[str, ...]
    """Vehicles that could not leave their place."""


class Closings(Announced):
    """Stores and publishes closures.

    Args:
        store: the database.
        projection: shows closures.
        authority: signs the list for vehicles.
        say: publishes to all agents.
        time: plant clock and wall clock.
        wall_s: the wall clock.
    """

    EVERY_S = 5.0
    """Maximum wall seconds until a vehicle that returns hears of a new closure."""

    WHAT = "what was closed"

    def __init__(
        self,
        store: Store,
        projection: Projection,
        authority: SigningKey,
        say: Callable[[Closures], None],
        *,
        time: TimeScale,
        wall_s: Callable[[], float],
    ) -> None:
        super().__init__(store, wall_s)
        self._projection, self._authority = projection, authority
        self._say, self._time = say, time
        self._said: Closures | None = None
        self._seen: tuple[int, Plant] | None = None
        """Number of the list shown, and the plant for which its lanes were computed."""

    @property
    def now_s(self) -> float:
        """The wall clock."""
        return self._wall_s()

    async def close(self, wanted: ClosureRow) -> tuple[ClosureView, bool]:
        """Add a closure.

        Args:
            wanted: the decision; its id is ignored.

        Returns:
            The closure in force, and whether it is new: the same closure for the same time changes nothing.

        Raises:
            Problem: 409, too much is closed.
            UnavailableError: it could not be stored, and nothing was done.
        """
        async with self._store.write() as work:
            rows = await work.closures.all()
            row = next((each for each in rows if _is_same(each, wanted)), None)
            is_new = row is None
            if row is None:
                if len(rows) >= MAX_CLOSURES:
                    raise Problem(
                        HTTPStatus.CONFLICT,
                        "too-much-closed",
                        "Too much is closed",
                        f"{MAX_CLOSURES} closures hold, and a list holds no more; end some with DELETE /api/closures/ID, or close an area or an outline",
                    )
                row = replace(wanted, id=f"c{token_hex(4)}")
                await work.closures.put(row)
        await self.look()
        return self._shown(row), is_new

    async def open(self, closure: str) -> ClosureView:
        """End a closure; returns it as it was.

        Raises:
            Problem: 404, there is no such closure.
            UnavailableError: it could not be stored, and nothing was done.
        """
        async with self._store.write() as work:
            row = await work.closures.get(closure)
            if row is None:
                raise not_found("closure", closure, "GET /api/closures")
            shown = self._shown(row)
            await work.closures.end(closure, self._wall_s())
        await self.look()
        return shown

    def preview(self, wanted: ClosureRow) -> Outlook:
        """The effect that a closure would have now."""
        plant = self._projection.site.plant
        before = [] if self._said is None else list(self._said.closures)
        now, then = restrictions_of(plant, before), restrictions_of(plant, [*before, self._told(wanted)])
        known = set(cut_off(plant, now))
        nodes = {each.atv: each.node for each in self._projection.atvs.heartbeats()}
        return Outlook(
            cut_off=tuple(place for place in cut_off(plant, then) if place not in known),
            shut_in=shut_in(plant, then, nodes),
        )

    def say(self) -> None:
        """Publish the list, unless nothing was ever closed."""
        if self._said is not None:
            self._say(self._said)

    async def _read(self) -> None:
        now_s = self._wall_s()
        async with self._store.read() as work:
            rows, number = await work.closures.all(), await work.closures.number()
        over = [row for row in rows if row.until_s is not None and row.until_s <= now_s]
        if over:
            async with self._store.write() as work:
                for row in over:
                    await work.closures.end(row.id, now_s)
                rows, number = await work.closures.all(), await work.closures.number()
        plant = self._projection.site.plant
        if self._seen == (number, plant):
            return
        if number:
            self._said = self._authority.close(number, map(self._told, rows))
        self._seen = number, plant
        views = self._views(rows)
        self._projection.closures.put(zip(views, (row.number for row in rows), strict=True))
        self._projection.orders.cut_off({place for view in views for place in view.cut_off})

    def _told(self, row: ClosureRow) -> Closure:
        """The closure as vehicles get it."""
        return Closure(
            closure=row.id or "preview",
            kind=ClosureKind(row.kind),
            by=row.person,
            start=row.start_node,
            end=row.end_node,
            node=_node_of(self._projection.site.plant, row.place),
            area=row.area,
            outline=corners_of(row.outline),
            speed_mps=row.speed_mps,
            until_s=None if row.until_s is None else self._time.to_plant_s(row.until_s),
        )

    def _shown(self, row: ClosureRow) -> ClosureView:
        known = next((view for view in self._projection.closures.views() if view.id == row.id), None)
        return self._views([row])[0] if known is None else known

    def _views(self, rows: Iterable[ClosureRow]) -> list[ClosureView]:
        plant = self._projection.site.plant
        told = [(row, self._told(row)) for row in rows]
        lost = cut_off(plant, restrictions_of(plant, [closure for _, closure in told]))
        return [
            ClosureView(
                id=row.id,
                kind=closure.kind.value,
                lane=LaneView(start=row.start_node, end=row.end_node) if row.start_node else None,
                place=row.place,
                area=row.area,
                outline=tuple(CornerView(x_m=x_m, y_m=y_m) for x_m, y_m in closure.outline),
                speed_mps=row.speed_mps,
                until_at_s=row.until_s,
                reason=row.reason,
                by=row.by,
                at_s=row.at_s,
                lanes=tuple(LaneView(start=start, end=end) for start, end in lanes_of(plant, closure)),
                cut_off=lost if row.kind != ClosureKind.SLOW else (),
            )
            for row, closure in told
        ]


def outline_of(corners: Iterable[Corner]) -> str:
    """Corners as text for SQL."""
    return msgspec.json.encode(tuple(corners)).decode()


def corners_of(outline: str) -> tuple[Corner, ...]:
    """Corners from SQL's text."""
    return msgspec.json.decode(outline, type=tuple[Corner, ...]) if outline else ()


def _node_of(plant: Plant, place: str) -> str:
    """The node of a place; a node or a crossing is its own."""
    if not place or place in plant.nodes or place in plant.crossings:
        return place
    return plant.node_of(place)


def _is_same(one: ClosureRow, other: ClosureRow) -> bool:
    return one.subject == other.subject and one.until_s == other.until_s

"""The reader: finds the pieces of a moment in SQL and among unwritten ones, and rebuilds the moment.

A read takes only what lies between two snapshots, however much is stored, and decodes one piece at a time.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import TypeVar, cast

import msgspec
from msgspec.structs import replace

from dray.gateway.access.principal import Principal
from dray.gateway.live.frames import COLLECTIONS, PORTION, Delta, Snapshot
from dray.gateway.live.plant_picture import PlantPicture
from dray.gateway.live.replay.film import Film, Picture
from dray.gateway.live.replay.knowledge import Involvement, involvement
from dray.gateway.live.replay.recorder import Mark, Recorder
from dray.gateway.live.stream import audience_of, scope_of
from dray.gateway.live.updates import Updates, array, joined
from dray.gateway.live.views.base import View
from dray.store import Store
from dray.store.replay.recordings import PIECES_READ, Outline, Piece
from dray.store.replay.spells import Spell

Told = TypeVar("Told")

FRAMES_BYTES = 4 * 2**20
"""Maximum bytes of frames per answer: some seconds of a browser's time. Clients ask on from its end."""

GAP_S = 5.0
"""Wall seconds without a recording that count as a gap: a panel turns amber after 3."""

MARKS_MOST = 500
"""Maximum marks per answer: more than fit on a screen. Warnings are left out first."""


class FilmView(View, kw_only=True):
    """A past moment and the changes after it: frames as on the stream, the first follows the snapshot."""

    snapshot: Snapshot
    frames: tuple[Delta, ...] = ()
    until_at_s: float
    """End of the frames; earlier than asked for if one answer cannot hold more, or nothing more is stored."""


class StretchView(View, kw_only=True):
    """A span of time with a recording and without a gap."""

    from_at_s: float
    until_at_s: float


class OverviewView(View, kw_only=True):
    """The recordings within a span of time."""

    kept_from_at_s: float | None
    """The oldest moment stored; None if nothing is."""
    kept_until_at_s: float | None
    stretches: tuple[StretchView, ...] = ()
    """Oldest first; nothing was recorded between two of them."""
    density: tuple[int, ...] = ()
    """Number of task changes and news in equal parts of the time."""
    marks: tuple[Mark, ...] = ()
    """Oldest first."""
    marks_left_out: int = 0


NOW = "atvs", "machines", "stations"
"""Collections that a present picture takes from the live view."""

_MANY = tuple(COLLECTIONS.values())


class ReplayReader:
    """Reads recordings.

    Args:
        store: the recordings.
        recorder: this gateway's recorder, which has the newest frames.
        live: the present picture that panels are shown.
    """

    def __init__(self, store: Store, recorder: Recorder | None, live: PlantPicture) -> None:
        self._store, self._recorder, self._live = store, recorder, live
        self._site = live.site

    def _recorded(self) -> Callable[[], Picture] | None:
        """Makes the present picture, in any thread; None where nothing is recorded."""
        told = None if self._recorder is None else self._recorder.now()
        if told is None:
            return None
        fresh = {name: msgspec.to_builtins(getattr(self._live, name).views()) for name in NOW}
        return lambda: Picture(told.plain() | fresh, self._site)

    async def snapshot_now(self, who: Principal, now_s: float) -> bytes:
        """The present snapshot as JSON, as this caller may see it.

        A large picture is not kept on the loop: freeing one takes 0.2 s.
        """
        make = self._recorded()
        if make is None:
            return await self._live_snapshot(who, now_s)

        def encode() -> bytes:
            snapshot = scope_of(make(), who).snapshot(0, now_s)
            return _whole(snapshot, who, {name: array(getattr(snapshot, name)) for name in _MANY})

        return await asyncio.to_thread(encode)

    async def _live_snapshot(self, who: Principal, now_s: float) -> bytes:
        """The same where nothing is recorded, encoded in portions to let other work run."""
        scope = scope_of(self._live, who)
        snapshot = scope.snapshot(0, now_s, PORTION)
        views = {name: [array(getattr(snapshot, name))] for name in _MANY}
        for collection, names in scope.rest(PORTION).items():
            for at in range(0, len(names), PORTION):
                await asyncio.sleep(0)
                views[collection].append(array(scope.views(collection, names[at : at + PORTION])))
        return await asyncio.to_thread(
            lambda: _whole(snapshot, who, {name: joined(each) for name, each in views.items()})
        )

    async def involvement_now(self, agent: str, now_s: float) -> Involvement:
        """What the present plant tells of an agent and its tasks: looked up in portions, without a picture."""
        for latest in involvement(self._live, agent, now_s):
            found = latest
            await asyncio.sleep(0)
        return found

    async def involvement(self, agent: str, at_s: float) -> Involvement | None:
        """What a moment's picture tells of an agent and its tasks; None where nothing is stored up to then.

        The picture stays in its thread: converting one, and freeing it, would hold up the loop.
        """
        pieces = await self._pieces(at_s, at_s)

        def look() -> Involvement | None:
            picture = Film(pieces, self._site).play_until(at_s)
            return None if picture is None else deque(involvement(picture, agent, at_s), maxlen=1).pop()

        return await asyncio.to_thread(look)

    async def film(
        self,
        who: Principal,
        since_s: float,
        until_s: float,
        every_s: float,
        tell: Callable[[FilmView], Told],
    ) -> Told | None:
        """A moment and the changes after it, as a caller may see them; None where nothing is stored.

        The film stays in its thread: freeing a large one takes 0.1 s.

        Args:
            who: the caller.
            since_s: the moment.
            until_s: end of the changes.
            every_s: minimum seconds between frames; closer changes are joined.
            tell: makes of the film what is wanted of it, in that thread.
        """
        pieces = await self._pieces(since_s, until_s)

        def look() -> Told | None:
            film = self._film(who, pieces, since_s, until_s, every_s)
            return None if film is None else tell(film)

        return await asyncio.to_thread(look)

    def _film(
        self, who: Principal, pieces: Sequence[Piece], since_s: float, until_s: float, every_s: float
    ) -> FilmView | None:
        film = Film(pieces, self._site)
        picture = film.play_until(since_s)
        if picture is None:
            return None
        scope = scope_of(picture, who)
        snapshot = scope.snapshot(0, picture.at_s)
        snapshot = replace(snapshot, audience=audience_of(who))
        updates = Updates()
        frames: list[msgspec.Raw] = []
        size, told_s, newest_s = 0, picture.at_s, picture.at_s
        for number, delta in enumerate(film.frames(until_s)):
            if number == 0:
                # A moment without changes after it needs none of this, which is a third of its work.
                updates.begin(snapshot)
            if updates.waiting and delta.at_s - told_s >= every_s:
                frames.append(msgspec.Raw(msgspec.json.encode(updates.frame(len(frames) + 1, newest_s))))
                size, told_s = size + len(frames[-1]), delta.at_s
                if size > FRAMES_BYTES:
                    return FilmView(snapshot=snapshot, frames=_as_told(frames), until_at_s=newest_s)
            updates.note(scope.delta(delta))
            newest_s = delta.at_s
        if updates.waiting:
            frames.append(msgspec.Raw(msgspec.json.encode(updates.frame(len(frames) + 1, newest_s))))
        # If one read could not hold all pieces, the film ends with the last piece read.
        end_s = until_s if len(pieces) < PIECES_READ else pieces[-1].until_at_s
        return FilmView(
            snapshot=snapshot, frames=_as_told(frames), until_at_s=max(since_s, newest_s, min(until_s, end_s))
        )

    async def overview(self, since_s: float, until_s: float, steps: int, *, orders: bool) -> OverviewView:
        """The recordings from one moment to another.

        Args:
            since_s: the begin.
            until_s: the end.
            steps: number of parts in which changes are counted.
            orders: whether the caller may see marks of orders.
        """
        async with self._store.read() as work:
            span = await work.recordings.span()
            outlines = await work.recordings.outlines(since_s, until_s)
        unwritten = await self._unwritten()
        outlines += [
            Outline(**{name: getattr(piece, name) for name in Outline.__struct_fields__})
            for piece in unwritten
            if since_s <= piece.from_at_s <= until_s
            and not any(each.from_at_s == piece.from_at_s for each in outlines[-3:])
        ]
        kept = [
            *(span or ()),
            *(at_s for each in unwritten for at_s in (each.from_at_s, each.until_at_s)),
        ]
        return _overview(outlines, (since_s, until_s), steps, kept, orders=orders)

    async def spells(self, since_s: float, until_s: float, agents: Sequence[str], limit: int) -> list[Spell]:
        """What agents did in a span, in order of end; unwritten spells come last."""
        async with self._store.read() as work:
            found = await work.spells.between(since_s, until_s, agents, limit)
        if self._recorder is not None:
            found += [
                each
                for each in self._recorder.spells()
                if each.until_at_s > since_s
                and each.from_at_s < until_s
                and (not agents or each.agent in agents)
            ]
        return found[:limit]

    async def _unwritten(self) -> list[Piece]:
        return [] if self._recorder is None else await self._recorder.unwritten()

    async def _pieces(self, since_s: float, until_s: float) -> list[Piece]:
        # Read memory first: a piece written meanwhile is then found twice, not missed.
        fresh = [piece for piece in await self._unwritten() if piece.from_at_s <= until_s]
        whole = [at for at, piece in enumerate(fresh) if piece.is_whole and piece.from_at_s <= since_s]
        if whole:
            return fresh[whole[-1] :]
        async with self._store.read() as work:
            pieces = await work.recordings.pieces(since_s, until_s)
        if pieces and fresh:
            written_s = max(piece.from_at_s for piece in pieces)
            pieces += [piece for piece in fresh if piece.from_at_s > written_s]
        return pieces


def _as_told(frames: Sequence[msgspec.Raw]) -> tuple[Delta, ...]:
    """Frames that are encoded already: known entities have only their changed fields."""
    return cast(tuple[Delta, ...], tuple(frames))


def _overview(
    outlines: Sequence[Outline],
    span_s: tuple[float, float],
    steps: int,
    kept_s: Sequence[float],
    *,
    orders: bool,
) -> OverviewView:
    since_s, until_s = span_s
    density, stretches = [0] * steps, list[list[float]]()
    marks: list[Mark] = []
    for each in outlines:
        part = int((each.from_at_s - since_s) / (until_s - since_s) * steps)
        density[min(part, steps - 1)] += each.changes
        if stretches and each.from_at_s - stretches[-1][1] <= GAP_S:
            stretches[-1][1] = max(stretches[-1][1], each.until_at_s)
        else:
            stretches.append([each.from_at_s, each.until_at_s])
        if each.marks:
            told = msgspec.json.decode(each.marks, type=list[Mark])
            marks += [mark for mark in told if since_s <= mark.at_s <= until_s and (orders or not mark.order)]
    grave = [mark for mark in marks if mark.kind != "alert"] if len(marks) > MARKS_MOST else marks
    shown = sorted(grave[-MARKS_MOST:], key=lambda mark: mark.at_s)
    return OverviewView(
        kept_from_at_s=min(kept_s, default=None),
        kept_until_at_s=max(kept_s, default=None),
        stretches=tuple(StretchView(from_at_s=begin, until_at_s=end) for begin, end in stretches),
        density=tuple(density),
        marks=tuple(shown),
        marks_left_out=len(marks) - len(shown),
    )


def _whole(snapshot: Snapshot, who: Principal, views: Mapping[str, msgspec.Raw]) -> bytes:
    """A snapshot as JSON with encoded collections, for a caller."""
    head = replace(snapshot, audience=audience_of(who), **dict.fromkeys(views, ()))
    return msgspec.json.encode(msgspec.to_builtins(head) | views)

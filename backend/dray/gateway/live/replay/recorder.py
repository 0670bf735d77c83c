"""The recorder: keeps what a panel of the whole plant is told, so that every moment can be shown again as it was.

It is told what all rooms of the stream are told. Every few minutes it keeps a snapshot, and after it what has changed, frame
by frame: the picture of a moment is the snapshot before it with the frames up to it. Pieces of half a minute are compressed and
written; what is not written yet is in memory, and can be read there.

Several gateways see the same plant. The first one writes a time, and the others leave it out.
"""

from __future__ import annotations

import asyncio
import logging
import zlib
from collections import deque
from collections.abc import Callable
from typing import Any, Literal

import msgspec

from dray.errors import UnavailableError
from dray.gateway.live.frames import Delta
from dray.gateway.live.projection import Projection
from dray.gateway.live.replay.spells import SpellKeeper
from dray.gateway.live.updates import Updates
from dray.gateway.live.views import AlertView, FactoryView, NewsView
from dray.store import Store
from dray.store.replay.recordings import Piece
from dray.store.replay.spells import Spell

DAY_S = 86_400.0

WHOLE_EVERY_S = 300.0
"""Wall seconds between two snapshots: what lies between them is folded within a few hundredths of a second."""

WRITE_EVERY_S = 30.0
"""Wall seconds of one piece: long enough to compress well, and short enough that little is lost with a process."""

UNWRITTEN_MOST = 20
"""Pieces that wait while the database is away: ten minutes, 4 MB at most; then what is recorded begins anew."""

PIECES_FORGOTTEN, SPELLS_FORGOTTEN = 100, 5_000
"""At most with each writing, some hundredths of a second: where less is to be kept than before, nobody waits for weeks of it to be forgotten."""

PIECE_BYTES = 2**20
"""Of frames before they are compressed, which takes some 20 ms: where more is told, pieces are shorter."""

LEVEL = 6
"""Of compression: more costs twice the time for some percent."""

_encode = msgspec.json.encode
_log = logging.getLogger(__name__)


MarkKind = Literal["takeover", "failure", "alert", "late"]


class Mark(msgspec.Struct, frozen=True, kw_only=True, gc=False):
    """Something that people look for."""

    at_s: float
    kind: MarkKind
    about: str
    """The kind of the news or of the alert."""
    agent: str = ""
    other: str = ""
    task: str = ""
    order: str = ""


class Recorder:
    """Keeps what the stream tells.

    Args:
        projection: what is shown.
        store: where to.
        wall_s: the wall clock.
        name: of this gateway in this life.
        kept_s: how long, wall clock.
    """

    def __init__(
        self, projection: Projection, store: Store, wall_s: Callable[[], float], *, name: str, kept_s: float
    ) -> None:
        self._projection, self._store, self._wall_s = projection, store, wall_s
        self._name, self._kept_s = name, kept_s
        self._updates = Updates()
        self._factory: FactoryView | None = None
        """As it was told last."""
        self._whole_at_s: float | None = None
        """When the last snapshot was kept; None where the next frame must be one."""
        self._lines: list[bytes] = []
        self._bytes, self._changes, self._from_at_s, self._is_whole = 0, 0, 0.0, False
        self._marks: list[Mark] = []
        self._known: set[str] = set()
        """Alerts and news that have been marked, or were there before."""
        self._unwritten: deque[Piece] = deque()
        self._is_first = True
        self.keeper = SpellKeeper(projection.speed)

    def note(self, told: Delta) -> None:
        """The stream tells this of the whole plant."""
        if told.factory is not None:
            self._factory = told.factory
        self.keeper.follow(told)
        self._mark(told)
        self._changes += len(told.tasks) + len(told.news)
        if self._bytes > PIECE_BYTES:
            self._close_piece(told.at_s)
        if self._whole_at_s is None or not 0 <= told.at_s - self._whole_at_s < WHOLE_EVERY_S:
            self._begin(told.at_s)
            return
        self._updates.note(told)
        frame = self._updates.frame(0, told.at_s)
        line: dict[str, Any] = {name: part for name, part in frame.items() if part}
        self._keep(line, told.at_s)

    def unwritten(self) -> list[Piece]:
        """What is in memory only, oldest first, up to this moment."""
        return [*self._unwritten, *self._open_piece(self._wall_s())]

    def spells(self) -> list[Spell]:
        """What everybody does now, and what has ended and is not written yet."""
        return self.keeper.under_way(self._wall_s())

    async def run(self) -> None:
        """Write from time to time, until cancelled."""
        while True:
            await asyncio.sleep(WRITE_EVERY_S)
            await self.write()

    async def close(self) -> None:
        """Write what there is: nothing comes after it."""
        self.keeper.end_all(self._wall_s())
        await self.write()

    def cut(self) -> None:
        """End the piece that is under way."""
        self._close_piece(self._wall_s())

    async def write(self) -> None:
        """Write what has been told since the last time."""
        self.cut()
        pieces, spells = list(self._unwritten), self.keeper.take_ended()
        if not pieces:
            return
        try:
            async with self._store.write() as work:
                left_out = await work.recordings.is_kept_by_another(self._name, pieces[0].from_at_s)
                if not left_out:
                    for piece in pieces:
                        await work.recordings.add(piece)
                    await work.spells.add(spells)
                    oldest_s = self._wall_s() - self._kept_s
                    await work.recordings.prune(oldest_s, PIECES_FORGOTTEN)
                    await work.spells.prune(oldest_s, SPELLS_FORGOTTEN)
        except UnavailableError as error:
            _log.warning("what panels show cannot be kept at present: %s", error)
            self.keeper.give_back(spells)
            if len(self._unwritten) > UNWRITTEN_MOST:
                self._unwritten.clear()
                self._whole_at_s = None
            return
        for _ in pieces:
            self._unwritten.popleft()
        if left_out:
            self._whole_at_s = None  # What is written next must not build on it.

    def _begin(self, at_s: float) -> None:
        """Keep a snapshot: everything after it is what is different from it."""
        snapshot = self._projection.snapshot(0, at_s)
        if self._factory is not None:
            snapshot = msgspec.structs.replace(snapshot, factory=self._factory)
        self._close_piece(at_s)
        self._updates = Updates()
        self._updates.begin(snapshot)
        self._whole_at_s, self._is_whole = at_s, True
        if self._is_first:
            self._is_first = False
            self._known = {f"alert:{each.id}" for each in snapshot.alerts}
            self._known |= {f"news:{each.id}" for each in snapshot.news}
            self.keeper.follow(snapshot)
        self._keep(msgspec.to_builtins(snapshot), at_s)

    def _keep(self, line: dict[str, Any], at_s: float) -> None:
        commands = line.get("commands", ())
        if commands:
            areas_of = self._projection.commands.areas_of
            line["areas"] = {each["id"]: sorted(areas_of(each["id"])) for each in commands}
        if not self._lines:
            self._from_at_s = at_s
        self._lines.append(_encode(line))
        self._bytes += len(self._lines[-1])

    def _open_piece(self, until_s: float) -> list[Piece]:
        if not self._lines:
            return []
        return [
            Piece(
                recorder=self._name,
                from_at_s=self._from_at_s,
                until_at_s=max(until_s, self._from_at_s),
                is_whole=self._is_whole,
                changes=self._changes,
                marks=_encode(self._marks).decode() if self._marks else "",
                frames=zlib.compress(b"\n".join(self._lines), LEVEL),
            )
        ]

    def _close_piece(self, until_s: float) -> None:
        self._unwritten.extend(self._open_piece(until_s))
        self._lines.clear()
        self._marks.clear()
        self._bytes, self._changes, self._is_whole = 0, 0, False

    def _mark(self, told: Delta) -> None:
        if self._is_first:
            return
        for name in told.gone:
            self._known.discard(name)
        for kind, views in (("news", told.news), ("alert", told.alerts)):
            for view in views:
                name = f"{kind}:{view.id}"
                if name in self._known:
                    continue
                self._known.add(name)
                mark = _mark_of(view)
                if mark is not None:
                    self._marks.append(mark)


_OF_NEWS: dict[str, MarkKind] = {
    "took_over": "takeover",
    "announced_anew": "takeover",
    "help_asked": "failure",
    "goal_lost": "failure",
    "memory_lost": "failure",
}


def _mark_of(view: Any) -> Mark | None:
    match view:
        case NewsView(kind=about) if about in _OF_NEWS:
            return Mark(
                at_s=view.at_s,
                kind=_OF_NEWS[about],
                about=about,
                agent=view.agent,
                other=view.other,
                task=view.task,
                order=view.order,
            )
        case AlertView(kind=about):
            kind: MarkKind = (
                "late" if about == "order_late" else "failure" if view.level == "alarm" else "alert"
            )
            return Mark(
                at_s=view.since_at_s,
                kind=kind,
                about=about,
                agent=view.agent,
                task=view.task,
                order=view.order,
            )
        case _:
            return None

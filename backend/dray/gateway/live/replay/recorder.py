"""The recorder: stores what a whole-plant panel is sent, so that every moment can be shown again.

It gets what all rooms of the stream get. Every few minutes it stores a snapshot, and then the changes, frame
by frame. A moment is the snapshot before it plus the frames up to it. Pieces of half a minute are compressed
and written; unwritten pieces can be read from memory.

No step of the loop handles everything at once. At the start, orders and tasks are taken in portions, and
recording begins when all are known. Snapshots are encoded and compressed in another thread.

Several gateways see the same plant. The first to write a span of time keeps it; the others skip it.
"""

from __future__ import annotations

import asyncio
import logging
import zlib
from collections import deque
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, Literal

import msgspec

from dray.errors import UnavailableError
from dray.gateway.live.frames import PORTION, Delta
from dray.gateway.live.projection import Projection
from dray.gateway.live.replay.spells import SpellKeeper
from dray.gateway.live.stream_scopes import WholeScope
from dray.gateway.live.updates import Updates, plain, whole
from dray.gateway.live.views import AlertView, FactoryView, NewsView
from dray.store import Store
from dray.store.replay.recordings import Piece
from dray.store.replay.spells import Spell

DAY_S = 86_400.0

WHOLE_EVERY_S = 300.0
"""Wall seconds between two snapshots: frames between them are replayed in a few hundredths of a second."""

WRITE_EVERY_S = 30.0
"""Wall seconds of one piece: long enough to compress well, short enough that a crash loses little."""

UNWRITTEN_MOST = 20
"""Maximum pieces waiting while the database is away: ten minutes, 4 MB at most. Then recording starts
anew."""

PIECES_FORGOTTEN, SPELLS_FORGOTTEN = 100, 5_000
"""Maximum deletions per write, some hundredths of a second. A shorter retention time must not block on
deleting weeks at once."""

PIECE_BYTES = 2**20
"""Maximum bytes of frames before compression, which takes some 20 ms: with more traffic, pieces are
shorter."""

LEVEL = 6
"""Compression level: a higher one takes twice the time for some percent."""

_encode = msgspec.json.encode
_log = logging.getLogger(__name__)


MarkKind = Literal["takeover", "failure", "alert", "late"]


class Mark(msgspec.Struct, frozen=True, kw_only=True, gc=False):
    """An event that people search for."""

    at_s: float
    kind: MarkKind
    about: str
    """Kind of the news or of the alert."""
    agent: str = ""
    other: str = ""
    task: str = ""
    order: str = ""


class Whole:
    """A snapshot that is not encoded yet.

    Args:
        head: its fields other than entities.
        known: see `Updates.known`.
    """

    def __init__(self, head: dict[str, Any], known: dict[str, list[dict[str, Any]]]) -> None:
        self._head, self._known = head, known

    @cached_property
    def line(self) -> bytes:
        """The snapshot as JSON; call outside the loop's thread."""
        return whole(self._head, self._known)

    def plain(self) -> dict[str, Any]:
        """The snapshot as decoded from its line; call outside the loop's thread."""
        told = {name: [plain(fields) for fields in entities] for name, entities in self._known.items()}
        head: dict[str, Any] = msgspec.to_builtins(self._head)
        return head | told


class Lines:
    """The lines of a future piece.

    Args:
        piece: the piece without its frames.
        lines: its frames.
    """

    def __init__(self, piece: Piece, lines: Sequence[Whole | bytes]) -> None:
        self.from_at_s, self.is_whole = piece.from_at_s, piece.is_whole
        self._piece, self._lines = piece, lines

    @cached_property
    def piece(self) -> Piece:
        """The piece, encoded and compressed; call outside the loop's thread."""
        lines = [each.line if isinstance(each, Whole) else each for each in self._lines]
        return msgspec.structs.replace(self._piece, frames=zlib.compress(b"\n".join(lines), LEVEL))


class Recorder:
    """Records the stream.

    Args:
        projection: the live projection.
        store: the database.
        wall_s: the wall clock.
        name: id of this gateway process.
        kept_s: retention time, wall seconds.
    """

    def __init__(
        self, projection: Projection, store: Store, wall_s: Callable[[], float], *, name: str, kept_s: float
    ) -> None:
        self._projection, self._store, self._wall_s = projection, store, wall_s
        self._name, self._kept_s = name, kept_s
        self._scope = WholeScope(projection)
        self._updates = Updates()
        self._factory: FactoryView | None = None
        """Last figures sent."""
        self._owed: dict[str, deque[str]] | None = None
        """Ids not taken in yet, by collection; None before the start."""
        self._whole_at_s: float | None = None
        """Time of the last snapshot; None if the next frame must be one."""
        self._lines: list[Whole | bytes] = []
        self._bytes, self._changes, self._from_at_s, self._is_whole = 0, 0, 0.0, False
        self._marks: list[Mark] = []
        self._known: set[str] = set()
        """Alerts and news that were marked, or existed before the start."""
        self._unwritten: deque[Lines] = deque()
        self.keeper = SpellKeeper(projection.speed)

    def note(self, told: Delta) -> None:
        """Record a delta of the whole plant."""
        if told.factory is not None:
            self._factory = told.factory
        self._mark(told)
        self.keeper.follow(told)
        self._changes += len(told.tasks) + len(told.news)
        if self._bytes > PIECE_BYTES:
            self._close_piece(told.at_s)
        if self._owed is None:
            self._owed = self._begin(told.at_s)
        else:
            self._updates.note(told)
        self._learn(self._owed, told.at_s)
        frame = self._updates.frame(0, told.at_s)
        if any(self._owed.values()):
            return
        if self._whole_at_s is None or not 0 <= told.at_s - self._whole_at_s < WHOLE_EVERY_S:
            self._close_piece(told.at_s)
            self._whole_at_s, self._is_whole, self._from_at_s = told.at_s, True, told.at_s
            self._lines.append(self._whole(told.at_s))
            return
        line: dict[str, Any] = {name: part for name, part in frame.items() if part}
        self._keep(line, told.at_s)

    def lines(self) -> list[Lines]:
        """Unwritten lines up to now, oldest first."""
        return [*self._unwritten, *self._open_piece(self._wall_s())]

    async def unwritten(self) -> list[Piece]:
        """Unwritten lines as pieces."""
        lines = self.lines()
        return await asyncio.to_thread(lambda: [each.piece for each in lines])

    def now(self) -> Whole | None:
        """The present snapshot; None until everything was taken in."""
        return None if self._whole_at_s is None else self._whole(self._wall_s())

    def spells(self) -> list[Spell]:
        """Present spells, and ended ones that are not written yet."""
        return self.keeper.under_way(self._wall_s())

    async def run(self) -> None:
        """Write every `WRITE_EVERY_S` until cancelled."""
        while True:
            await asyncio.sleep(WRITE_EVERY_S)
            await self.write()

    async def close(self) -> None:
        """Write everything left, at the end."""
        self.keeper.end_all(self._wall_s())
        await self.write()

    def cut(self) -> None:
        """End the current piece."""
        self._close_piece(self._wall_s())

    async def write(self) -> None:
        """Write what was recorded since the last write."""
        self.cut()
        lines, spells = list(self._unwritten), self.keeper.take_ended()
        if not lines:
            return
        pieces = await asyncio.to_thread(lambda: [each.piece for each in lines])
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
            self._whole_at_s = None  # The next piece must not build on a skipped one.

    def _begin(self, at_s: float) -> dict[str, deque[str]]:
        """Take in the first portion of the present state; returns the rest to take in."""
        snapshot = self._scope.snapshot(0, at_s, PORTION)
        self._factory = self._factory or snapshot.factory
        self._updates.begin(snapshot)
        self._known = {f"alert:{each.id}" for each in snapshot.alerts}
        self._known |= {f"news:{each.id}" for each in snapshot.news}
        self.keeper.follow(snapshot)
        return {name: deque(names) for name, names in self._scope.rest(PORTION).items()}

    def _learn(self, owed: dict[str, deque[str]], at_s: float) -> None:
        """Take in a portion of the rest."""
        for collection, names in owed.items():
            these = [names.popleft() for _ in range(min(PORTION, len(names)))]
            if these:
                views = self._scope.views(collection, these)
                self._updates.tell(collection, views)
                self.keeper.follow(Delta(number=0, at_s=at_s, tasks=views if collection == "tasks" else ()))

    def _whole(self, at_s: float) -> Whole:
        """A snapshot of everything taken in."""
        head = {
            "type": "snapshot",
            "number": 0,
            "at_s": at_s,
            "plant": self._projection.plant,
            "factory": self._factory,
            "fault_injection": self._projection.faults.possible,
        }
        known = self._updates.known()
        if known["commands"]:
            head["areas"] = self._areas_of(known["commands"])
        return Whole(head, known)

    def _areas_of(self, commands: Sequence[dict[str, Any]]) -> dict[str, list[str]]:
        areas_of = self._projection.commands.areas_of
        return {each["id"]: sorted(areas_of(each["id"])) for each in commands}

    def _keep(self, line: dict[str, Any], at_s: float) -> None:
        commands = line.get("commands", ())
        if commands:
            line["areas"] = self._areas_of(commands)
        if not self._lines:
            self._from_at_s = at_s
        encoded = _encode(line)
        self._lines.append(encoded)
        self._bytes += len(encoded)

    def _open_piece(self, until_s: float) -> list[Lines]:
        if not self._lines:
            return []
        piece = Piece(
            recorder=self._name,
            from_at_s=self._from_at_s,
            until_at_s=max(until_s, self._from_at_s),
            is_whole=self._is_whole,
            changes=self._changes,
            marks=_encode(self._marks).decode() if self._marks else "",
            frames=b"",
        )
        return [Lines(piece, tuple(self._lines))]

    def _close_piece(self, until_s: float) -> None:
        self._unwritten.extend(self._open_piece(until_s))
        self._lines.clear()
        self._marks.clear()
        self._bytes, self._changes, self._is_whole = 0, 0, False

    def _mark(self, told: Delta) -> None:
        if self._owed is None:
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

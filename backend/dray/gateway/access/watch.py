"""The watch over open streams: a stream ends when its session or key ends, or its areas change."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from enum import Enum

from dray.errors import UnavailableError
from dray.gateway.access import keys, sessions
from dray.gateway.access.principal import ADMIN, Principal
from dray.gateway.access.sessions import USED_AGAIN_S, Standing, standing
from dray.store import Store
from dray.store.work import Work

CHECK_S = 5.0
"""Wall seconds until a stream ends whose session expired or was ended by another process."""

_log = logging.getLogger(__name__)


class End(Enum):
    """Why a stream must end."""

    OVER = "the session has ended"
    MOVED = "you have another station or other areas now"
    """The session goes on: a new stream shows what may be seen now."""


class Watch:
    """Knows the open streams, and ends those of callers who have lost their rights.

    Args:
        store: the database with sessions and keys.
        wall_s: the wall clock.
    """

    def __init__(self, store: Store, wall_s: Callable[[], float]) -> None:
        self._store, self._wall_s = store, wall_s
        self._open: dict[asyncio.Future[End], Principal] = {}

    @contextmanager
    def over(self, principal: Principal) -> Iterator[asyncio.Future[End]]:
        """Watch a caller's stream; the future tells when it must end, and why."""
        ended: asyncio.Future[End] = asyncio.get_running_loop().create_future()
        self._open[ended] = principal
        try:
            yield ended
        finally:
            del self._open[ended]

    async def check(self) -> None:
        """Check all watched callers' rights; a stream that goes on counts as use of its session."""
        watched = dict(self._open)
        if not watched:
            return
        now_s = self._wall_s()
        async with self._store.read() as work:
            live = await _live(work, watched.values(), now_s)
        idle = [
            session_id for session_id, used_at_s in live.used.items() if now_s - used_at_s >= USED_AGAIN_S
        ]
        if idle:
            async with self._store.write() as work:
                await work.sessions.use(idle, now_s)
        for ended, principal in watched.items():
            if principal not in live.principals and not ended.done():
                ended.set_result(End.MOVED if principal.session in live.used else End.OVER)

    async def soon(self) -> None:
        """Check now, or in the next turn if the database is away."""
        with suppress(UnavailableError):
            await self.check()

    async def run(self) -> None:
        """Check every `CHECK_S` until cancelled."""
        while True:
            await asyncio.sleep(CHECK_S)
            try:
                await self.check()
            except UnavailableError:
                # What people see meanwhile, they had a right to see a moment ago.
                _log.warning("the sessions of open streams could not be checked", exc_info=True)


@dataclass(frozen=True, slots=True)
class _Live:
    """Callers whose rights last.

    Attributes:
        principals: their present principals; a caller with changed areas is another one.
        used: per session, the time of its last use.
    """

    principals: set[Principal]
    used: dict[str, float]


async def _live(work: Work, watched: Iterable[Principal], now_s: float) -> _Live:
    live = _Live({ADMIN}, {})
    for session in await work.sessions.some({each.session for each in watched if each.session}):
        person = await work.people.get(session.person_id)
        if person is not None and standing(session, person, now_s) is Standing.LIVE:
            live.principals.add(sessions.principal_of(person, session))
            live.used[session.id] = session.used_at_s
    for key_id in {each.id for each in watched if each.kind == "key"}:
        key = await work.api_keys.get(key_id)
        if key is not None and keys.usable(key, now_s):
            live.principals.add(keys.principal_of(key))
    return live

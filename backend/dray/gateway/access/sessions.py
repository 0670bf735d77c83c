"""Sessions: from a login to its end, and what a browser's cookie is worth meanwhile.

A session ends when it is logged out or taken back, when nothing has used it for `IDLE_S`, and at the latest
when its person's working day is over. An open stream uses it: a panel that is watched is not idle.

Stop is never behind a login prompt. An operator's session that has only run out of time, or was replaced by
a login of the same person elsewhere, may for `MAY_STILL_STOP_S` more stop vehicles in its areas, and nothing else; and
so may everybody whom we knew before, while the database is away.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from enum import Enum

import msgspec

from dray.errors import UnavailableError
from dray.gateway.access.principal import SCOPES, STOP_ONLY, Over, Principal, Role
from dray.gateway.access.tokens import new_id, new_token
from dray.store import Store
from dray.store.access.digest import digest
from dray.store.access.people import Person
from dray.store.access.sessions import Session

HOUR_S = 3600.0

LIFE_S = {Role.MANAGER: 12 * HOUR_S, Role.OPERATOR: 10 * HOUR_S}
"""A long working day, and a shift with the hour in which it is handed over."""

IDLE_S = 2 * HOUR_S
"""A break with a meeting behind it; a browser that was closed and forgotten for longer is logged out."""

MAY_STILL_STOP_S = 12 * HOUR_S
"""Until the operator of the next shift has long logged in."""

USED_AGAIN_S = 60.0
"""The use of a session is noted this often: a write to disk for each request would cost more than it tells."""

KEPT_S = 30 * 24 * HOUR_S
"""Sessions stay readable this long after their end, for whoever looks into the audit log."""

REMEMBERED = 1_000
"""Sessions that are known without the database, some 1 MB: all people of a large plant."""


class Standing(Enum):
    """What a session is worth."""

    LIVE = "live"
    OVER = "over"
    """It has only run out of time."""
    REPLACED = "replaced"
    """Its person has logged in elsewhere: nobody has taken it back."""
    ENDED = "ended"


OVER = {Standing.OVER: Over.RUN_OUT, Standing.REPLACED: Over.REPLACED}
"""What is good for a stop still, and what its person is told."""


def standing(session: Session, person: Person, now_s: float, *, replaced: bool = False) -> Standing:
    """What a session is worth now.

    Args:
        session: the session.
        person: whose it is.
        now_s: the wall clock.
        replaced: whether it ended because its person has logged in elsewhere.
    """
    if person.disabled_at_s is not None:
        return Standing.ENDED
    if session.ended_at_s is not None:
        return Standing.REPLACED if replaced else Standing.ENDED
    return Standing.LIVE if now_s < ends_at_s(session) else Standing.OVER


def ends_at_s(session: Session) -> float:
    """When a session has ended, or will have run out of time if nobody uses it again."""
    runs_out_at_s = min(session.expires_at_s, session.used_at_s + IDLE_S)
    return runs_out_at_s if session.ended_at_s is None else min(session.ended_at_s, runs_out_at_s)


@dataclass(frozen=True, slots=True)
class Known:
    """A session as the database last told.

    Attributes:
        person: whose it is.
        session: the session.
        replaced: whether it ended because its person has logged in elsewhere.
    """

    person: Person
    session: Session
    replaced: bool

    def principal(self, now_s: float) -> Principal | None:
        """Who has it, as far as it is still worth something."""
        worth = standing(self.session, self.person, now_s, replaced=self.replaced)
        if worth is Standing.LIVE:
            return principal_of(self.person, self.session)
        over = OVER.get(worth)
        if over is None or not may_still_stop(self.person, self.session, now_s):
            return None
        return principal_of(self.person, self.session, over=over)


class Sessions:
    """Begins sessions, recognises people by them, and ends them.

    Args:
        store: where they are kept.
        wall_s: the wall clock.
    """

    def __init__(self, store: Store, wall_s: Callable[[], float]) -> None:
        self._store, self._wall_s = store, wall_s
        self._remembered: OrderedDict[str, Known] = OrderedDict()
        """By the token's digest, as the database last told. Changed on the loop, and looked at by any thread."""
        self._changes = 0
        """How many sessions were begun or ended here."""

    async def begin(self, person: Person, *, before: str = "", station: str = "") -> tuple[str, Session]:
        """Log somebody in; returns the cookie's token, which is always a new one.

        An operator works at one station at a time: all other sessions of an operator are replaced by this one.

        Args:
            person: who.
            before: the cookie that the browser has brought; its session ends.
            station: the machine at which an operator works.
        """
        now_s, token = self._wall_s(), new_token()
        session = Session(
            id=new_id(),
            person_id=person.id,
            station=station,
            created_at_s=now_s,
            used_at_s=now_s,
            expires_at_s=now_s + LIFE_S[Role(person.role)],
        )
        async with self._store.write() as work:
            await work.sessions.forget_before(now_s - KEPT_S)
            if person.role == Role.OPERATOR:
                await work.sessions.end_all(person.id, now_s)
            if before and (old := await work.sessions.find(before)):
                await work.sessions.end(old.id, now_s)
            await work.sessions.add(token, session)
        self._changes += 1
        self._remembered.pop(digest(before), None)
        if person.role == Role.OPERATOR:
            self._note_replaced(person, now_s)
        self._remember(token, Known(person, session, replaced=False))
        return token, session

    async def recognise(self, token: str) -> Principal | None:
        """Whose cookie this is; None when it is nobody's any more."""
        now_s = self._wall_s()
        async with self._store.read() as work:
            session = await work.sessions.find(token)
            person = None if session is None else await work.people.get(session.person_id)
            replaced = session is not None and await work.sessions.was_replaced(session)
        if session is None or person is None:
            return None
        known = Known(person, session, replaced)
        self._remember(token, known)
        principal = known.principal(now_s)
        if principal is not None and not principal.over and now_s - session.used_at_s >= USED_AGAIN_S:
            # A database that can only be read still tells who somebody is.
            with suppress(UnavailableError):
                async with self._store.write() as work:
                    await work.sessions.use([session.id], now_s)
        return principal

    async def learn(self) -> None:
        """Ask the database for all sessions that are worth something, also those that were never shown here.

        Raises:
            UnavailableError: the database is away; what was known stays known.
        """
        changes = self._changes
        async with self._store.read() as work:
            people = {person.id: person for person in await work.people.all()}
            latest = await work.sessions.latest(self._wall_s() - MAY_STILL_STOP_S, REMEMBERED)
        if changes != self._changes:
            return  # Somebody has come or gone since: the next look tells it all.
        logins = {(each.person_id, each.created_at_s) for _, each in latest}
        self._remembered = OrderedDict(
            (key, Known(people[each.person_id], each, (each.person_id, each.ended_at_s) in logins))
            for key, each in reversed(latest)
            if each.person_id in people
        )

    def remembered(self, token: str, now_s: float) -> Principal | None:
        """Whose cookie this was when the database was last asked: may only stop. On any thread."""
        known = self._remembered.get(digest(token))
        principal = None if known is None else known.principal(now_s)
        return None if principal is None else replace(principal, scopes=STOP_ONLY)

    def _remember(self, token: str, known: Known) -> None:
        self._remembered[digest(token)] = known
        self._remembered.move_to_end(digest(token))
        if len(self._remembered) > REMEMBERED:
            self._remembered.popitem(last=False)

    def _note_replaced(self, person: Person, now_s: float) -> None:
        """Somebody has logged in elsewhere: while the database is away, nobody could tell."""
        for key, known in self._remembered.items():
            if known.person.id == person.id and known.session.ended_at_s is None:
                ended = msgspec.structs.replace(known.session, ended_at_s=now_s)
                self._remembered[key] = replace(known, session=ended, replaced=True)

    async def place(self, session_id: str, station: str) -> None:
        """Note at which machine an operator works."""
        async with self._store.write() as work:
            await work.sessions.station(session_id, station)

    async def end(self, token: str) -> tuple[Person, Session] | None:
        """Log out; returns whose session ended by this, None when none did."""
        self._forget(token)
        async with self._store.write() as work:
            session = await work.sessions.find(token)
            if session is None or not await work.sessions.end(session.id, self._wall_s()):
                return None
            person = await work.people.get(session.person_id)
        self._forget(token)  # Somebody may have been recognised by it while it ended.
        return None if person is None else (person, session)

    def _forget(self, token: str) -> None:
        self._changes += 1
        self._remembered.pop(digest(token), None)


def may_still_stop(person: Person, session: Session, now_s: float) -> bool:
    """Whether somebody whose session is over may still stop vehicles."""
    return person.role == Role.OPERATOR and now_s < ends_at_s(session) + MAY_STILL_STOP_S


def principal_of(person: Person, session: Session, *, over: Over | None = None) -> Principal:
    """Who has this session.

    Args:
        person: whose it is.
        session: the session.
        over: why it is over, where it is.
    """
    role = Role(person.role)
    return Principal(
        kind="person",
        id=person.id,
        name=person.name,
        role=role,
        scopes=STOP_ONLY if over else SCOPES[role],
        areas=frozenset(person.areas) if role is Role.OPERATOR else None,
        station=session.station,
        session=session.id,
        expires_at_s=session.expires_at_s,
        over=over,
    )

"""Sessions: from a login to its end, and the rights of a browser's cookie meanwhile.

A session ends on logout or revocation, after `IDLE_S` without use, and at the latest at the end of the
person's working day. An open stream counts as use: a panel being watched is not idle.

Stop is never behind a login prompt. An operator's session that has expired, or was replaced by a login
elsewhere, remains valid for stops. It may stop vehicles in its areas for another `MAY_STILL_STOP_S`, and
nothing else. While the database is away, so may every caller known before.
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
"""Longest session in seconds: a long working day, or a shift with its hour of hand-over."""

IDLE_S = 2 * HOUR_S
"""Maximum idle time: a break with a meeting; a browser closed and forgotten for longer is logged out."""

MAY_STILL_STOP_S = 12 * HOUR_S
"""Seconds after the end in which stops are allowed: the next shift's operator has long logged in."""

USED_AGAIN_S = 60.0
"""Minimum wall seconds between two records of use: a write per request would cost too much."""

KEPT_S = 30 * 24 * HOUR_S
"""Seconds for which ended sessions are kept, for readers of the audit log."""

REMEMBERED = 1_000
"""Maximum sessions known without the database, some 1 MB: all people of a large plant."""


class Standing(Enum):
    """The validity of a session."""

    LIVE = "live"
    OVER = "over"
    """It has expired."""
    REPLACED = "replaced"
    """Its person has logged in elsewhere; nobody has revoked it."""
    ENDED = "ended"


OVER = {Standing.OVER: Over.RUN_OUT, Standing.REPLACED: Over.REPLACED}
"""Sessions still valid for a stop, and the reason given to the person."""


def standing(session: Session, person: Person, now_s: float, *, replaced: bool = False) -> Standing:
    """The present validity of a session.

    Args:
        session: the session.
        person: its person.
        now_s: the wall clock.
        replaced: whether its person has logged in elsewhere.
    """
    if person.disabled_at_s is not None:
        return Standing.ENDED
    if session.ended_at_s is not None:
        return Standing.REPLACED if replaced else Standing.ENDED
    return Standing.LIVE if now_s < ends_at_s(session) else Standing.OVER


def ends_at_s(session: Session) -> float:
    """When a session ended, or will expire without further use."""
    runs_out_at_s = min(session.expires_at_s, session.used_at_s + IDLE_S)
    return runs_out_at_s if session.ended_at_s is None else min(session.ended_at_s, runs_out_at_s)


@dataclass(frozen=True, slots=True)
class Known:
    """A session at the last look at the database.

    Attributes:
        person: its person.
        session: the session.
        replaced: whether its person has logged in elsewhere.
    """

    person: Person
    session: Session
    replaced: bool

    def principal(self, now_s: float) -> Principal | None:
        """Its principal, as far as it is still valid."""
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
        store: the database with the sessions.
        wall_s: the wall clock.
    """

    def __init__(self, store: Store, wall_s: Callable[[], float]) -> None:
        self._store, self._wall_s = store, wall_s
        self._remembered: OrderedDict[str, Known] = OrderedDict()
        """By digest of the token, at the last look at the database. Changed on the loop, read by any
        thread."""
        self._changes = 0
        """Number of sessions begun or ended here."""

    async def begin(self, person: Person, *, before: str = "", station: str = "") -> tuple[str, Session]:
        """Log a person in; returns the cookie's token, always a new one.

        An operator works at one station at a time: this session replaces all others of the operator.

        Args:
            person: the person.
            before: the browser's previous cookie; its session ends.
            station: an operator's machine.
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
        """The owner of a cookie; None if it is not valid any more."""
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
            # A read-only database still recognises people.
            with suppress(UnavailableError):
                async with self._store.write() as work:
                    await work.sessions.use([session.id], now_s)
        return principal

    async def learn(self) -> None:
        """Read all sessions of any validity, including those never used here.

        Raises:
            UnavailableError: the database is away; the earlier state remains.
        """
        changes = self._changes
        async with self._store.read() as work:
            people = {person.id: person for person in await work.people.all()}
            latest = await work.sessions.latest(self._wall_s() - MAY_STILL_STOP_S, REMEMBERED)
        if changes != self._changes:
            return  # A session began or ended since: the next look reads it.
        logins = {(each.person_id, each.created_at_s) for _, each in latest}
        self._remembered = OrderedDict(
            (key, Known(people[each.person_id], each, (each.person_id, each.ended_at_s) in logins))
            for key, each in reversed(latest)
            if each.person_id in people
        )

    def remembered(self, token: str, now_s: float) -> Principal | None:
        """The owner of a cookie at the last look at the database, for stops only. Thread-safe."""
        known = self._remembered.get(digest(token))
        principal = None if known is None else known.principal(now_s)
        return None if principal is None else replace(principal, scopes=STOP_ONLY)

    def _remember(self, token: str, known: Known) -> None:
        self._remembered[digest(token)] = known
        self._remembered.move_to_end(digest(token))
        if len(self._remembered) > REMEMBERED:
            self._remembered.popitem(last=False)

    def _note_replaced(self, person: Person, now_s: float) -> None:
        """Mark a person's other sessions as replaced, since the database may be away later."""
        for key, known in self._remembered.items():
            if known.person.id == person.id and known.session.ended_at_s is None:
                ended = msgspec.structs.replace(known.session, ended_at_s=now_s)
                self._remembered[key] = replace(known, session=ended, replaced=True)

    async def place(self, session_id: str, station: str) -> None:
        """Note an operator's machine."""
        async with self._store.write() as work:
            await work.sessions.station(session_id, station)

    async def end(self, token: str) -> tuple[Person, Session] | None:
        """Log out; returns the session ended by this, None if there was none."""
        self._forget(token)
        async with self._store.write() as work:
            session = await work.sessions.find(token)
            if session is None or not await work.sessions.end(session.id, self._wall_s()):
                return None
            person = await work.people.get(session.person_id)
        self._forget(token)  # It may have been recognised again while it ended.
        return None if person is None else (person, session)

    def _forget(self, token: str) -> None:
        self._changes += 1
        self._remembered.pop(digest(token), None)


def may_still_stop(person: Person, session: Session, now_s: float) -> bool:
    """Whether a person whose session is over may still stop vehicles."""
    return person.role == Role.OPERATOR and now_s < ends_at_s(session) + MAY_STILL_STOP_S


def principal_of(person: Person, session: Session, *, over: Over | None = None) -> Principal:
    """The principal of a session.

    Args:
        person: its person.
        session: the session.
        over: why it is over, if so.
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

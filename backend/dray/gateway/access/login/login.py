"""Login: from what somebody shows to the person who it is.

Whoever guesses is slowed down twice: by address, and by the name that was tried. A name that nobody has is
treated as one that somebody has: it takes as long, is answered the same, and is locked out the same.
"""

from __future__ import annotations

from collections.abc import Callable
from http import HTTPStatus

from dray.gateway.access.limits import Limit, neighbourhood, too_many
from dray.gateway.access.login.hasher import Hasher
from dray.gateway.access.principal import Role
from dray.gateway.http.problems import CHALLENGE, Problem
from dray.store import Store
from dray.store.access.lockouts import Lockout
from dray.store.access.login_links import LoginLink
from dray.store.access.people import Person
from dray.store.work import Work

TRIES = 20
"""From one address at once: a shift that logs in through one proxy, every second one with a slip."""

TRIES_HZ = 1 / 3
"""Some 30,000 guesses a day, over all names."""

FREE_FAILURES = 5
"""In a row, under one name, before it is locked out."""

FIRST_LOCKOUT_S = 30.0
"""Doubles with every failure after that..."""

LONGEST_LOCKOUT_S = 3600.0
"""...up to 24 guesses a day: for a PIN of six digits, a hundred years."""

FORGIVEN_S = 86_400.0
"""Failures are forgotten after a day without another one."""

NAME_CHARS = 128
SECRET_CHARS = 256
"""Longer than anybody's password; hashing more would only cost."""

BADGE_SALT = "badges"
"""The secret of the database with which badge codes are hashed."""


class WrongLogin(Problem):
    """Nobody is let in by what was shown; says nothing of what was wrong with it.

    Attributes:
        claimed: whose name was given, for the audit log only; empty where nobody has it.
    """

    def __init__(self, claimed: str = "") -> None:
        self.claimed = claimed
        super().__init__(
            HTTPStatus.UNAUTHORIZED,
            "wrong-login",
            "Not logged in",
            "this name with this secret, or this badge, opens nothing; try again",
            headers=CHALLENGE,
        )


class LinkUsedUp(Problem):
    """A login link that logs nobody in, or not any more."""

    def __init__(self) -> None:
        super().__init__(
            HTTPStatus.GONE,
            "login-link-used-up",
            "This link logs nobody in any more",
            "it was used already, or is too old; ask a manager for a new one",
        )


class Login:
    """Tells who somebody is.

    Args:
        store: where people are kept.
        hasher: for their secrets.
        wall_s: the wall clock.
    """

    def __init__(self, store: Store, hasher: Hasher, wall_s: Callable[[], float]) -> None:
        self._store, self._hasher, self._wall_s = store, hasher, wall_s
        self._tries = Limit(wall_s, tries=TRIES, rate_hz=TRIES_HZ)

    async def by_name(self, name: str, secret: str, address: str) -> Person:
        """Who has this id and this password or PIN.

        Args:
            name: as it was typed.
            secret: a manager's password or an operator's PIN.
            address: where it was tried.

        Raises:
            Problem: 401, nobody; 429, too many have failed under this name or from this address; 503, too
                many log in at once, which counts as no try.
        """
        with self._hasher.place() as place:
            self._tries.take(neighbourhood(address))
            name = as_typed(name)
            # The failure is noted before it is known to be one: many tries at once count as many.
            async with self._store.write() as work:
                await self._note_failure(work, name)
                person = await work.people.get(name)
            kept = None if person is None else secret_of(person)
            right = await place.matches(kept, secret[:SECRET_CHARS])
        if person is None or not right or person.disabled_at_s is not None:
            raise WrongLogin("" if person is None else person.id)
        async with self._store.write() as work:
            await work.lockouts.clear(name)
        self._tries.give_back(neighbourhood(address))
        return person

    async def by_badge(self, code: str, address: str) -> Person:
        """Whose badge this is.

        Raises:
            Problem: 401, nobody's; 429, too many have failed from this address; 503, too many log in at
                once, which counts as no try.
        """
        with self._hasher.place() as place:
            self._tries.take(neighbourhood(address))
            async with self._store.write() as work:
                salt = await work.secrets.get(BADGE_SALT)
            kept = await place.badge_hash(code.strip()[:SECRET_CHARS], salt)
        async with self._store.read() as work:
            person = await work.people.with_badge(kept)
        if person is None or person.disabled_at_s is not None:
            raise WrongLogin
        self._tries.give_back(neighbourhood(address))
        return person

    async def whose_link(self, token: str) -> Person:
        """Whom a link would log in; uses nothing up.

        Raises:
            Problem: 410, nobody.
        """
        async with self._store.read() as work:
            link = await work.login_links.find(token)
            if link is None or not _leads_in(link, self._wall_s()):
                raise LinkUsedUp
            return await self._linked(work, link)

    async def by_link(self, token: str, address: str) -> Person:
        """Whom a link logs in; it is used up by this.

        Raises:
            Problem: 410, nobody; 429, too many have failed from this address.
        """
        self._tries.take(neighbourhood(address))
        async with self._store.write() as work:
            link = await work.login_links.find(token)
            if link is None or not await work.login_links.use(token, self._wall_s()):
                raise LinkUsedUp
            person = await self._linked(work, link)
        self._tries.give_back(neighbourhood(address))
        return person

    async def _linked(self, work: Work, link: LoginLink) -> Person:
        person = await work.people.get(link.person_id)
        if person is None or person.disabled_at_s is not None:
            raise LinkUsedUp
        return person

    async def _note_failure(self, work: Work, name: str) -> None:
        now_s = self._wall_s()
        await work.lockouts.forget_before(now_s - FORGIVEN_S)
        known = await work.lockouts.get(name)
        if known is not None and now_s < known.until_s:
            raise too_many(known.until_s - now_s)
        failures = 1 if known is None else known.failures + 1
        await work.lockouts.put(name, Lockout(failures, now_s, now_s + lockout_s(failures)))


def lockout_s(failures: int) -> float:
    """How long nothing is tried under a name after so many failures in a row."""
    if failures < FREE_FAILURES:
        return 0.0
    # No power of two that no float can hold.
    return min(FIRST_LOCKOUT_S * 2.0 ** min(failures - FREE_FAILURES, 32), LONGEST_LOCKOUT_S)


def as_typed(name: str) -> str:
    """The id that is meant by what somebody has typed."""
    return name.strip().casefold()[:NAME_CHARS]


def secret_of(person: Person) -> str | None:
    """The hash of what this person types: a manager a password, an operator a PIN."""
    return person.password_hash if person.role == Role.MANAGER else person.pin_hash


def _leads_in(link: LoginLink, now_s: float) -> bool:
    return link.ended_at_s is None and now_s < link.expires_at_s

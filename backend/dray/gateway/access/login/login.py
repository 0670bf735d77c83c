"""Login: finds the person for a secret.

Guessing is slowed down by address and by the name tried. An unknown name is treated like a known one: same
delay, same answer, same lock-out.
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
"""Burst per address: a shift that logs in through one proxy, every second person with a typing error."""

TRIES_HZ = 1 / 3
"""Sustained tries per second: some 30,000 guesses a day, over all names."""

FREE_FAILURES = 5
"""Failures in a row under one name before it is locked out."""

FIRST_LOCKOUT_S = 30.0
"""First lock-out; it doubles with every further failure."""

LONGEST_LOCKOUT_S = 3600.0
"""Longest lock-out: up to 24 guesses a day, for a PIN of six digits a hundred years."""

FORGIVEN_S = 86_400.0
"""Seconds without a failure after which failures are forgotten: a day."""

NAME_CHARS = 128
SECRET_CHARS = 256
"""Maximum characters: longer than any password; hashing more would only cost time."""

BADGE_SALT = "badges"
"""Name of the database's secret with which badge codes are hashed."""


class WrongLogin(Problem):
    """A failed login; does not say what was wrong.

    Attributes:
        claimed: the id tried, for the audit log only; empty if nobody has it.
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
    """A login link that is invalid or used up."""

    def __init__(self) -> None:
        super().__init__(
            HTTPStatus.GONE,
            "login-link-used-up",
            "This link logs nobody in any more",
            "it was used already, or is too old; ask a manager for a new one",
        )


class Login:
    """Recognises people by what they know or have.

    Args:
        store: the database with the people.
        hasher: for their secrets.
        wall_s: the wall clock.
    """

    def __init__(self, store: Store, hasher: Hasher, wall_s: Callable[[], float]) -> None:
        self._store, self._hasher, self._wall_s = store, hasher, wall_s
        self._tries = Limit(wall_s, tries=TRIES, rate_hz=TRIES_HZ)

    async def by_name(self, name: str, secret: str, address: str) -> Person:
        """The person with this id and this password or PIN.

        Args:
            name: the name as typed.
            secret: a manager's password or an operator's PIN.
            address: the client's address.

        Raises:
            Problem: 401, wrong login; 429, too many failures under this name or from this address; 503, too
                many log in at once, which counts as no try.
        """
        with self._hasher.place() as place:
            self._tries.take(neighbourhood(address))
            name = as_typed(name)
            # Noted as a failure first, so that concurrent tries all count.
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
        """The person with this badge.

        Raises:
            Problem: 401, unknown badge; 429, too many failures from this address; 503, too many log in at
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
        """The person whom a link would log in; does not use it up.

        Raises:
            Problem: 410, the link is invalid.
        """
        async with self._store.read() as work:
            link = await work.login_links.find(token)
            if link is None or not _leads_in(link, self._wall_s()):
                raise LinkUsedUp
            return await self._linked(work, link)

    async def by_link(self, token: str, address: str) -> Person:
        """The person whom a link logs in; uses it up.

        Raises:
            Problem: 410, the link is invalid; 429, too many failures from this address.
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
    """Seconds of lock-out after so many failures in a row."""
    if failures < FREE_FAILURES:
        return 0.0
    # Cap the exponent to avoid float overflow.
    return min(FIRST_LOCKOUT_S * 2.0 ** min(failures - FREE_FAILURES, 32), LONGEST_LOCKOUT_S)


def as_typed(name: str) -> str:
    """The id for a name as typed."""
    return name.strip().casefold()[:NAME_CHARS]


def secret_of(person: Person) -> str | None:
    """The hash of a person's secret: a manager's password or an operator's PIN."""
    return person.password_hash if person.role == Role.MANAGER else person.pin_hash


def _leads_in(link: LoginLink, now_s: float) -> bool:
    return link.ended_at_s is None and now_s < link.expires_at_s

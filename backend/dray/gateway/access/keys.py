"""Keys: how other systems are recognised."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

from dray.errors import UnavailableError
from dray.gateway.access.limits import Limit
from dray.gateway.access.principal import STOP_ONLY, Principal, Scope
from dray.store import Store
from dray.store.apikeys import ApiKey
from dray.store.digest import digest

USED_AGAIN_S = 60.0
"""The use of a key is noted this often."""

REMEMBERED = 1_000
"""Keys that are known without the database: some per machine of a large plant."""


class Keys:
    """Recognises other systems by their keys.

    Args:
        store: where the keys are kept.
        wall_s: the wall clock.
        rate_hz: requests per second that one key may make for long.
        tries: requests that one key may make at once.
    """

    def __init__(self, store: Store, wall_s: Callable[[], float], *, rate_hz: float, tries: int) -> None:
        self._store, self._wall_s = store, wall_s
        self._limit = Limit(wall_s, tries=tries, rate_hz=rate_hz)
        self._remembered: dict[str, ApiKey] = {}
        """By the token's digest, as the database last told. Replaced on the loop, and looked at by any thread."""

    async def recognise(self, token: str) -> Principal | None:
        """Whose key this is; None when it is nobody's, or not any more.

        Raises:
            Problem: 429, it is used too often.
        """
        now_s = self._wall_s()
        async with self._store.read() as work:
            key = await work.api_keys.find(token)
        if key is None or not usable(key, now_s):
            return None
        self._limit.take(key.id)
        if key.used_at_s is None or now_s - key.used_at_s >= USED_AGAIN_S:
            # A database that can only be read still tells whose key it is.
            with suppress(UnavailableError):
                async with self._store.write() as work:
                    await work.api_keys.use(key.id, now_s)
        return principal_of(key)

    async def learn(self) -> None:
        """Ask the database for all keys that may stop vehicles.

        Raises:
            UnavailableError: the database is away; what was known stays known.
        """
        async with self._store.read() as work:
            standing = await work.api_keys.standing(REMEMBERED)
        self._remembered = {
            token: key for token, key in standing if principal_of(key).may(Scope.VEHICLES_STOP)
        }

    def remembered(self, token: str, now_s: float) -> Principal | None:
        """Whose key this was when the database was last asked: may only stop. On any thread."""
        key = self._remembered.get(digest(token))
        if key is None or not usable(key, now_s):
            return None
        return replace(principal_of(key), scopes=STOP_ONLY)


def usable(key: ApiKey, now_s: float) -> bool:
    """Whether a key has neither been taken back nor run out of time."""
    return key.revoked_at_s is None and (key.expires_at_s is None or now_s < key.expires_at_s)


def principal_of(key: ApiKey) -> Principal:
    """Who has this key; scopes of another Dray mean nothing."""
    known = {scope.value: scope for scope in Scope}
    return Principal(
        kind="key",
        id=key.id,
        name=key.name,
        scopes=frozenset(known[name] for name in key.scopes.split() if name in known),
        expires_at_s=key.expires_at_s,
    )

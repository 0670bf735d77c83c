"""Keys: the recognition of other systems."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

import msgspec

from dray.errors import UnavailableError
from dray.gateway.access.limits import Limit
from dray.gateway.access.principal import STOP_ONLY, CallLimits, Principal, Scope
from dray.priorities import Priority
from dray.store import Store
from dray.store.access.api_keys import ApiKey
from dray.store.access.digest import digest

USED_AGAIN_S = 60.0
"""Minimum wall seconds between two records of a key's use."""

KNOWN_S = 1.0
"""Wall seconds for which a key's data is cached: the longest life of a revoked key, while a series of orders
needs no look-ups."""

REMEMBERED = 1_000
"""Maximum keys known without the database: some per machine of a large plant."""


class Keys:
    """Recognises other systems by their keys.

    Args:
        store: the database with the keys.
        wall_s: the wall clock.
        rate_hz: sustained requests per second of one key.
        tries: burst of requests of one key.
    """

    def __init__(self, store: Store, wall_s: Callable[[], float], *, rate_hz: float, tries: int) -> None:
        self._store, self._wall_s = store, wall_s
        self._limit = Limit(wall_s, tries=tries, rate_hz=rate_hz)
        self._remembered: dict[str, ApiKey] = {}
        """By digest of the token, at the last look at the database. Replaced on the loop, read by any
        thread."""
        self._known: OrderedDict[str, tuple[float, ApiKey]] = OrderedDict()
        """Recently used keys by digest of the token, with the time of their look-up."""

    async def recognise(self, token: str) -> Principal | None:
        """The owner of a key; None if unknown or no longer valid.

        Raises:
            Problem: 429, the key is used too often.
        """
        now_s = self._wall_s()
        key = await self._find(token, now_s)
        if key is None or not usable(key, now_s):
            return None
        self._limit.take(key.id)
        if key.used_at_s is None or now_s - key.used_at_s >= USED_AGAIN_S:
            # A read-only database still recognises keys.
            with suppress(UnavailableError):
                async with self._store.write() as work:
                    await work.api_keys.use(key.id, now_s)
                self._note(token, now_s, msgspec.structs.replace(key, used_at_s=now_s))
        return principal_of(key)

    async def _find(self, token: str, now_s: float) -> ApiKey | None:
        """The key of this token, at most `KNOWN_S` old."""
        asked_at_s, key = self._known.get(digest(token), (0.0, None))
        if key is not None and 0 <= now_s - asked_at_s < KNOWN_S:
            return key
        async with self._store.read() as work:
            key = await work.api_keys.find(token)
        if key is not None:
            self._note(token, now_s, key)
        return key

    def _note(self, token: str, asked_at_s: float, key: ApiKey) -> None:
        self._known[digest(token)] = asked_at_s, key
        self._known.move_to_end(digest(token))
        if len(self._known) > REMEMBERED:
            self._known.popitem(last=False)

    async def learn(self) -> None:
        """Read all keys that may stop vehicles.

        Raises:
            UnavailableError: the database is away; the earlier state remains.
        """
        async with self._store.read() as work:
            standing = await work.api_keys.standing(REMEMBERED)
        self._remembered = {
            token: key for token, key in standing if principal_of(key).may(Scope.VEHICLES_STOP)
        }

    def remembered(self, token: str, now_s: float) -> Principal | None:
        """The owner of a key at the last look at the database, for stops only. Thread-safe."""
        key = self._remembered.get(digest(token))
        if key is None or not usable(key, now_s):
            return None
        return replace(principal_of(key), scopes=STOP_ONLY)


def usable(key: ApiKey, now_s: float) -> bool:
    """Whether a key is neither revoked nor expired."""
    return key.revoked_at_s is None and (key.expires_at_s is None or now_s < key.expires_at_s)


def principal_of(key: ApiKey) -> Principal:
    """The principal of a key; unknown scopes of another version are ignored."""
    known = {scope.value: scope for scope in Scope}
    places = frozenset(key.places.split())
    return Principal(
        kind="key",
        id=key.id,
        name=key.name,
        scopes=frozenset(known[name] for name in key.scopes.split() if name in known),
        station=next(iter(places)) if len(places) == 1 else "",
        calls=CallLimits(
            places=places,
            items=frozenset(key.items.split()),
            open_max=key.open_max,
            open_each_max=key.open_each_max,
            priority=Priority(key.priority),
        ),
        expires_at_s=key.expires_at_s,
    )

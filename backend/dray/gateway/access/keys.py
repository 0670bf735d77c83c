"""Keys: how other systems are recognised."""

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
"""The use of a key is noted this often."""

KNOWN_S = 1.0
"""Wall seconds for which a key is taken as the database has told of it: one that is taken back is refused within them,
and who places one order after the other has no look-up to wait for."""

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
        self._known: OrderedDict[str, tuple[float, ApiKey]] = OrderedDict()
        """By the token's digest, keys that were used lately, and when the database was asked."""

    async def recognise(self, token: str) -> Principal | None:
        """Whose key this is; None when it is nobody's, or not any more.

        Raises:
            Problem: 429, it is used too often.
        """
        now_s = self._wall_s()
        key = await self._find(token, now_s)
        if key is None or not usable(key, now_s):
            return None
        self._limit.take(key.id)
        if key.used_at_s is None or now_s - key.used_at_s >= USED_AGAIN_S:
            # A database that can only be read still tells whose key it is.
            with suppress(UnavailableError):
                async with self._store.write() as work:
                    await work.api_keys.use(key.id, now_s)
                self._note(token, now_s, msgspec.structs.replace(key, used_at_s=now_s))
        return principal_of(key)

    async def _find(self, token: str, now_s: float) -> ApiKey | None:
        """The key with this token, as it was within the last `KNOWN_S`."""
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

"""Access: all that tells who somebody is and keeps what they did, for one running gateway."""

from __future__ import annotations

import hmac
from collections.abc import Callable
from dataclasses import dataclass

from dray.gateway.access.hasher import Hasher
from dray.gateway.access.keys import Keys
from dray.gateway.access.limits import Limit, neighbourhood
from dray.gateway.access.login import Login
from dray.gateway.access.principal import ADMIN, Principal
from dray.gateway.access.sessions import Sessions
from dray.gateway.access.tokens import KEY_PREFIX
from dray.gateway.access.trail import Trail
from dray.gateway.access.watch import Watch
from dray.settings import Settings
from dray.store import Store

STRANGERS_TRIES = 50
"""Tokens that one address may show and that nobody knows: a script with an old key, started anew some times."""

STRANGERS_HZ = 1.0
"""Tries that come back per second."""


@dataclass(frozen=True)
class Access:
    """Who is who."""

    sessions: Sessions
    keys: Keys
    login: Login
    watch: Watch
    trail: Trail
    strangers: Limit
    admin_token: str

    async def by_bearer(self, token: str, address: str) -> Principal | None:
        """Whose bearer token this is; None when it is nobody's.

        Raises:
            Problem: 429, too many from this address were nobody's, or a key is used too often.
        """
        if self.admin_token and hmac.compare_digest(token.encode(), self.admin_token.encode()):
            return ADMIN
        principal = await self.keys.recognise(token) if token.startswith(KEY_PREFIX) else None
        if principal is None:
            self.strangers.take(neighbourhood(address))
        return principal


def open_access(
    settings: Settings, store: Store, wall_s: Callable[[], float], hasher: Hasher | None = None
) -> Access:
    """Put it together.

    Args:
        settings: limits, and the administrator's token.
        store: where people, sessions and keys are kept.
        wall_s: the wall clock.
        hasher: of secrets, when not the usual one.
    """
    token = settings.admin_token
    return Access(
        sessions=Sessions(store, wall_s),
        keys=Keys(store, wall_s, rate_hz=settings.key_rate_hz, tries=settings.key_burst),
        login=Login(store, hasher or Hasher(), wall_s),
        watch=Watch(store, wall_s),
        trail=Trail(store, wall_s, settings.audit_kept),
        strangers=Limit(wall_s, tries=STRANGERS_TRIES, rate_hz=STRANGERS_HZ),
        admin_token="" if token is None else token.get_secret_value(),
    )

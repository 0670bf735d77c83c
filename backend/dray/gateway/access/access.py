"""Access: the parts of a running gateway that recognise callers and record their actions."""

from __future__ import annotations

import asyncio
import hmac
import logging
from collections.abc import Callable
from dataclasses import dataclass

from dray.errors import UnavailableError
from dray.gateway.access.audit_log import AuditLog
from dray.gateway.access.keys import Keys
from dray.gateway.access.limits import Limit, neighbourhood
from dray.gateway.access.login.hasher import Hasher
from dray.gateway.access.login.login import Login
from dray.gateway.access.principal import ADMIN, Principal
from dray.gateway.access.sessions import Sessions
from dray.gateway.access.tokens import KEY_PREFIX
from dray.gateway.access.watch import Watch
from dray.settings import Settings
from dray.store import Store

STRANGERS_TRIES = 50
"""Burst of unknown tokens per address: a script with an old key, restarted several times."""

STRANGERS_HZ = 1.0
"""Tries that come back per second."""

LEARN_S = 2.0
"""Maximum wall seconds until a login or logout at another process is known without asking the database."""

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Access:
    """The parts."""

    sessions: Sessions
    keys: Keys
    login: Login
    hasher: Hasher
    watch: Watch
    audit_log: AuditLog
    strangers: Limit
    admin_token: str
    wall_s: Callable[[], float]
    """The wall clock of the gateway's own loop."""

    def remembered(self, credentials: str, cookie: str, now_s: float) -> Principal | None:
        """The caller at the last look at the database; for stops only. Thread-safe.

        Args:
            credentials: the header Authorization; empty for none.
            cookie: the session's cookie; used without credentials.
            now_s: the wall clock, read in the calling thread.
        """
        if not credentials:
            return self.sessions.remembered(cookie, now_s) if cookie else None
        kind, _, token = credentials.partition(" ")
        token = token.strip()
        if kind.lower() != "bearer" or not token:
            return None
        return ADMIN if self._is_admins(token) else self.keys.remembered(token, now_s)

    async def learn(self) -> None:
        """Read from the database who may stop vehicles.

        Raises:
            UnavailableError: the database is away; the earlier state remains.
        """
        await self.sessions.learn()
        await self.keys.learn()

    async def run(self) -> None:
        """Learn every `LEARN_S` until cancelled."""
        away = False
        while True:
            try:
                await self.learn()
                away = False
            except UnavailableError as error:
                if not away:
                    _log.warning("who may stop vehicles is known from before: %s", error)
                away = True
            await asyncio.sleep(LEARN_S)

    def _is_admins(self, token: str) -> bool:
        return bool(self.admin_token) and hmac.compare_digest(token.encode(), self.admin_token.encode())

    async def by_bearer(self, token: str, address: str) -> Principal | None:
        """The owner of a bearer token; None if unknown.

        Raises:
            Problem: 429, too many unknown tokens from this address, or a key is used too often.
        """
        if self._is_admins(token):
            return ADMIN
        principal = await self.keys.recognise(token) if token.startswith(KEY_PREFIX) else None
        if principal is None:
            self.strangers.take(neighbourhood(address))
        return principal


def open_access(
    settings: Settings, store: Store, wall_s: Callable[[], float], hasher: Hasher | None = None
) -> Access:
    """Put the parts together.

    Args:
        settings: limits, and the administrator's token.
        store: the database with people, sessions and keys.
        wall_s: the wall clock.
        hasher: replaces the usual hasher of secrets.
    """
    token = settings.admin_token
    hasher = hasher or Hasher()
    return Access(
        sessions=Sessions(store, wall_s),
        keys=Keys(store, wall_s, rate_hz=settings.key_rate_hz, tries=settings.key_burst),
        login=Login(store, hasher, wall_s),
        hasher=hasher,
        watch=Watch(store, wall_s),
        audit_log=AuditLog(store, wall_s),
        strangers=Limit(wall_s, tries=STRANGERS_TRIES, rate_hz=STRANGERS_HZ),
        admin_token="" if token is None else token.get_secret_value(),
        wall_s=wall_s,
    )

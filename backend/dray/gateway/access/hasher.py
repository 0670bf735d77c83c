"""Hashing what people know: passwords, PINs and badge codes.

Argon2id is slow and takes much memory on purpose, so it is done off the event loop, a few at a time.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from http import HTTPStatus
from typing import TypeVar, TypeVarTuple

from argon2 import PasswordHasher, Type
from argon2.exceptions import InvalidHashError, VerificationError
from argon2.low_level import hash_secret_raw

from dray.gateway.problems import Problem

T = TypeVar("T")
Ts = TypeVarTuple("Ts")

AT_ONCE = 2
"""Hashes that are computed at the same time: each takes 64 MiB and a core for some 50 ms."""

WAITING = 50
"""Logins that wait for their turn: some seconds. A whole shift does not log in at one moment."""

NOBODYS = "nobody's secret"


class Hasher:
    """Hashes and checks secrets.

    Args:
        argon2: the costs; those of RFC 9106 for machines with little memory, when absent.
    """

    def __init__(self, argon2: PasswordHasher | None = None) -> None:
        self._argon2 = argon2 or PasswordHasher()
        self._nobodys = self._argon2.hash(NOBODYS)
        self._turn = asyncio.Semaphore(AT_ONCE)
        self._waiting = 0

    async def matches(self, kept: str | None, secret: str) -> bool:
        """Whether this is the secret whose hash is kept; takes as long where there is none.

        Raises:
            Problem: 503, too many are being checked.
        """
        return await self._off_the_loop(self._matches, kept or self._nobodys, secret) and kept is not None

    async def badge(self, code: str, salt: str) -> str:
        """What is kept of a badge's code, and what it is looked up by.

        Args:
            code: the badge's.
            salt: of this database, in hexadecimal digits.

        Raises:
            Problem: 503, too many are being checked.
        """
        return await self._off_the_loop(self.badge_hash, code, salt)

    def hash(self, secret: str) -> str:
        """What is kept of a password or PIN. Takes its time."""
        return self._argon2.hash(secret)

    def badge_hash(self, code: str, salt: str) -> str:
        """See `badge`. Takes its time."""
        return hash_secret_raw(
            code.encode(),
            bytes.fromhex(salt),
            time_cost=self._argon2.time_cost,
            memory_cost=self._argon2.memory_cost,
            parallelism=self._argon2.parallelism,
            hash_len=self._argon2.hash_len,
            type=Type.ID,
        ).hex()

    async def _off_the_loop(self, work: Callable[[*Ts], T], *given: *Ts) -> T:
        if self._waiting >= WAITING:
            raise Problem(
                HTTPStatus.SERVICE_UNAVAILABLE,
                "too-many-logins",
                "Too many log in at this moment",
                "try again in some seconds",
                headers={"Retry-After": "5"},
            )
        self._waiting += 1
        try:
            async with self._turn:
                return await asyncio.to_thread(work, *given)
        finally:
            self._waiting -= 1

    def _matches(self, kept: str, secret: str) -> bool:
        try:
            return self._argon2.verify(kept, secret)
        except (VerificationError, InvalidHashError):
            return False

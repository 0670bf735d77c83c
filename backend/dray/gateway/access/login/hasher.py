"""Hashing of passwords, PINs and badge codes.

Argon2id is slow and needs much memory on purpose, so it runs off the event loop, a few hashes at a time.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http import HTTPStatus
from typing import TypeVar, TypeVarTuple

from argon2 import PasswordHasher, Type
from argon2.exceptions import InvalidHashError, VerificationError
from argon2.low_level import hash_secret_raw

from dray.gateway.http.problems import Problem

T = TypeVar("T")
Ts = TypeVarTuple("Ts")

AT_ONCE = 2
"""Maximum concurrent hashes: each takes 64 MiB and a core for some 50 ms."""

WAITING = 50
"""Maximum waiting logins: some seconds. A whole shift does not log in at one moment."""

NOBODYS = "nobody's secret"


class Hasher:
    """Hashes and checks secrets.

    Args:
        argon2: the costs; by default those of RFC 9106 for machines with little memory.
    """

    def __init__(self, argon2: PasswordHasher | None = None) -> None:
        self._argon2 = argon2 or PasswordHasher()
        self._nobodys = self._argon2.hash(NOBODYS)
        self._turn = asyncio.Semaphore(AT_ONCE)
        self._waiting = 0

    @contextmanager
    def place(self) -> Iterator[Place]:
        """A place in the queue for hashing, kept within the context.

        A caller without a place has not tried to log in, so it is taken before a try is counted.

        Raises:
            Problem: 503, the queue is full.
        """
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
            yield Place(self)
        finally:
            self._waiting -= 1

    async def off_the_loop(self, work: Callable[[*Ts], T], *given: *Ts) -> T:
        """Run slow work in a thread when its turn comes."""
        async with self._turn:
            return await asyncio.to_thread(work, *given)

    def matches(self, kept: str | None, secret: str) -> bool:
        """Whether a secret matches a stored hash; takes as long without one. Slow."""
        try:
            self._argon2.verify(kept or self._nobodys, secret)
        except (VerificationError, InvalidHashError):
            return False
        return kept is not None

    def hash(self, secret: str) -> str:
        """The hash of a password or PIN. Slow."""
        return self._argon2.hash(secret)

    def badge_hash(self, code: str, salt: str) -> str:
        """The hash of a badge's code, by which it is looked up. Slow.

        Args:
            code: the badge's code.
            salt: this database's salt, in hexadecimal digits.
        """
        return hash_secret_raw(
            code.encode(),
            bytes.fromhex(salt),
            time_cost=self._argon2.time_cost,
            memory_cost=self._argon2.memory_cost,
            parallelism=self._argon2.parallelism,
            hash_len=self._argon2.hash_len,
            type=Type.ID,
        ).hex()


class Place:
    """A place in the queue for hashing (`Hasher.place`)."""

    def __init__(self, hasher: Hasher) -> None:
        self._hasher = hasher

    async def matches(self, kept: str | None, secret: str) -> bool:
        """See `Hasher.matches`."""
        return await self._hasher.off_the_loop(self._hasher.matches, kept, secret)

    async def hash(self, secret: str) -> str:
        """See `Hasher.hash`."""
        return await self._hasher.off_the_loop(self._hasher.hash, secret)

    async def badge_hash(self, code: str, salt: str) -> str:
        """See `Hasher.badge_hash`."""
        return await self._hasher.off_the_loop(self._hasher.badge_hash, code, salt)

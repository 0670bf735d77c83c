"""Grants for tests: a seal that anybody can make stands for a signature, and vehicles trust it."""

from __future__ import annotations

from collections.abc import Iterable
from hashlib import sha512
from typing import TypeVar

from msgspec.structs import replace

from dray.messages import Grant, MachineCommand, VehicleCommand, signed_words

FOR_EVER_S = 1e9

C = TypeVar("C", VehicleCommand, MachineCommand)


def seal(words: bytes) -> bytes:
    """As long as a signature, and another one for other words."""
    return sha512(words).digest()


def trusts_seals(words: bytes, signature: bytes) -> bool:
    """What a vehicle in a test trusts."""
    return signature == seal(words)


def granted(
    agent: str,
    command: C,
    *,
    person: str = "shift-lead",
    areas: Iterable[str] | None = None,
    valid_until_s: float = FOR_EVER_S,
) -> C:
    """A command with a grant: everywhere, or for some areas."""
    grant = Grant(
        person=person,
        valid_until_s=valid_until_s,
        signature=b"",
        areas=() if areas is None else tuple(areas),
        everywhere=areas is None,
    )
    return replace(command, grant=replace(grant, signature=seal(signed_words(agent, command, grant))))

"""Signing: grants, closures and removals are signed with Ed25519 (RFC 8032); receivers trust configured public keys.

A vehicle also signs its place requests, with a key of its own that nobody certifies. It shows the leader of a reservation table that the
requests come from the vehicle that holds the places.
"""

from __future__ import annotations

from collections.abc import Iterable
from hashlib import sha256
from typing import TypeVar

from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey, Ed25519PublicKey
from msgspec.structs import replace

from dray.messages import (
    Closure,
    Closures,
    Grant,
    MachineCommand,
    PlaceRequested,
    Removal,
    ReportTime,
    VehicleCommand,
    closed_words,
    removed_words,
    reported_words,
    signed_words,
)
from dray.messages.floor.traffic import request_words

UNSIGNED = b""

C = TypeVar("C", VehicleCommand, MachineCommand)


class SigningKey:
    """A private key that signs grants, closures and removals.

    Args:
        private: its 32 bytes.

    Attributes:
        public: the 32 bytes of the matching public key.

    Raises:
        ValueError: it is no key.
    """

    def __init__(self, private: bytes) -> None:
        self._key = Ed25519PrivateKey.from_private_bytes(private)
        self.public = self._key.public_key().public_bytes_raw()

    @staticmethod
    def generate() -> bytes:
        """The 32 bytes of a new private key."""
        return Ed25519PrivateKey.generate().private_bytes_raw()

    def grant(
        self,
        agent: str,
        command: C,
        *,
        person: str,
        areas: Iterable[str] | None,
        valid_until_s: float,
    ) -> C:
        """The same command to one vehicle or machine, with a grant.

        Args:
            agent: the vehicle or machine.
            command: the command.
            person: the person on whose behalf it is given.
            areas: the areas in which that person may command; None for everywhere.
            valid_until_s: the grant's end on the plant's clock.
        """
        grant = _unsigned(person, areas, valid_until_s)
        signature = self._key.sign(signed_words(agent, command, grant))
        return replace(command, grant=replace(grant, signature=signature))

    def code(self, what: str) -> bytes:
        """32 bytes derived from a text and this key, which nobody else can compute."""
        return sha256(self._key.sign(f"dray code {what}".encode())).digest()

    def close(self, number: int, closures: Iterable[Closure]) -> Closures:
        """A list of closures, signed.

        Args:
            number: the number of the last decision.
            closures: all closures in force.
        """
        closed = tuple(closures)
        return Closures(
            number=number, signature=self._key.sign(closed_words(number, closed)), closures=closed
        )

    def remove(
        self,
        atv: str,
        number: int,
        *,
        heard: tuple[int, int],
        node: str,
        person: str,
        areas: Iterable[str] | None,
        reported_s: float,
        now_s: float,
        valid_until_s: float,
    ) -> Removal:
        """A person's signed statement that a vehicle was carried away, or is being put back.

        Args:
            atv: the vehicle.
            number: the statement's number.
            heard: life and number of the vehicle's last received heartbeat.
            node: where it is being put back; empty while it is off the floor.
            person: the person on whose behalf it is made.
            areas: the areas in which that person may command; None for everywhere.
            reported_s: when that person made it, on the plant's clock.
            now_s: the present time on the same clock.
            valid_until_s: the grant's end on the plant's clock.
        """
        life, seq = heard
        grant = _unsigned(person, areas, valid_until_s)
        removal = Removal(atv=atv, number=number, life=life, seq=seq, grant=grant, node=node)
        removal = replace(removal, grant=replace(grant, signature=self._key.sign(removed_words(removal))))
        time = ReportTime(at_s=reported_s, signed_s=now_s, signature=UNSIGNED)
        time = replace(time, signature=self._key.sign(reported_words(removal, time)))
        return replace(removal, reported=time)


class VehicleKey:
    """A vehicle's own private key, which distinguishes it from a thief of its certificate.

    Args:
        atv: the vehicle.
        private: its 32 bytes.

    Raises:
        ValueError: it is no key.
    """

    def __init__(self, atv: str, private: bytes) -> None:
        self._atv = atv
        self._key = Ed25519PrivateKey.from_private_bytes(private)
        self._public = self._key.public_key().public_bytes_raw()

    def sign(self, request: PlaceRequested) -> PlaceRequested:
        """The same request with this key and its signature."""
        signature = self._key.sign(request_words(self._atv, request))
        return replace(request, key=self._public, signature=signature)


def is_signed(atv: str, request: PlaceRequested) -> bool:
    """Whether a vehicle's request is signed by the key that it contains, or contains none."""
    if not request.key:
        return True
    try:
        key = Ed25519PublicKey.from_public_bytes(request.key)
    except ValueError:
        return False
    return _signed_by(key, request_words(atv, request), request.signature)


class TrustedKeys:
    """The public keys whose grants are accepted.

    Args:
        public: 32 bytes each; without any, no grant is accepted.

    Raises:
        ValueError: one is no key.
    """

    def __init__(self, *public: bytes) -> None:
        self._keys = tuple(Ed25519PublicKey.from_public_bytes(each) for each in public)

    def __call__(self, words: bytes, signature: bytes) -> bool:
        """Whether one of the keys has signed exactly this data."""
        return any(_signed_by(key, words, signature) for key in self._keys)


def _unsigned(person: str, areas: Iterable[str] | None, valid_until_s: float) -> Grant:
    return Grant(
        person=person,
        valid_until_s=valid_until_s,
        signature=UNSIGNED,
        areas=() if areas is None else tuple(areas),
        everywhere=areas is None,
    )


def _signed_by(key: Ed25519PublicKey, words: bytes, signature: bytes) -> bool:
    try:
        key.verify(signature, words)
    except InvalidSignature:
        return False
    return True

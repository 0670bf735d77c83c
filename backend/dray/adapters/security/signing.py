"""Signing: grants, closures and removals are signed with Ed25519 (RFC 8032), and believed by whoever knows the public key.

A vehicle's wishes for places are, too, by a key of its own, which nobody examines: whoever keeps a book knows by it whether the one who speaks in
a vehicle's name is the one who holds places in it.
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
    PlaceWished,
    Removal,
    VehicleCommand,
    closed_words,
    removed_words,
    signed_words,
)
from dray.messages.floor.traffic import wished_words

UNSIGNED = b""

C = TypeVar("C", VehicleCommand, MachineCommand)


class SigningKey:
    """A private key, which grants commands and signs closures and removals.

    Args:
        private: its 32 bytes.

    Attributes:
        public: the 32 bytes of the public key that belongs to it.

    Raises:
        ValueError: that is no key.
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
            agent: which.
            command: what is asked.
            person: on whose behalf.
            areas: where that person may command; None for everywhere.
            valid_until_s: on the plant's clock.
        """
        grant = _unsigned(person, areas, valid_until_s)
        signature = self._key.sign(signed_words(agent, command, grant))
        return replace(command, grant=replace(grant, signature=signature))

    def code(self, what: str) -> bytes:
        """32 bytes that follow from a text and this key, and that nobody else can compute."""
        return sha256(self._key.sign(f"dray code {what}".encode())).digest()

    def close(self, number: int, closures: Iterable[Closure]) -> Closures:
        """A list of closures, signed.

        Args:
            number: of the last decision.
            closures: all that hold.
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
        valid_until_s: float,
    ) -> Removal:
        """A person's word that a vehicle was carried away, or is being put back, with a grant.

        Args:
            atv: the vehicle.
            number: of the word.
            heard: life and number of the last heartbeat that was heard of it.
            node: where it is being put back; empty while it is off the floor.
            person: on whose behalf.
            areas: where that person may command; None for everywhere.
            valid_until_s: on the plant's clock.
        """
        life, seq = heard
        grant = _unsigned(person, areas, valid_until_s)
        removal = Removal(atv=atv, number=number, life=life, seq=seq, grant=grant, node=node)
        return replace(removal, grant=replace(grant, signature=self._key.sign(removed_words(removal))))


class VehicleKey:
    """A vehicle's own private key, by which it is told from whoever has stolen its certificate.

    Args:
        atv: the vehicle.
        private: its 32 bytes.

    Raises:
        ValueError: that is no key.
    """

    def __init__(self, atv: str, private: bytes) -> None:
        self._atv = atv
        self._key = Ed25519PrivateKey.from_private_bytes(private)
        self._public = self._key.public_key().public_bytes_raw()

    def sign(self, wish: PlaceWished) -> PlaceWished:
        """The same wish with this key and its signature."""
        signature = self._key.sign(wished_words(self._atv, wish))
        return replace(wish, key=self._public, signature=signature)


def is_signed(atv: str, wish: PlaceWished) -> bool:
    """Whether a vehicle's wish is signed by the key that it names, or names none."""
    if not wish.key:
        return True
    try:
        key = Ed25519PublicKey.from_public_bytes(wish.key)
    except ValueError:
        return False
    return _signed_by(key, wished_words(atv, wish), wish.signature)


class TrustedKeys:
    """The public keys of those whose grants count.

    Args:
        public: 32 bytes each; without any, nobody is trusted.

    Raises:
        ValueError: one is no key.
    """

    def __init__(self, *public: bytes) -> None:
        self._keys = tuple(Ed25519PublicKey.from_public_bytes(each) for each in public)

    def __call__(self, words: bytes, signature: bytes) -> bool:
        """Whether one of them has signed exactly these words."""
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

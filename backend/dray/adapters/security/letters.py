"""Letters: what is said to one agent alone is read by that agent alone.

Neighbours pass letters on for one another, and on Zenoh anybody may listen on anybody's key. So where agents have
certificates a letter is encrypted (AES-256-GCM) with a secret that only its sender and its reader can work out: the
one from its own private key and the other's certified one (ECDH on P-256, HKDF). That proves the sender, too, to its
reader: nobody else has the secret. So a letter needs no signature, and costs less than a word to everybody.

The secret is one for each sender, reader and pair of certificates. It is as old as those: whoever steals an agent's key
reads what was recorded before. Who writes to whom, how much and when is not hidden.
"""

from __future__ import annotations

import os
from dataclasses import dataclass

import msgspec
from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.ciphers.aead import AESGCM
from cryptography.hazmat.primitives.kdf.hkdf import HKDF

from dray.adapters.security.register import Certified
from dray.adapters.security.seals import Milliseconds, Seals
from dray.codec import MAX_BYTES
from dray.errors import SealError, WireError
from dray.messages.kinds import Kind

SECRETS = 2000
"""Kept: a gateway's with each agent of a plant of three hundred, both ways, and as many again. Another one is worked
out in a tenth of a millisecond."""

SECRET_BYTES = 32

TAG_BYTES = 16
"""Behind the words: by these AES-GCM shows that a letter is as it was written."""

NONCE_BYTES = 12
"""Random. Who writes a hundred letters a second to one reader until the certificates end, after a year, has used one of
them twice with a chance of one in ten thousand million."""


class _Cover(msgspec.Struct, frozen=True, gc=False, array_like=True):
    certificate: bytes
    sender: str
    at_ms: Milliseconds
    nonce: bytes


_write = msgspec.msgpack.Encoder().encode
_read = msgspec.msgpack.Decoder(_Cover).decode


@dataclass(frozen=True, slots=True)
class Place:
    """Where a letter stands: whose it is, and which of how many. It is good for no other.

    Attributes:
        reader: the agent that it is for.
        life: of its sender.
        number: of the letters to this reader in that life.
    """

    reader: str
    life: int
    number: int

    def bound(self, at_ms: int) -> bytes:
        """What is bound to its words, and is no secret; `at_ms` is when they were written (unix time)."""
        return f"{self.reader} {self.life} {self.number} {at_ms}".encode()


class Letters:
    """Writes the letters of this process, and reads those to its agents. On any thread.

    Args:
        seals: by which agents are known.
    """

    def __init__(self, seals: Seals) -> None:
        self._seals = seals
        self._secrets: dict[tuple[str, str, bytes], AESGCM] = {}

    def write(self, sender: str, place: Place, words: bytes) -> tuple[bytes, bytes] | None:
        """A letter of an agent of ours and its seal; None when its reader's certificate is not known.

        Whoever is there has shown it, by its token.
        """
        reader = self._seals.register.known(place.reader)
        if reader is None:
            return None
        at_ms, nonce = self._seals.now_ms(), os.urandom(NONCE_BYTES)
        secret = self._secret(sender, place.reader, reader)
        letter = secret.encrypt(nonce, words, place.bound(at_ms))
        return letter, _write(_Cover(self._seals.certificate, sender, at_ms, nonce))

    def named(self, seal: bytes, letter: bytes) -> str:
        """Who says to have written a letter. Only `read` shows that it is so.

        Raises:
            SealError: its seal says nothing.
        """
        return _cover(seal, letter).sender

    def read(self, seal: bytes, place: Place, letter: bytes) -> tuple[str, Kind, bytes]:
        """Who has written a letter to an agent of ours, what that is, and the words.

        Raises:
            SealError: nobody whom we know has, or not to this reader, not here, not now.
            WireError: it is longer than any message.
        """
        cover = _cover(seal, letter)
        if len(letter) > MAX_BYTES + TAG_BYTES:
            raise WireError(f"{len(letter)} bytes, more than {MAX_BYTES}", letter)
        sender, kind = self._seals.register.certified(cover.certificate, cover.sender, letter)
        self._seals.check_age(cover.at_ms, letter)
        secret = self._secret(cover.sender, place.reader, sender)
        try:
            words = secret.decrypt(cover.nonce, letter, place.bound(cover.at_ms))
        except (InvalidTag, ValueError) as fault:
            raise SealError("it cannot be opened", letter) from fault
        self._seals.register.meet(cover.sender, place.life, cover.certificate)
        return cover.sender, kind, words

    def _secret(self, sender: str, reader: str, other: Certified) -> AESGCM:
        """Of a sender and a reader of whom one is ours and has our key, and the other has this certificate."""
        place = (sender, reader, other.certificate)
        known = self._secrets.get(place)
        if known is not None:
            return known
        words = f"dray letter {self._seals.plant} {sender} {reader}".encode()
        derive = HKDF(hashes.SHA256(), SECRET_BYTES, salt=None, info=words).derive
        secret = AESGCM(derive(self._seals.agree_with(other)))
        if len(self._secrets) >= SECRETS:
            self._secrets.clear()
        self._secrets[place] = secret
        return secret


def _cover(seal: bytes, letter: bytes) -> _Cover:
    try:
        return _read(seal)
    except (msgspec.MsgspecError, ValueError) as fault:
        raise SealError(f"no letter's seal: {fault}", letter) from fault

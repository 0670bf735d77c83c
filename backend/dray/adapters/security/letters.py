"""Letters: messages to one agent that only this agent can read.

Neighbours relay letters, and on Zenoh any process may listen on any key. So where agents have certificates, a letter is encrypted
(AES-256-GCM) with a secret of its sender and its reader. Each derives it from its own private key and the other's certified one
(ECDH on P-256, HKDF). This also proves the sender to the reader, because nobody else has the secret. So a letter needs no signature,
and costs less than a published message.

There is one secret per sender, reader and pair of certificates, as long as these are valid: with a stolen key, recorded letters can
be read. Sender, reader, size and time of letters are not hidden.
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
"""Maximum cached secrets: a gateway's with each agent of a plant of three hundred, both ways, and as many again. Deriving one
takes a tenth of a millisecond."""

SECRET_BYTES = 32

TAG_BYTES = 16
"""The length of the authentication tag after the ciphertext, by which AES-GCM detects changes."""

NONCE_BYTES = 12
"""Length of the random nonce. Assume a hundred letters a second to one reader, for a certificate's year. The probability of a
repetition is then one in ten thousand million."""


class _Cover(msgspec.Struct, frozen=True, gc=False, array_like=True):
    certificate: bytes
    sender: str
    at_ms: Milliseconds
    nonce: bytes


_write = msgspec.msgpack.Encoder().encode
_read = msgspec.msgpack.Decoder(_Cover).decode


@dataclass(frozen=True, slots=True)
class Place:
    """A letter's reader and number; the letter is invalid at any other place.

    Attributes:
        reader: the agent that may read it.
        life: the sender's life.
        number: the letter's number to this reader in that life.
    """

    reader: str
    life: int
    number: int

    def bound(self, at_ms: int) -> bytes:
        """The authenticated, unencrypted data of a letter; `at_ms` is its time of writing (unix time)."""
        return f"{self.reader} {self.life} {self.number} {at_ms}".encode()


class Letters:
    """Writes the letters of this process, and reads those to its agents. Thread-safe.

    Args:
        seals: the known agents.
    """

    def __init__(self, seals: Seals) -> None:
        self._seals = seals
        self._secrets: dict[tuple[str, str, bytes], AESGCM] = {}

    def write(self, sender: str, place: Place, words: bytes) -> tuple[bytes, bytes] | None:
        """A letter of one of our agents and its seal; None when the reader's certificate is unknown.

        Every agent on the bus has shown its certificate, in its token.
        """
        reader = self._seals.register.known(place.reader)
        if reader is None:
            return None
        at_ms, nonce = self._seals.now_ms(), os.urandom(NONCE_BYTES)
        secret = self._secret(sender, place.reader, reader)
        letter = secret.encrypt(nonce, words, place.bound(at_ms))
        return letter, _write(_Cover(self._seals.certificate, sender, at_ms, nonce))

    def named(self, seal: bytes, letter: bytes) -> str:
        """The claimed sender of a letter. Only `read` proves it.

        Raises:
            SealError: its seal is unreadable.
        """
        return _cover(seal, letter).sender

    def read(self, seal: bytes, place: Place, letter: bytes) -> tuple[str, Kind, bytes]:
        """The sender of a letter to one of our agents, the sender's kind, and the plaintext.

        Raises:
            SealError: no known agent has written it, or not to this reader, not here, not now.
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
        """The cipher of a sender and a reader: one is ours and has our key, the other has this certificate."""
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

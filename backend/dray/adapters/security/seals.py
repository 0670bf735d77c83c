"""Seals: signatures that prove a message's sender, over any relays.

TLS authenticates only the neighbour on a link. Neighbours relay for one another, so a machine's message may come from a
vehicle. Therefore the sender signs every message, together with its key on the bus and the time, and attaches its
certificate. A relay can only lose a message. Beside the message's own bytes, only text and whole numbers
are signed, because languages print floats differently.

A message may be replayed within `FRESH_S`; the protocol must tolerate duplicates anyway. A voucher is a chunk of a key by which an
agent declares its presence. It may be replayed for ever, so it must contain nothing that becomes wrong later.
"""

from __future__ import annotations

import base64
import binascii
import time
from collections.abc import Callable
from typing import Annotated

import msgspec
from cryptography import x509
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.verification import VerificationError

from dray.adapters.security.certificates import agents_of, read_key
from dray.adapters.security.identity import Identity
from dray.adapters.security.register import Certified, Register
from dray.adapters.security.revocations import FILE as REVOKED
from dray.adapters.security.revocations import Revocations
from dray.errors import SealError, SettingsError
from dray.messages.kinds import Kind

FRESH_S = 30.0
"""Maximum age of a message (s, plant clock): the slowest link of the paper takes 5 s, and clocks agree within 0.1 s. Below
`dray.messages.overtaken.OVERTAKES_S`, which is told by the same clock."""

Milliseconds = Annotated[int, msgspec.Meta(ge=0, le=2**53)]
"""Whole milliseconds of unix time, which every language writes alike."""

_DAY = "%Y-%m-%d %H:%M"

_ECDSA = ec.ECDSA(hashes.SHA256())


class _Voucher(msgspec.Struct, frozen=True, gc=False, array_like=True):
    certificate: bytes
    signature: bytes


class _Seal(msgspec.Struct, frozen=True, gc=False, array_like=True):
    certificate: bytes
    at_ms: Milliseconds
    signature: bytes


_write = msgspec.msgpack.Encoder().encode
_read = msgspec.msgpack.Decoder(_Seal).decode
_read_voucher = msgspec.msgpack.Decoder(_Voucher).decode


class Seals:
    """Seals the messages of this process, and verifies the seals of others. Thread-safe.

    Args:
        identity: the own certificate and key, and the trusted authorities.
        plant: the plant's id; certificates of other plants are refused.
        now_s: unix time, for tests.
        clock_s: a monotonic clock, for tests.
        speed: seconds of the plant's clock per second.

    Attributes:
        plant: the plant's id.
        agents: the agents that this process may speak for.
        certificate: its own, in DER.
        until_s: the end of that certificate's validity (unix time).
        register: the certificates of others.

    Raises:
        SettingsError: the files contain no usable certificates or keys, do not match, name no agent of this plant, or are not
            valid now: nobody would accept our messages.
    """

    def __init__(
        self,
        identity: Identity,
        plant: str,
        *,
        now_s: Callable[[], float] = time.time,
        clock_s: Callable[[], float] = time.monotonic,
        speed: float = 1.0,
    ) -> None:
        self.plant, self.now_s = plant, now_s
        self._fresh_s = FRESH_S / max(1.0, speed)
        try:
            own = x509.load_pem_x509_certificate(identity.certificate.read_bytes())
            self._key = read_key(identity.key.read_bytes())
            authorities = x509.load_pem_x509_certificates(identity.authority.read_bytes())
        except (OSError, ValueError) as error:
            raise SettingsError(str(identity.certificate), f"cannot be used: {error}") from None
        self.agents = agents_of(own, plant)
        if not self.agents:
            raise SettingsError(
                str(identity.certificate),
                f"names no agent of the plant {plant}; `dray certs issue` makes one that does, by its authority",
            )
        if self._key.public_key() != own.public_key():
            raise SettingsError(
                str(identity.key), f"is not the key of {identity.certificate}: copy both anew"
            )
        revoked = identity.authority.with_name(REVOKED)
        revocations = Revocations(revoked, authorities, own.serial_number, clock_s=clock_s)
        self.register = Register(authorities, plant, now_s, revocations)
        try:
            self.register.verify(own, now_s())
        except VerificationError as fault:
            begins, ends = own.not_valid_before_utc, own.not_valid_after_utc
            raise SettingsError(
                str(identity.certificate),
                f"nobody would trust it ({fault}); it is valid from {begins:{_DAY}} to {ends:{_DAY}} UTC and has to "
                f"be signed by {identity.authority}: see that the clock is right, or make a new one with "
                "`dray certs issue`",
            ) from None
        if own.serial_number in revocations:
            raise SettingsError(
                str(identity.certificate),
                f"was revoked ({revoked}); make a new one with `dray certs issue`",
            )
        self.until_s = own.not_valid_after_utc.timestamp()
        self.certificate = own.public_bytes(serialization.Encoding.DER)
        for agent in self.agents:
            # A later life elsewhere replaces this entry.
            self.register.meet(agent, 0, self.certificate)

    def seal(self, key: str, life: int, number: int, data: bytes) -> bytes:
        """Seal a message on `key`, with the present time."""
        at_ms = self.now_ms()
        signature = self._key.sign(_signed(key, life, number, at_ms, data), _ECDSA)
        return _write(_Seal(self.certificate, at_ms, signature))

    def examine(self, seal: bytes, sender: str, key: str, life: int, number: int, data: bytes) -> Kind:
        """The kind of the agent that has verifiably sent this message.

        Raises:
            SealError: no known agent has sent it, or not this message, not here, not now.
        """
        try:
            read = _read(seal)
        except (msgspec.MsgspecError, ValueError) as fault:
            raise SealError(f"no seal: {fault}", data) from fault
        certified, kind = self.register.certified(read.certificate, sender, data)
        self.check_age(read.at_ms, data)
        _verify(certified, read.signature, _signed(key, life, number, read.at_ms, data))
        self.register.meet(sender, life, read.certificate)
        return kind

    def now_ms(self) -> int:
        """The time of a message sent now (unix time)."""
        return int(self.now_s() * 1000)

    def check_age(self, at_ms: int, data: bytes) -> None:
        """Check that a message of this time (unix time) is neither too old nor from the future.

        Raises:
            SealError: it is one of these.
        """
        age_s = self.now_s() - at_ms / 1000
        if abs(age_s) > self._fresh_s:
            raise SealError(f"said {age_s:.0f} s ago", data)

    def agree_with(self, other: Certified) -> bytes:
        """The shared secret of our key and another certificate's key.

        The same keys sign, but no signed data is ever used as a secret, nor the reverse.
        """
        return self._key.exchange(ec.ECDH(), other.key)

    def vouch(self, key: str) -> str:
        """A chunk that, at the end of `key`, proves its declaring agent."""
        signature = self._key.sign(_vouched(key), _ECDSA)
        return base64.urlsafe_b64encode(_write(_Voucher(self.certificate, signature))).decode()

    def examine_voucher(self, chunk: str, agent: str, key: str) -> bytes:
        """The certificate of `agent`, as the voucher for this key proves it.

        Raises:
            SealError: no known agent has signed it, or not for this key.
        """
        read = _read_chunk(chunk)
        certified, _ = self.register.certified(read.certificate, agent, chunk.encode())
        _verify(certified, read.signature, _vouched(key))
        return read.certificate

    def is_met_by(self, chunk: str, agent: str) -> bool:
        """Whether a voucher contains the known certificate of `agent`, so that it needs no verification.

        Raises:
            SealError: it is no voucher.
        """
        return self.register.has(agent, _read_chunk(chunk).certificate)


def _read_chunk(chunk: str) -> _Voucher:
    data = chunk.encode()
    try:
        return _read_voucher(base64.b64decode(data, altchars=b"-_", validate=True))
    except (msgspec.MsgspecError, binascii.Error, ValueError) as fault:
        raise SealError(f"no voucher: {fault}", data) from fault


def _verify(certified: Certified, signature: bytes, signed: bytes) -> None:
    try:
        certified.key.verify(signature, signed, _ECDSA)
    except InvalidSignature:
        raise SealError("its signature does not fit", signed) from None


def _vouched(key: str) -> bytes:
    return f"there {key}".encode()


def _signed(key: str, life: int, number: int, at_ms: int, data: bytes) -> bytes:
    return f"{key} {life} {number} {at_ms} ".encode() + data

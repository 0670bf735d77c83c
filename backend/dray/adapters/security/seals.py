"""Seals: who has said a message, whoever has passed it on.

Links are authenticated by TLS, but that says only who the neighbour is: neighbours relay for one another,
so a message of a machine may come from a vehicle. What must be known is who has said it. So every message
is signed by its sender, together with the key on which it was said and the time, and brings the sender's
certificate along. A relay can lose it, and nothing else. What is signed beside the message's own bytes is text and whole
numbers: no two languages print a float alike.

A message may be played again within `FRESH_S`; that is a message that comes twice, which the protocol
has to bear anyway. A voucher, by which an agent says in a chunk of a key that it is there, may be played again for
ever: it must say nothing that another moment makes wrong.
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
"""How old a message may be: the slowest link of the paper takes 5 s, and clocks agree within 0.1 s."""

Milliseconds = Annotated[int, msgspec.Meta(ge=0, le=2**53)]
"""Of unix time, whole: a moment that every language writes alike."""

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
    """Seals what this process says, and examines the seals of others. On any thread.

    Args:
        identity: whose certificate and key to use, and whom to trust.
        plant: the plant's id; certificates of other plants are worth nothing here.
        now_s: unix time, for tests.
        clock_s: a clock that never goes back, for tests.

    Attributes:
        plant: the plant's id.
        agents: for whom this process may speak.
        certificate: its own, in DER.
        until_s: until when that is valid (unix time).
        register: the certificates of others.

    Raises:
        SettingsError: the files hold no certificates or keys of ours, do not belong together, name no agent of this
            plant, or are not valid now: nobody would hear us.
    """

    def __init__(
        self,
        identity: Identity,
        plant: str,
        *,
        now_s: Callable[[], float] = time.time,
        clock_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self.plant, self.now_s = plant, now_s
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
                f"was called back ({revoked}); make a new one with `dray certs issue`",
            )
        self.until_s = own.not_valid_after_utc.timestamp()
        self.certificate = own.public_bytes(serialization.Encoding.DER)
        for agent in self.agents:
            # Until it is met elsewhere.
            self.register.meet(agent, 0, self.certificate)

    def seal(self, key: str, life: int, number: int, data: bytes) -> bytes:
        """Seal what is said on `key` now."""
        at_ms = self.now_ms()
        signature = self._key.sign(_signed(key, life, number, at_ms, data), _ECDSA)
        return _write(_Seal(self.certificate, at_ms, signature))

    def examine(self, seal: bytes, sender: str, key: str, life: int, number: int, data: bytes) -> Kind:
        """What kind of agent has really said this.

        Raises:
            SealError: nobody whom we know has, or not this, not here, not now.
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
        """The moment of what is said now (unix time)."""
        return int(self.now_s() * 1000)

    def check_age(self, at_ms: int, data: bytes) -> None:
        """See that what was said at this moment (unix time) is neither too old nor of the future.

        Raises:
            SealError: it is.
        """
        age_s = self.now_s() - at_ms / 1000
        if abs(age_s) > FRESH_S:
            raise SealError(f"said {age_s:.0f} s ago", data)

    def agree_with(self, other: Certified) -> bytes:
        """The secret that follows from our key and that of another certificate, and from the two alone.

        The same keys sign: nothing that is signed is ever taken for a secret, nor the other way round.
        """
        return self._key.exchange(ec.ECDH(), other.key)

    def vouch(self, key: str) -> str:
        """A chunk that, at the end of `key`, says who has declared it."""
        signature = self._key.sign(_vouched(key), _ECDSA)
        return base64.urlsafe_b64encode(_write(_Voucher(self.certificate, signature))).decode()

    def examine_voucher(self, chunk: str, agent: str, key: str) -> bytes:
        """The certificate of `agent`, who has vouched for this key.

        Raises:
            SealError: nobody whom we know has, or not for this.
        """
        read = _read_chunk(chunk)
        certified, _ = self.register.certified(read.certificate, agent, chunk.encode())
        _verify(certified, read.signature, _vouched(key))
        return read.certificate

    def is_met_by(self, chunk: str, agent: str) -> bool:
        """Whether a voucher brings the certificate by which `agent` is known already, whoever has signed it: it need not be examined.

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

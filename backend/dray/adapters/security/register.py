"""The register: certificates that this process has examined, and which of them each agent has.

It begins empty and learns from what others show: a token brings its agent's certificate, and so does every message.
"""

from __future__ import annotations

import datetime as dt
from collections.abc import Callable, Container, Mapping
from dataclasses import dataclass

from cryptography import x509
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.verification import PolicyBuilder, Store, VerificationError

from dray.adapters.security.certificates import agents_of
from dray.errors import SealError
from dray.messages.kinds import Kind
from dray.messages.speakers import kind_in

KNOWN = 1000
"""Certificates whose examination is remembered, and agents whose certificate is: three times those of a large plant.
Only what our authority has signed is remembered, so nobody fills it up."""


@dataclass(frozen=True, slots=True)
class Certified:
    """A certificate of our authority.

    Attributes:
        certificate: itself, in DER.
        key: of whoever has it.
        serial: the number by which it is called back.
        agents: for whom it speaks, and what they are.
        until_s: until when it is valid (unix time).
    """

    certificate: bytes
    key: ec.EllipticCurvePublicKey
    serial: int
    agents: Mapping[str, Kind]
    until_s: float


class Register:
    """Whose certificates are good. On any thread.

    Args:
        authorities: whom to trust.
        plant: the plant's id; certificates of other plants are worth nothing here.
        now_s: unix time.
        revoked: serial numbers of certificates that were called back; asked each time.
    """

    def __init__(
        self,
        authorities: list[x509.Certificate],
        plant: str,
        now_s: Callable[[], float],
        revoked: Container[int] = (),
    ) -> None:
        self._authorities, self._plant, self._now_s = authorities, plant, now_s
        self._revoked = revoked
        self._examined: dict[bytes, Certified] = {}
        self._agents: dict[str, tuple[int, bytes]] = {}
        """By agent, the certificate that its latest life has shown, and that life."""

    def certified(self, certificate: bytes, agent: str, data: bytes) -> tuple[Certified, Kind]:
        """A certificate that is good for `agent` now, and what the agent is.

        Args:
            certificate: in DER, as somebody has shown it.
            agent: who says to be its owner.
            data: what it came with, for the error.

        Raises:
            SealError: it is not.
        """
        certified = self._examined.get(certificate) or self._examine(certificate, data)
        kind = kind_in(agent, certified.agents)
        if kind is None:
            raise SealError(f"its certificate does not name {agent}", data)
        if certified.serial in self._revoked:
            raise SealError("its certificate was called back", data)
        if self._now_s() > certified.until_s:
            raise SealError("its certificate has expired", data)
        return certified, kind

    def meet(self, agent: str, life: int, certificate: bytes) -> None:
        """Note that this life of an agent has proved to have this certificate, which is good for it."""
        life_before, before = self._agents.get(agent, (life, b""))
        if certificate == before:
            self._agents[agent] = (max(life, life_before), certificate)
            return
        # What an earlier life has said may be said again by others. But a thief's life, however late, ends with
        # the certificate: else nobody could write to the agent whose certificate was renewed.
        if life < life_before and self.known(agent) is not None:
            return
        if len(self._agents) >= KNOWN and agent not in self._agents:
            del self._agents[next(iter(self._agents))]
        self._agents[agent] = (life, certificate)

    def has(self, agent: str, certificate: bytes) -> bool:
        """Whether an agent was met with this certificate last."""
        return self._agents.get(agent, (0, b""))[1] == certificate

    def known(self, agent: str) -> Certified | None:
        """The certificate of an agent that was met; None when it was not, or its certificate is not good any more."""
        _, certificate = self._agents.get(agent, (0, b""))
        try:
            return self.certified(certificate, agent, b"")[0] if certificate else None
        except SealError:
            return None

    def verify(self, certificate: x509.Certificate, at_s: float) -> None:
        """See that an authority that we trust has signed it, and that it is valid at that moment (unix time).

        Raises:
            VerificationError: it has not, or is not.
        """
        at = dt.datetime.fromtimestamp(at_s, dt.UTC)
        PolicyBuilder().store(Store(self._authorities)).time(at).build_client_verifier().verify(
            certificate, []
        )

    def _examine(self, certificate: bytes, data: bytes) -> Certified:
        try:
            loaded = x509.load_der_x509_certificate(certificate)
            self.verify(loaded, self._now_s())
        except (ValueError, VerificationError) as fault:
            raise SealError(f"its certificate: {fault}", data) from fault
        key = loaded.public_key()
        if not (isinstance(key, ec.EllipticCurvePublicKey) and isinstance(key.curve, ec.SECP256R1)):
            raise SealError("its certificate is for no key on P-256", data)
        agents, until_s = agents_of(loaded, self._plant), loaded.not_valid_after_utc.timestamp()
        certified = Certified(certificate, key, loaded.serial_number, agents, until_s)
        if len(self._examined) >= KNOWN:
            self._examined.clear()
        self._examined[certificate] = certified
        return certified

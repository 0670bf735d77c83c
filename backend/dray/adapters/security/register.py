"""The register: certificates that this process has verified, and the present one of each agent.

It begins empty and learns from others: each token and each message contains its agent's certificate.
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
"""Maximum verified certificates, and maximum agents with a known one: three times those of a large plant. Only certificates
of our authority are remembered, so strangers cannot fill it."""


@dataclass(frozen=True, slots=True)
class Certified:
    """A certificate of our authority.

    Attributes:
        certificate: the certificate, in DER.
        key: its public key.
        serial: the number by which it is revoked.
        agents: the agents it names, with their kinds.
        until_s: the end of its validity (unix time).
    """

    certificate: bytes
    key: ec.EllipticCurvePublicKey
    serial: int
    agents: Mapping[str, Kind]
    until_s: float


class Register:
    """Verifies certificates and remembers them by agent. Thread-safe.

    Args:
        authorities: the trusted authorities.
        plant: the plant's id; certificates of other plants are refused.
        now_s: unix time.
        revoked: serial numbers of revoked certificates; checked each time.
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
        """By agent, the latest life and its certificate."""

    def certified(self, certificate: bytes, agent: str, data: bytes) -> tuple[Certified, Kind]:
        """A certificate that is valid for `agent` now, and the agent's kind.

        Args:
            certificate: the certificate in DER.
            agent: the claimed owner.
            data: the message with it, for the error.

        Raises:
            SealError: it is not valid.
        """
        certified = self._examined.get(certificate) or self._examine(certificate, data)
        kind = kind_in(agent, certified.agents)
        if kind is None:
            raise SealError(f"its certificate does not name {agent}", data)
        if certified.serial in self._revoked:
            raise SealError("its certificate was revoked", data)
        if self._now_s() > certified.until_s:
            raise SealError("its certificate has expired", data)
        return certified, kind

    def meet(self, agent: str, life: int, certificate: bytes) -> None:
        """Note that this life of an agent has proved to own this valid certificate."""
        life_before, before = self._agents.get(agent, (life, b""))
        if certificate == before:
            self._agents[agent] = (max(life, life_before), certificate)
            return
        # Others may replay an earlier life's messages. But a thief's life, however late, ends with the certificate: otherwise
        # nobody could write to the agent after its certificate was renewed.
        if life < life_before and self.known(agent) is not None:
            return
        if len(self._agents) >= KNOWN and agent not in self._agents:
            del self._agents[next(iter(self._agents))]
        self._agents[agent] = (life, certificate)

    def has(self, agent: str, certificate: bytes) -> bool:
        """Whether an agent last used this certificate."""
        return self._agents.get(agent, (0, b""))[1] == certificate

    def known(self, agent: str) -> Certified | None:
        """The certificate of a known agent; None for an unknown one, or when its certificate is no longer valid."""
        _, certificate = self._agents.get(agent, (0, b""))
        try:
            return self.certified(certificate, agent, b"")[0] if certificate else None
        except SealError:
            return None

    def verify(self, certificate: x509.Certificate, at_s: float) -> None:
        """Check that a trusted authority has signed it, and that it is valid at that moment (unix time).

        Raises:
            VerificationError: one of these is not so.
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

"""Revoked certificates: a list that the authority signs, and that every process reads from a file.

The list is an X.509 CRL beside the authority's certificate. After a revocation an administrator copies that one file to all
computers; each process notices a changed file by itself. No message can revoke, so the mechanism also holds against a thief
of a gateway's certificate.
"""

from __future__ import annotations

import datetime as dt
import logging
import os
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path

from cryptography import x509
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import Encoding

from dray.adapters.security.certificates import AUTHORITY_DAYS, REVOKED, Authority, agents_of
from dray.errors import SettingsError

FILE = f"{REVOKED}.pem"
"""The file name of the list, in the folder of the certificates."""

LOOK_EVERY_S = 2.0
"""Seconds between checks whether the file has changed: one system call each."""

MAX_BYTES = 1_000_000
"""Maximum size of the file: some 15,000 certificates, more than a large plant issues in its authority's life."""

REASONS: Mapping[str, x509.ReasonFlags] = {
    "key-compromise": x509.ReasonFlags.key_compromise,
    "superseded": x509.ReasonFlags.superseded,
    "cessation-of-operation": x509.ReasonFlags.cessation_of_operation,
    "unspecified": x509.ReasonFlags.unspecified,
}
"""The reasons for a revocation, in the words of RFC 5280 (5.3.1)."""

log = logging.getLogger(__name__)


def call_back(authority: Authority, folder: Path, agent: str, reason: str) -> int:
    """Revoke every valid certificate that the authority has issued for an agent.

    Args:
        authority: the issuer.
        folder: the folder of the certificates; the list there is replaced by a longer one.
        agent: its id. A certificate for several agents is revoked for all of them.
        reason: one of `REASONS`.

    Returns:
        The number of newly revoked certificates.

    Raises:
        SettingsError: no certificate of the agent is known, or the list cannot be used.
    """
    file = folder / FILE
    before = _read(file, [authority.certificate]) if file.exists() else None
    known = frozenset(each.serial_number for each in before or ())
    wanted = set(_of_agent(authority, folder, agent))
    if not wanted:
        raise SettingsError(
            agent, f"{folder} knows of no certificate for it; call it back where it was issued"
        )
    fresh = sorted(wanted - known)
    if fresh:
        _replace(file, _longer(authority, before, fresh, REASONS[reason]))
    return len(fresh)


class Revocations:
    """The revoked certificates, as one process knows them. Thread-safe.

    Args:
        file: the list, which may be missing.
        authorities: the accepted signers of the list.
        own: the serial number of the process's own certificate.
        clock_s: a monotonic clock, for tests.

    Raises:
        SettingsError: the file exists, but contains no list of these authorities.
    """

    def __init__(
        self,
        file: Path,
        authorities: Iterable[x509.Certificate],
        own: int,
        *,
        clock_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._file, self._authorities, self._own, self._clock_s = file, tuple(authorities), own, clock_s
        self._lock = threading.Lock()
        self._looked_s = clock_s()
        self._known: frozenset[int] = frozenset()
        self._number = -1
        self._mark = self._marked()
        if self._mark is not None:
            self._take(_read(file, self._authorities))

    def __contains__(self, serial: object) -> bool:
        """Whether the certificate with this serial number is revoked."""
        if self._clock_s() - self._looked_s >= LOOK_EVERY_S and self._lock.acquire(blocking=False):
            try:
                self._looked_s = self._clock_s()
                self._look()
            finally:
                self._lock.release()
        return serial in self._known

    def _look(self) -> None:
        """Read a changed file; an unusable or missing one keeps all revocations."""
        mark = self._marked()
        if mark == self._mark:
            return
        self._mark = mark
        if mark is None:
            log.warning("%s is gone: what was revoked stays so", self._file)
            return
        try:
            self._take(_read(self._file, self._authorities))
        except SettingsError as error:
            log.warning("%s; what was revoked before stays so", error)
        if self._own in self._known:
            log.error(
                "this process's certificate was revoked: nobody hears it; `dray certs issue`, and restart it"
            )

    def _marked(self) -> tuple[int, int, int] | None:
        """A mark of the file's state, which changes with it; None when it is missing."""
        try:
            found = self._file.stat()
        except OSError:
            return None
        return found.st_mtime_ns, found.st_size, found.st_ino

    def _take(self, revoked: x509.CertificateRevocationList) -> None:
        number = _number_of(revoked)
        if number < self._number:
            log.warning("%s is an older list than the one before, and is not used: copy it anew", self._file)
            return
        self._number, self._known = number, frozenset(each.serial_number for each in revoked)


def _of_agent(authority: Authority, folder: Path, agent: str) -> Iterator[int]:
    """The serial numbers of an agent's unexpired certificates."""
    now_s = time.time()
    for each in authority.issued(folder):
        if agent in each.agents and each.until_s > now_s:
            yield int(each.serial, 16)
    try:
        present = x509.load_pem_x509_certificate((folder / f"{agent}.pem").read_bytes())
        present.verify_directly_issued_by(authority.certificate)
    except (OSError, ValueError, TypeError, InvalidSignature):
        return  # no file, or another owner's
    if agent in agents_of(present, authority.plant) or not authority.plant:
        yield present.serial_number


def _longer(
    authority: Authority,
    before: x509.CertificateRevocationList | None,
    serials: Iterable[int],
    reason: x509.ReasonFlags,
) -> bytes:
    """The list with added certificates, as PEM."""
    now = dt.datetime.now(dt.UTC)
    number = 1 if before is None else _number_of(before) + 1
    key = x509.AuthorityKeyIdentifier.from_issuer_public_key(authority.key.public_key())
    builder = (
        x509.CertificateRevocationListBuilder()
        .issuer_name(authority.certificate.subject)
        .last_update(now)
        # No list expires: a computer without the newest copy still uses the older one.
        .next_update(now + dt.timedelta(days=AUTHORITY_DAYS))
        .add_extension(x509.CRLNumber(number), critical=False)
        .add_extension(key, critical=False)
    )
    for known in before or ():
        builder = builder.add_revoked_certificate(known)
    for serial in serials:
        fresh = x509.RevokedCertificateBuilder().serial_number(serial).revocation_date(now)
        if reason is not x509.ReasonFlags.unspecified:
            fresh = fresh.add_extension(x509.CRLReason(reason), critical=False)
        builder = builder.add_revoked_certificate(fresh.build())
    return builder.sign(authority.key, hashes.SHA256()).public_bytes(Encoding.PEM)


def _read(file: Path, authorities: Iterable[x509.Certificate]) -> x509.CertificateRevocationList:
    """Read a list that one of these authorities has signed.

    Raises:
        SettingsError: reading failed, or it is no such list.
    """
    remedy = f"copy {FILE} anew from where `dray certs revoke` has written it"
    try:
        with file.open("rb") as opened:
            data = opened.read(MAX_BYTES + 1)
        if len(data) > MAX_BYTES:
            raise SettingsError(str(file), f"has more than {MAX_BYTES} bytes; {remedy}")
        found = x509.load_pem_x509_crl(data)
    except (OSError, ValueError) as error:
        raise SettingsError(str(file), f"holds no list of certificates: {error}; {remedy}") from None
    for authority in authorities:
        key = authority.public_key()
        if isinstance(key, ec.EllipticCurvePublicKey) and found.is_signature_valid(key):
            return found
    raise SettingsError(str(file), f"is not signed by the authority of these certificates; {remedy}")


def _number_of(revoked: x509.CertificateRevocationList) -> int:
    try:
        return revoked.extensions.get_extension_for_class(x509.CRLNumber).value.crl_number
    except (x509.ExtensionNotFound, ValueError):
        return 0


def _replace(file: Path, data: bytes) -> None:
    """Replace a file atomically: concurrent readers find the old one or the new one."""
    fresh = file.with_name(f"{file.name}.new")
    with fresh.open("wb") as opened:
        opened.write(data)
        opened.flush()
        os.fsync(opened.fileno())
    fresh.replace(file)

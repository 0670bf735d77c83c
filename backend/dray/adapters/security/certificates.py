"""Certificates: an authority for one plant, and the identities that it certifies.

A certificate names agents, each as the URI ``dray:{plant}/{kind}/{agent}`` in its alternative names. A process with
several agents has one certificate that names them all. Keys are P-256, which is fast in TLS and in signatures of
single messages.
"""

from __future__ import annotations

import datetime as dt
import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import msgspec
from cryptography import x509
from cryptography.exceptions import UnsupportedAlgorithm
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from dray.errors import SettingsError
from dray.messages.kinds import Kind
from dray.plant.model import ID_RULE, is_id

AUTHORITY = "authority"
"""The name of the authority's files."""

REVOKED = "revoked"
"""The name of the list of revoked certificates (`dray.adapters.security.revocations`)."""

ISSUED = f"{AUTHORITY}.issued"
"""The file beside the authority's key with a line of JSON for each issued certificate."""

AUTHORITY_DAYS = 3650
"""Validity in days: as long as a plant's control computers are in service."""

DAYS = 397
"""Validity in days: a year and a month, so that a yearly renewal is never late. It also limits the use of lost keys."""

CLOCKS_APART = dt.timedelta(hours=1)
"""Start of validity before the time of issue: a computer's first clock may be wrong."""

_KINDS = frozenset[str](Kind)

_URI = re.compile(r"dray:([^/]+)/([^/]+)/([^/]+)")

_OF = "Dray authority of "
"""The prefix of the plant's id in an authority's name."""


class Issued(msgspec.Struct, frozen=True):
    """One issued certificate in the authority's records, so that it can be revoked without its file."""

    serial: str
    """The serial number in hexadecimal: it has 160 bits."""
    agents: tuple[str, ...]
    until_s: float
    """The end of its validity (unix time)."""


@dataclass(frozen=True, slots=True)
class Authority:
    """The signer of a plant's certificates. Its key belongs on no computer of the plant.

    Attributes:
        certificate: the public part, which all agents must know.
        key: the private key, which must stay secret.
    """

    certificate: x509.Certificate
    key: ec.EllipticCurvePrivateKey

    @classmethod
    def make(cls, plant: str) -> Authority:
        """Create a new authority."""
        key = ec.generate_private_key(ec.SECP256R1())
        name = _name(_OF + plant)
        builder = (
            _builder(name, name, key.public_key(), AUTHORITY_DAYS)
            .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
            .add_extension(_usage(signs_certificates=True), critical=True)
            .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
        )
        return cls(builder.sign(key, hashes.SHA256()), key)

    @classmethod
    def load(cls, folder: Path) -> Authority:
        """Read an authority from its files.

        Raises:
            SettingsError: the files are missing, or contain something else.
        """
        certificate, key = (_read(folder / f"{AUTHORITY}.{end}") for end in ("pem", "key"))
        try:
            return cls(x509.load_pem_x509_certificate(certificate), read_key(key))
        except ValueError as error:
            raise SettingsError(str(folder), f"holds no authority of ours: {error}") from None

    @property
    def plant(self) -> str:
        """The plant's id in its certificate; empty for an authority of other origin."""
        for each in self.certificate.subject.get_attributes_for_oid(NameOID.COMMON_NAME):
            name = str(each.value)
            if name.startswith(_OF):
                return name.removeprefix(_OF)
        return ""

    def write(self, folder: Path) -> None:
        """Write both files into `folder`, which is created if missing."""
        folder.mkdir(parents=True, exist_ok=True)
        _write(folder, AUTHORITY, self.certificate, self.key)

    def issue(self, folder: Path, plant: str, agents: Mapping[str, Kind], *, days: int = DAYS) -> None:
        """Write a certificate and its key into `folder`, named by the first agent.

        Args:
            folder: an existing folder.
            plant: the plant's id.
            agents: the agents that the process may speak for; not empty.
            days: the validity in days.

        Raises:
            SettingsError: an agent's name is not allowed.
        """
        for name in agents:
            _check_name(name)
        first = next(iter(agents))
        key = ec.generate_private_key(ec.SECP256R1())
        names = [
            x509.UniformResourceIdentifier(f"dray:{plant}/{kind}/{name}") for name, kind in agents.items()
        ]
        issuer = x509.AuthorityKeyIdentifier.from_issuer_public_key(self.key.public_key())
        usages = [ExtendedKeyUsageOID.SERVER_AUTH, ExtendedKeyUsageOID.CLIENT_AUTH]
        builder = (
            _builder(_name(first), self.certificate.subject, key.public_key(), days)
            .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
            .add_extension(_usage(signs_certificates=False), critical=True)
            .add_extension(x509.ExtendedKeyUsage(usages), critical=False)
            .add_extension(x509.SubjectAlternativeName(names), critical=False)
            .add_extension(issuer, critical=False)
        )
        made = builder.sign(self.key, hashes.SHA256())
        _write(folder, first, made, key)
        note = Issued(f"{made.serial_number:x}", tuple(agents), made.not_valid_after_utc.timestamp())
        with (folder / ISSUED).open("ab") as notes:
            notes.write(msgspec.json.encode(note) + b"\n")

    def issued(self, folder: Path) -> Iterator[Issued]:
        """The certificates issued in this folder; incomplete lines are skipped."""
        try:
            lines = (folder / ISSUED).read_bytes().splitlines()
        except OSError:
            return
        for line in lines:
            with suppress(msgspec.MsgspecError):
                yield msgspec.json.decode(line, type=Issued)


def read_key(pem: bytes) -> ec.EllipticCurvePrivateKey:
    """Read a private key.

    Raises:
        ValueError: it is not a P-256 key.
    """
    try:
        key = serialization.load_pem_private_key(pem, password=None)
    except TypeError:
        raise ValueError("the key is encrypted; store it without a password, for its owner alone") from None
    except UnsupportedAlgorithm as error:
        raise ValueError(str(error)) from None
    if isinstance(key, ec.EllipticCurvePrivateKey):
        return key
    raise ValueError("no key on an elliptic curve")


def agents_of(certificate: x509.Certificate, plant: str) -> dict[str, Kind]:
    """The agents that a certificate names in this plant, with their kinds."""
    try:
        names = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except x509.ExtensionNotFound:
        return {}
    found: dict[str, Kind] = {}
    for uri in names.get_values_for_type(x509.UniformResourceIdentifier):
        match = _URI.fullmatch(uri)
        if match and match[1] == plant and match[2] in _KINDS:
            found[match[3]] = Kind(match[2])
    return found


def _check_name(agent: str) -> None:
    """Refuse names that no agent may have, and those that would overwrite the authority's files."""
    if not is_id(agent):
        raise SettingsError(repr(agent), f"is no id of an agent; {ID_RULE}")
    # Some file systems ignore the case of letters.
    if agent.lower() in {AUTHORITY, REVOKED}:
        raise SettingsError(agent, "is the name of the authority's own files; give the agent another id")


def _name(text: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, text)])


def _builder(
    subject: x509.Name, issuer: x509.Name, key: ec.EllipticCurvePublicKey, days: int
) -> x509.CertificateBuilder:
    now = dt.datetime.now(dt.UTC)
    return (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(issuer)
        .public_key(key)
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - CLOCKS_APART)
        .not_valid_after(now + dt.timedelta(days=days))
    )


def _usage(*, signs_certificates: bool) -> x509.KeyUsage:
    return x509.KeyUsage(
        digital_signature=not signs_certificates,
        content_commitment=False,
        key_encipherment=False,
        data_encipherment=False,
        key_agreement=not signs_certificates,
        key_cert_sign=signs_certificates,
        crl_sign=signs_certificates,
        encipher_only=False,
        decipher_only=False,
    )


def _read(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as error:
        raise SettingsError(str(file), f"{error.strerror}; `dray certs make` makes an authority") from None


def _write(folder: Path, name: str, certificate: x509.Certificate, key: ec.EllipticCurvePrivateKey) -> None:
    secret = folder / f"{name}.key"
    # No other user may read it, not even for an instant.
    secret.unlink(missing_ok=True)
    secret.touch(mode=0o600)
    secret.write_bytes(
        key.private_bytes(
            serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
        )
    )
    (folder / f"{name}.pem").write_bytes(certificate.public_bytes(serialization.Encoding.PEM))

"""Certificates: checks that every process of the plant has one of the plant's authority that is valid for long enough."""

from __future__ import annotations

import time
from collections.abc import Mapping
from pathlib import Path

from cryptography import x509
from cryptography.exceptions import InvalidSignature

from dray.adapters.security.certificates import AUTHORITY, agents_of
from dray.adapters.security.revocations import FILE, Revocations
from dray.cli.runtime.ready.finding import Finding, missing, named, ok
from dray.errors import SettingsError
from dray.messages.kinds import Kind
from dray.settings import Settings

SOON_DAYS = 30
"""Remaining validity in days below which to renew a certificate, as in the alert of Prometheus."""

NAME = "certificates"


def certificates(
    plant: str,
    wanted: Mapping[str, Mapping[str, Kind]],
    settings: Settings,
    folder: Path | None,
    now_s: float,
) -> Finding:
    """Whether all certificates are there.

    Args:
        plant: its id.
        wanted: the agents of each process, by the name of its certificate.
        settings: whether links have certificates at all.
        folder: the folder of their creation; None for that of the settings.
        now_s: unix time.
    """
    chosen = folder or settings.bus_certificates
    if chosen is None:
        if settings.bus_plain:
            seen = "DRAY_BUS_PLAIN: anybody on the network can read and forge messages"
            return ok(NAME, seen, "dray certs make certs --plant FILE")
        return missing(NAME, "no folder is named", "dray certs make certs --plant FILE; --certificates certs")
    try:
        authorities = x509.load_pem_x509_certificates((chosen / f"{AUTHORITY}.pem").read_bytes())
        revoked = Revocations(chosen / FILE, authorities, 0, clock_s=time.monotonic)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        seen = f"{chosen / AUTHORITY}.pem: {reason}"
        return missing(NAME, seen, f"dray certs make {chosen} --plant FILE")
    except SettingsError as error:
        return missing(NAME, str(error), f"copy {FILE} anew from where `dray certs revoke` has written it")
    faults: dict[str, list[str]] = {}
    ends_s = min(each.not_valid_after_utc.timestamp() for each in authorities)
    if ends_s < now_s + SOON_DAYS * 86_400:
        faults[f"expired, or expires within {SOON_DAYS} days"] = [AUTHORITY]
    for name, agents in wanted.items():
        fault, until_s = _examine(chosen, name, plant, agents, authorities, revoked, now_s)
        if fault:
            faults.setdefault(fault, []).append(name)
        ends_s = min(ends_s, until_s)
    if not faults:
        days = int((ends_s - now_s) // 86_400)
        return ok(NAME, f"{chosen}: all {len(wanted)} are there; the first expires in {days} days")
    first = next(name for names in faults.values() for name in names)
    kind = next(iter(wanted.get(first, {}).values()), None)
    todo = (
        "dray certs make FOLDER --plant FILE" if kind is None else f"dray certs issue {chosen} {kind} {first}"
    )
    return missing(
        NAME,
        "; ".join(f"{fault}: {named(names)}" for fault, names in faults.items()),
        f"{todo}, for each; copy it to its computer",
    )


def _examine(
    folder: Path,
    name: str,
    plant: str,
    agents: Mapping[str, Kind],
    authorities: list[x509.Certificate],
    revoked: Revocations,
    now_s: float,
) -> tuple[str, float]:
    """The fault of one process's certificate, empty for none; and the end of its validity (unix time, infinite without one)."""
    never = float("inf")
    try:
        found = x509.load_pem_x509_certificate((folder / f"{name}.pem").read_bytes())
    except FileNotFoundError:
        return "missing for", never
    except (OSError, ValueError):
        return "cannot be read", never
    until_s = found.not_valid_after_utc.timestamp()
    if not any(_signed(found, authority) for authority in authorities):
        return "of another authority", until_s
    if not agents.items() <= agents_of(found, plant).items():
        return f"not for this agent of {plant}", until_s
    if found.serial_number in revoked:
        return "revoked", until_s
    if until_s < now_s:
        return "expired", until_s
    if until_s < now_s + SOON_DAYS * 86_400:
        return f"expires within {SOON_DAYS} days", until_s
    if not (folder / f"{name}.key").is_file():
        return "without a key file", until_s
    return "", until_s


def _signed(found: x509.Certificate, authority: x509.Certificate) -> bool:
    try:
        found.verify_directly_issued_by(authority)
    except (ValueError, TypeError, InvalidSignature):
        return False
    return True

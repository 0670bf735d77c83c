"""What `dray plant ready` finds of certificates."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from ready_kit import DAY_S, NOW_S, WORKSHOP, seen

from dray.adapters.security.certificates import Authority
from dray.adapters.security.revocations import call_back
from dray.cli.runtime.ready.certificates import certificates
from dray.cli.runtime.ready.finding import Finding, Verdict
from dray.cli.runtime.roster import certified_of
from dray.messages.kinds import Kind
from dray.settings import Settings

WANTED = certified_of(WORKSHOP, ("strategist",), "gateway")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """The certificates of the workshop, made now."""
    authority = Authority.make(WORKSHOP.id)
    authority.write(tmp_path)
    for each in WANTED.values():
        authority.issue(tmp_path, WORKSHOP.id, each)
    return tmp_path


def certified(folder: Path | None, now_s: float, **fields: Any) -> Finding:
    return certificates(WORKSHOP.id, WANTED, Settings.load(**fields), folder, now_s)


@pytest.fixture
def made_s(folder: Path) -> float:
    """When they were made, to the second: they end 397 days later."""
    return Authority.load(folder).certificate.not_valid_before_utc.timestamp() + 3600.0


def test_certificates_of_all_processes_are_good_until_a_month_before_their_end(
    folder: Path, made_s: float
) -> None:
    found = certified(folder, made_s + 365 * DAY_S)
    assert seen(found, Verdict.OK, f"all {len(WANTED)} are there")
    assert seen(certified(None, made_s, bus_certificates=folder), Verdict.OK, "all")
    assert seen(certified(folder, made_s + 368 * DAY_S), Verdict.MISSING, "expires within 30 days")
    assert seen(certified(folder, made_s + 398 * DAY_S), Verdict.MISSING, "expired")


def _remove(folder: Path) -> None:
    (folder / "SAW.pem").unlink()


def _spoil(folder: Path) -> None:
    (folder / "SAW.pem").write_text("no certificate")


def _lose_key(folder: Path) -> None:
    (folder / "SAW.key").unlink()


def _of_another_authority(folder: Path) -> None:
    Authority.make(WORKSHOP.id).issue(folder, WORKSHOP.id, {"SAW": Kind.MACHINE})


def _of_another_plant(folder: Path) -> None:
    Authority.load(folder).issue(folder, "elsewhere", {"SAW": Kind.MACHINE})


def _of_another_kind(folder: Path) -> None:
    Authority.load(folder).issue(folder, WORKSHOP.id, {"SAW": Kind.ATV})


def _call_back(folder: Path) -> None:
    call_back(Authority.load(folder), folder, "SAW", "key-compromise")


@pytest.mark.parametrize(
    ("do", "said"),
    [
        (_remove, "missing for: SAW"),
        (_spoil, "cannot be read: SAW"),
        (_lose_key, "without a key file: SAW"),
        (_of_another_authority, "of another authority: SAW"),
        (_of_another_plant, f"not for this agent of {WORKSHOP.id}: SAW"),
        (_of_another_kind, f"not for this agent of {WORKSHOP.id}: SAW"),
        (_call_back, "revoked: SAW"),
    ],
)
def test_what_is_wrong_with_a_certificate_is_said(
    folder: Path, made_s: float, do: Callable[[Path], None], said: str
) -> None:
    do(folder)
    found = certified(folder, made_s)
    assert (found.verdict, found.seen) == (Verdict.MISSING, said)
    assert f"dray certs issue {folder} machine SAW" in found.todo


def test_without_certificates_links_are_said_to_be_plain_or_something_is_missing(tmp_path: Path) -> None:
    assert seen(certified(None, NOW_S, bus_plain=True), Verdict.OK, "forge messages")
    assert seen(certified(None, NOW_S), Verdict.MISSING, "no folder")
    assert seen(certified(tmp_path, NOW_S), Verdict.MISSING, "authority.pem: No such file")
    (tmp_path / "authority.pem").write_text("no certificate")
    assert certified(tmp_path, NOW_S).verdict is Verdict.MISSING

"""Certificates that were revoked: believed by nobody who has the list, from the moment it is copied."""

from __future__ import annotations

import logging
import os
from pathlib import Path

import pytest
from cryptography import x509
from issued import issued

from dray.adapters.security.certificates import ISSUED, Authority
from dray.adapters.security.identity import Identity
from dray.adapters.security.revocations import FILE, LOOK_EVERY_S, Revocations, call_back
from dray.adapters.security.seals import Seals
from dray.errors import SealError, SettingsError
from dray.messages.kinds import Kind


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Certificates of a plant `p`."""
    return issued(tmp_path / "certs", {"M1": Kind.MACHINE, "ATV1": Kind.ATV, "gateway": Kind.GATEWAY})


class Clock:
    def __init__(self) -> None:
        self.now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


def seals(folder: Path, agent: str) -> Seals:
    return Seals(Identity.in_folder(folder, agent), "p")


def revoke(folder: Path, agent: str) -> int:
    return call_back(Authority.load(folder), folder, agent, "key-compromise")


def serial(folder: Path, agent: str) -> int:
    return x509.load_pem_x509_certificate((folder / f"{agent}.pem").read_bytes()).serial_number


def list_of(folder: Path, clock: Clock | None = None) -> Revocations:
    authority = Authority.load(folder).certificate
    return Revocations(folder / FILE, [authority], 1, clock_s=clock or Clock())


def hears(listener: Seals, speaker: Seals, name: str) -> bool:
    try:
        listener.examine(speaker.seal("p/k", 1, 1, b"said"), name, "p/k", 1, 1, b"said")
    except SealError as refused:
        return "revoked" not in str(refused)
    return True


def test_a_certificate_that_was_called_back_is_refused_and_all_others_are_not(folder: Path) -> None:
    thief, machine = seals(folder, "ATV1"), seals(folder, "M1")
    assert revoke(folder, "ATV1") == 1
    listener = seals(folder, "gateway")
    assert not hears(listener, thief, "ATV1")
    assert hears(listener, machine, "M1")


def test_a_running_process_notices_the_list_that_is_copied_to_it(folder: Path) -> None:
    clock = Clock()
    thief, listener = seals(folder, "ATV1"), Seals(Identity.in_folder(folder, "gateway"), "p", clock_s=clock)
    assert hears(listener, thief, "ATV1")
    revoke(folder, "ATV1")
    assert hears(listener, thief, "ATV1"), (
        "the file is looked at from time to time, and not with every message"
    )
    clock.now_s += LOOK_EVERY_S
    assert not hears(listener, thief, "ATV1"), "though it was examined and found good before"


def test_a_certificate_that_is_issued_afterwards_is_good(folder: Path) -> None:
    revoke(folder, "ATV1")
    Authority.load(folder).issue(folder, "p", {"ATV1": Kind.ATV})
    assert hears(seals(folder, "gateway"), seals(folder, "ATV1"), "ATV1")


def test_a_thief_who_claims_the_latest_life_keeps_nobody_from_writing_to_the_renewed_agent(
    folder: Path,
) -> None:
    clock, huge = Clock(), 10**15
    thief = seals(folder, "ATV1")
    writer = Seals(Identity.in_folder(folder, "gateway"), "p", clock_s=clock)
    writer.examine(thief.seal("p/k", huge, 1, b"said"), "ATV1", "p/k", huge, 1, b"said")
    revoke(folder, "ATV1")
    Authority.load(folder).issue(folder, "p", {"ATV1": Kind.ATV})
    clock.now_s += LOOK_EVERY_S
    assert writer.register.known("ATV1") is None, "nothing is written that the thief could read"
    renewed = seals(folder, "ATV1")
    writer.examine(renewed.seal("p/k", 8, 1, b"said"), "ATV1", "p/k", 8, 1, b"said")
    known = writer.register.known("ATV1")
    assert known is not None
    assert known.certificate == renewed.certificate


def test_older_certificates_of_the_agent_are_called_back_too_though_their_files_are_gone(
    folder: Path,
) -> None:
    stolen = seals(folder, "ATV1")
    Authority.load(folder).issue(folder, "p", {"ATV1": Kind.ATV})
    assert revoke(folder, "ATV1") == 2
    assert not hears(seals(folder, "gateway"), stolen, "ATV1")


def test_a_folder_of_an_older_dray_knows_the_certificate_that_lies_there(folder: Path) -> None:
    (folder / ISSUED).unlink()
    assert revoke(folder, "ATV1") == 1
    assert serial(folder, "ATV1") in list_of(folder)


def test_the_list_grows_and_loses_nothing(folder: Path) -> None:
    assert revoke(folder, "ATV1") == 1
    assert revoke(folder, "ATV1") == 0
    assert revoke(folder, "M1") == 1
    known = list_of(folder)
    assert serial(folder, "ATV1") in known
    assert serial(folder, "M1") in known
    assert serial(folder, "gateway") not in known


def test_any_tool_can_read_the_list_and_its_reasons(folder: Path) -> None:
    revoke(folder, "ATV1")
    (entry,) = x509.load_pem_x509_crl((folder / FILE).read_bytes())
    reason = entry.extensions.get_extension_for_class(x509.CRLReason).value.reason
    assert reason is x509.ReasonFlags.key_compromise


def test_a_process_whose_own_certificate_was_called_back_does_not_begin(folder: Path) -> None:
    revoke(folder, "ATV1")
    with pytest.raises(SettingsError, match="was revoked"):
        seals(folder, "ATV1")


def test_a_process_whose_certificate_is_called_back_while_it_runs_says_so(
    folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    clock = Clock()
    authority = Authority.load(folder).certificate
    own = serial(folder, "ATV1")
    known = Revocations(folder / FILE, [authority], own, clock_s=clock)
    revoke(folder, "ATV1")
    clock.now_s += LOOK_EVERY_S
    with caplog.at_level(logging.ERROR):
        assert own in known
    assert "this process's certificate was revoked" in caplog.text


def test_an_agent_of_whom_nothing_was_issued_is_named(folder: Path) -> None:
    with pytest.raises(SettingsError, match="knows of no certificate"):
        revoke(folder, "ATV9")
    assert not (folder / FILE).exists()


def test_no_agent_may_have_the_name_of_the_list(folder: Path) -> None:
    with pytest.raises(SettingsError, match="authority's own files"):
        Authority.load(folder).issue(folder, "p", {"Revoked": Kind.ATV})


# --- files that are wrong --------------------------------------------------------------------------


def stranger(tmp_path: Path) -> Path:
    """The folder of an authority that nobody here trusts, with a list of its own."""
    made = tmp_path / "stranger"
    authority = Authority.make("p")
    authority.write(made)
    authority.issue(made, "p", {"M1": Kind.MACHINE})
    call_back(authority, made, "M1", "superseded")
    return made


def wrong(kind: str, folder: Path, tmp_path: Path) -> bytes:
    good = (folder / FILE).read_bytes()
    return {
        "empty": b"",
        "torn": good[: len(good) // 2],
        "flipped": good[:120] + bytes([good[120] ^ 1]) + good[121:],
        "huge": b"x" * 1_000_001,
        "foreign": (stranger(tmp_path) / FILE).read_bytes(),
    }[kind]


every_wrong = pytest.mark.parametrize("kind", ["empty", "torn", "flipped", "huge", "foreign"])


@every_wrong
def test_a_list_that_cannot_be_believed_keeps_a_process_from_beginning(
    folder: Path, tmp_path: Path, kind: str
) -> None:
    revoke(folder, "ATV1")
    (folder / FILE).write_bytes(wrong(kind, folder, tmp_path))
    with pytest.raises(SettingsError, match=r"revoked\.pem"):
        seals(folder, "gateway")


@every_wrong
def test_a_list_that_goes_bad_takes_nothing_back(
    folder: Path, tmp_path: Path, kind: str, caplog: pytest.LogCaptureFixture
) -> None:
    revoke(folder, "ATV1")
    clock = Clock()
    known = list_of(folder, clock)
    (folder / FILE).write_bytes(wrong(kind, folder, tmp_path))
    clock.now_s += LOOK_EVERY_S
    with caplog.at_level(logging.WARNING):
        assert serial(folder, "ATV1") in known
    assert FILE in caplog.text


def test_an_older_copy_and_a_lost_file_take_nothing_back(
    folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    revoke(folder, "ATV1")
    older = (folder / FILE).read_bytes()
    revoke(folder, "M1")
    clock = Clock()
    known = list_of(folder, clock)
    with caplog.at_level(logging.WARNING):
        (folder / FILE).write_bytes(older)
        os.utime(folder / FILE, ns=(1, 1))
        clock.now_s += LOOK_EVERY_S
        assert serial(folder, "M1") in known
        (folder / FILE).unlink()
        clock.now_s += LOOK_EVERY_S
        assert serial(folder, "M1") in known
    assert "older list" in caplog.text
    assert "is gone" in caplog.text

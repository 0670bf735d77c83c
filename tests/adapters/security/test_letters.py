"""Letters: what is said to one agent alone is read by that agent alone, and only where it was written to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import msgspec
import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.ciphers.aead import AESGCM
from cryptography.hazmat.primitives.kdf.hkdf import HKDF
from issued import issued

from dray.adapters.security import letters as module
from dray.adapters.security.certificates import Authority
from dray.adapters.security.identity import Identity
from dray.adapters.security.letters import Letters, Place
from dray.adapters.security.register import KNOWN, Register
from dray.adapters.security.seals import FRESH_S, Seals
from dray.errors import SealError
from dray.messages.kinds import Kind

AGENTS: Mapping[str, Kind] = {"ATV1": Kind.ATV, "ATV2": Kind.ATV, "M1": Kind.MACHINE}
HERE = Place("M1", life=3, number=7)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return issued(tmp_path_factory.mktemp("certificates"), AGENTS)


def seals(folder: Path, agent: str, apart_s: float = 0.0, plant: str = "p") -> Seals:
    """Of an agent that has met all others, and whose clock is so far from theirs."""
    now_s = (folder / "M1.pem").stat().st_mtime + apart_s
    made = Seals(Identity.in_folder(folder, agent), plant, now_s=lambda: now_s)
    for other in AGENTS:
        made.register.meet(other, 1, Seals(Identity.in_folder(folder, other), "p").certificate)
    return made


def written(folder: Path, place: Place = HERE) -> tuple[bytes, bytes]:
    letter = Letters(seals(folder, "ATV1")).write("ATV1", place, b"words")
    assert letter is not None
    return letter


def test_a_letter_says_who_has_written_it_and_what_he_is(folder: Path) -> None:
    letter, seal = written(folder)
    assert b"words" not in letter
    assert Letters(seals(folder, "M1")).read(seal, HERE, letter) == ("ATV1", Kind.ATV, b"words")


@pytest.mark.parametrize("reader", ["ATV2", "ATV1"])
def test_nobody_else_can_open_it(folder: Path, reader: str) -> None:
    letter, seal = written(folder)
    for place in (HERE, replace(HERE, reader=reader)):
        with pytest.raises(SealError, match="cannot be opened"):
            Letters(seals(folder, reader)).read(seal, place, letter)


@pytest.mark.parametrize(
    "place",
    [replace(HERE, life=4), replace(HERE, number=8), replace(HERE, reader="ATV2")],
    ids=["life", "number", "reader"],
)
def test_a_letter_is_good_for_no_other_place(folder: Path, place: Place) -> None:
    letter, seal = written(folder)
    with pytest.raises(SealError):
        Letters(seals(folder, "M1")).read(seal, place, letter)


@pytest.mark.parametrize("seal", [b"", b"\xc1", b"\x94\xc4\x01x\xa1x\x00\xc4\x01y", b"\x90"])
def test_bytes_that_are_no_seal_of_a_letter_are_refused(folder: Path, seal: bytes) -> None:
    with pytest.raises(SealError):
        Letters(seals(folder, "M1")).read(seal, HERE, written(folder)[0])


@pytest.mark.parametrize("letter", [b"", b"short", b"x" * 40])
def test_bytes_that_are_no_letter_are_refused(folder: Path, letter: bytes) -> None:
    with pytest.raises(SealError, match="cannot be opened"):
        Letters(seals(folder, "M1")).read(written(folder)[1], HERE, letter)


@pytest.mark.parametrize("later_s", [FRESH_S + 1, -FRESH_S - 1])
def test_a_letter_of_long_ago_is_not_read_again(folder: Path, later_s: float) -> None:
    letter, seal = written(folder)
    with pytest.raises(SealError, match="ago"):
        Letters(seals(folder, "M1", later_s)).read(seal, HERE, letter)


@pytest.mark.parametrize("moment", [1e12, float("nan"), -1, 2**53 + 1, "now"])
def test_a_moment_is_a_whole_number_of_milliseconds(folder: Path, moment: object) -> None:
    letter, seal = written(folder)
    certificate, sender, _, nonce = msgspec.msgpack.decode(seal)
    with pytest.raises(SealError, match="no letter's seal"):
        Letters(seals(folder, "M1")).read(
            msgspec.msgpack.encode((certificate, sender, moment, nonce)), HERE, letter
        )


def test_a_letter_is_opened_by_what_is_written_of_its_form(folder: Path) -> None:
    """`docs/agents.md`, with a library of cryptography alone."""
    letter, seal = written(folder)
    certificate, sender, at_ms, nonce = msgspec.msgpack.decode(seal)
    assert type(at_ms) is int
    key = serialization.load_pem_private_key((folder / "M1.key").read_bytes(), None)
    other = x509.load_der_x509_certificate(certificate).public_key()
    assert isinstance(key, ec.EllipticCurvePrivateKey)
    assert isinstance(other, ec.EllipticCurvePublicKey)
    shared = key.exchange(ec.ECDH(), other)
    secret = HKDF(hashes.SHA256(), 32, salt=None, info=b"dray letter p ATV1 M1").derive(shared)
    assert sender == "ATV1"
    assert AESGCM(secret).decrypt(nonce, letter, f"M1 3 7 {at_ms}".encode()) == b"words"


def test_nothing_is_written_to_whom_nobody_has_met(folder: Path) -> None:
    assert Letters(seals(folder, "ATV1")).write("ATV1", replace(HERE, reader="M9"), b"words") is None


def test_the_secrets_that_are_kept_are_bounded(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "SECRETS", 2)
    letters = Letters(seals(folder, "ATV1"))
    for reader in (*AGENTS, *AGENTS):
        assert letters.write("ATV1", replace(HERE, reader=reader), b"words") is not None
    assert len(letters._secrets) <= 2


def test_what_an_earlier_life_has_shown_is_not_taken_again(tmp_path: Path) -> None:
    authority = Authority.make("p")
    authority.write(tmp_path)
    shown = []
    for _ in range(2):
        authority.issue(tmp_path, "p", {"ATV1": Kind.ATV})
        shown.append(Seals(Identity.in_folder(tmp_path, "ATV1"), "p"))
    old, new = (each.certificate for each in shown)
    register = shown[-1].register
    register.meet("ATV1", 5, new)
    register.meet("ATV1", 4, old)
    assert register._agents["ATV1"] == (5, new)


def test_the_agents_that_are_known_are_bounded(folder: Path) -> None:
    register = Register([], "p", lambda: 0.0)
    for number in range(KNOWN + 5):
        register.meet(f"A{number}", 1, b"certificate")
    assert len(register._agents) == KNOWN
    assert f"A{KNOWN + 4}" in register._agents

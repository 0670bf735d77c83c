"""Certificates and seals: who has said it is known, whoever has passed it on."""

from __future__ import annotations

import asyncio
import base64
from collections.abc import Mapping
from contextlib import closing
from pathlib import Path

import msgspec
import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec
from heartbeats import atv_heartbeat
from issued import issued
from prometheus_client import CollectorRegistry
from zenoh_kit import PATIENCE_S, Row, free_address

from dray.adapters.security.certificates import DAYS, Authority
from dray.adapters.security.identity import Identity
from dray.adapters.security.seals import FRESH_S, Seals
from dray.adapters.zenoh.bus import UNSEALED, ZenohBus
from dray.adapters.zenoh.links import Links
from dray.cli.runtime.telemetry.bus_meter import BusMeter
from dray.errors import SealError, SettingsError
from dray.messages import Handover, HandoverAccepted, Message
from dray.messages.kinds import Kind
from dray.messages.overtaken import OVERTAKES_S
from dray.messages.speakers import FOREIGN_KEY, FOREIGN_WORD

AGENTS: Mapping[str, Kind] = {"M1": Kind.MACHINE, "ATV1": Kind.ATV, "ATV2": Kind.ATV}
ACCEPTED = HandoverAccepted(task="M1-1", epoch=1)
HANDOVER = Handover(task="M1-1", epoch=1, quantity=4)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Certificates of a plant `p`, one for each agent."""
    return issued(tmp_path_factory.mktemp("certificates"), AGENTS)


@pytest.fixture(scope="module")
def stranger(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A certificate for M1 by an authority that nobody here trusts."""
    made = tmp_path_factory.mktemp("stranger")
    authority = Authority.make("p")
    authority.write(made)
    authority.issue(made, "p", {"M1": Kind.MACHINE})
    return made


def seals(folder: Path, agent: str, now_s: float | None = None) -> Seals:
    identity = Identity.in_folder(folder, agent)
    return Seals(identity, "p") if now_s is None else Seals(identity, "p", now_s=lambda: now_s)


# --- seals -----------------------------------------------------------------------------------------


def test_a_seal_says_who_has_spoken_and_what_he_is(folder: Path) -> None:
    seal = seals(folder, "M1").seal("p/k", 1, 2, b"said")
    assert seals(folder, "ATV1").examine(seal, "M1", "p/k", 1, 2, b"said") is Kind.MACHINE


@pytest.mark.parametrize(
    ("sender", "key", "life", "number", "data"),
    [
        ("ATV1", "p/k", 1, 2, b"said"),
        ("M1", "p/other", 1, 2, b"said"),
        ("M1", "p/k", 2, 2, b"said"),
        ("M1", "p/k", 1, 3, b"said"),
        ("M1", "p/k", 1, 2, b"Said"),
    ],
    ids=["sender", "key", "life", "number", "words"],
)
def test_a_seal_fits_nothing_but_what_was_sealed(
    folder: Path, sender: str, key: str, life: int, number: int, data: bytes
) -> None:
    seal = seals(folder, "M1").seal("p/k", 1, 2, b"said")
    with pytest.raises(SealError):
        seals(folder, "ATV1").examine(seal, sender, key, life, number, data)


def test_a_seal_and_a_token_are_examined_by_what_is_written_of_their_form(folder: Path) -> None:
    """`docs/agents.md`, with a library of cryptography alone."""
    mine = seals(folder, "M1")
    certificate, at_ms, signature = msgspec.msgpack.decode(mine.seal("p/k", 3, 7, b"said"))
    assert type(at_ms) is int
    key = x509.load_der_x509_certificate(certificate).public_key()
    assert isinstance(key, ec.EllipticCurvePublicKey)
    key.verify(signature, f"p/k 3 7 {at_ms} said".encode(), ec.ECDSA(hashes.SHA256()))
    chunk = base64.urlsafe_b64decode(mine.vouch("p/alive/M1/3"))
    certificate, signature = msgspec.msgpack.decode(chunk)
    key.verify(signature, b"there p/alive/M1/3", ec.ECDSA(hashes.SHA256()))


@pytest.mark.parametrize("seal", [b"", b"\xc1", b"\x93\xc4\x01x\x00\xc4\x01y"])
def test_bytes_that_are_no_seal_are_refused(folder: Path, seal: bytes) -> None:
    with pytest.raises(SealError):
        seals(folder, "ATV1").examine(seal, "M1", "p/k", 1, 1, b"said")


def test_a_stranger_with_a_certificate_of_his_own_making_is_nobody(folder: Path, stranger: Path) -> None:
    seal = seals(stranger, "M1").seal("p/k", 1, 1, b"said")
    with pytest.raises(SealError, match="certificate"):
        seals(folder, "ATV1").examine(seal, "M1", "p/k", 1, 1, b"said")


def test_a_certificate_of_another_plant_is_worth_nothing_here(folder: Path) -> None:
    Authority.load(folder).issue(folder, "q", {"M9": Kind.MACHINE})
    with pytest.raises(SettingsError, match="names no agent of the plant p"):
        seals(folder, "M9")
    elsewhere = Seals(Identity.in_folder(folder, "M9"), "q").seal("p/k", 1, 1, b"said")
    with pytest.raises(SealError, match="does not name M9"):
        seals(folder, "ATV1").examine(elsewhere, "M9", "p/k", 1, 1, b"said")


@pytest.mark.parametrize(
    ("later_s", "fresh"), [(FRESH_S - 1, True), (FRESH_S + 1, False), (-FRESH_S - 1, False)]
)
def test_what_was_said_long_ago_is_not_heard_again(folder: Path, later_s: float, fresh: bool) -> None:
    now_s = Path(folder / "M1.pem").stat().st_mtime
    seal = seals(folder, "M1", now_s).seal("p/k", 1, 1, b"said")
    listener = seals(folder, "ATV1", now_s + later_s)
    if fresh:
        listener.examine(seal, "M1", "p/k", 1, 1, b"said")
        return
    with pytest.raises(SealError, match="ago"):
        listener.examine(seal, "M1", "p/k", 1, 1, b"said")


def test_nothing_is_heard_again_that_is_older_than_numbers_overtake_it_by_a_faster_plant_clock(
    folder: Path,
) -> None:
    speed, now_s = 10.0, Path(folder / "M1.pem").stat().st_mtime
    seal = seals(folder, "M1", now_s).seal("p/k", 1, 1, b"said")
    later_s = OVERTAKES_S / speed
    listener = Seals(Identity.in_folder(folder, "ATV1"), "p", now_s=lambda: now_s + later_s, speed=speed)
    with pytest.raises(SealError, match="ago"):
        listener.examine(seal, "M1", "p/k", 1, 1, b"said")


@pytest.fixture
def short(folder: Path) -> Path:
    """A certificate for M2 that is valid for a day."""
    Authority.load(folder).issue(folder, "p", {"M2": Kind.MACHINE}, days=1)
    return folder


TWO_DAYS_S = 2 * 86_400.0


def test_an_expired_certificate_speaks_no_more(short: Path) -> None:
    now_s = (short / "M2.pem").stat().st_mtime
    times_s = iter((now_s, now_s + TWO_DAYS_S))
    seal = Seals(Identity.in_folder(short, "M2"), "p", now_s=lambda: next(times_s)).seal("p/k", 1, 1, b"said")
    with pytest.raises(SealError, match="not valid at validation time"):
        seals(short, "ATV1", now_s + TWO_DAYS_S).examine(seal, "M2", "p/k", 1, 1, b"said")


@pytest.mark.parametrize("apart_s", [TWO_DAYS_S, -TWO_DAYS_S])
def test_who_would_not_be_believed_does_not_begin(short: Path, apart_s: float) -> None:
    now_s = (short / "M2.pem").stat().st_mtime
    with pytest.raises(SettingsError, match=r"M2\.pem: nobody would trust it .* see that the clock is right"):
        seals(short, "M2", now_s + apart_s)


def test_a_certificate_of_another_authority_is_noticed_by_its_owner(folder: Path, stranger: Path) -> None:
    mixed = Identity(folder / "authority.pem", stranger / "M1.pem", stranger / "M1.key")
    with pytest.raises(SettingsError, match="nobody would trust it"):
        Seals(mixed, "p")


def test_a_key_of_another_certificate_is_named(folder: Path) -> None:
    mixed = Identity(folder / "authority.pem", folder / "M1.pem", folder / "ATV1.key")
    with pytest.raises(SettingsError, match=r"ATV1\.key: is not the key of .*M1\.pem"):
        Seals(mixed, "p")


# --- on the bus ------------------------------------------------------------------------------------


class Agent:
    """Joins the bus of its own process and remembers what it hears."""

    def __init__(self, bus: ZenohBus, name: str) -> None:
        self.heard: list[tuple[str, Message]] = []
        self.session = bus.join(name, lambda sender, message: self.heard.append((sender, message)))


def row_of(folder: Path, *agents: str) -> Row:
    return Row(len(agents), identities=[Identity.in_folder(folder, agent) for agent in agents])


def test_agents_with_certificates_hear_one_another_also_by_relay(folder: Path) -> None:
    async def main() -> None:
        row = row_of(folder, "M1", "ATV1", "ATV2")
        try:
            machine, _, far = (Agent(bus, name) for bus, name in zip(row.buses, AGENTS, strict=True))
            await row.settle()
            far.session.send("M1", HANDOVER)
            machine.session.send("ATV2", ACCEPTED)
            await row.settle()
            assert machine.heard == [("ATV2", HANDOVER)]
            assert far.heard == [("M1", ACCEPTED)]
        finally:
            row.close()

    asyncio.run(main())


def test_a_vehicle_does_not_speak_as_a_machine_nor_use_its_words(folder: Path) -> None:
    async def main() -> None:
        row = row_of(folder, "ATV1", "ATV2")
        here, there = row.buses
        try:
            vehicle, other = Agent(here, "ATV1"), Agent(there, "ATV2")
            other.session.subscribe("p/**")
            await row.settle()
            vehicle.session.send("ATV2", ACCEPTED)
            assert there.seals is not None
            with pytest.raises(SettingsError, match="M1: the certificate names ATV1 only"):
                here.join("M1", lambda *_: None)
            vehicle.session.agent = "M1"  # As a program that lies does.
            vehicle.session.send("ATV2", ACCEPTED)
            await row.settle()
            assert other.heard == []
            assert dict(there.refused) == {FOREIGN_WORD: 1, UNSEALED: 1}
        finally:
            row.close()

    asyncio.run(main())


def test_a_vehicle_does_not_speak_for_another(folder: Path) -> None:
    async def main() -> None:
        row = row_of(folder, "ATV1", "M1")
        here, there = row.buses
        try:
            vehicle, machine = Agent(here, "ATV1"), Agent(there, "M1")
            machine.session.subscribe("p/hb/**")
            await row.settle()
            vehicle.session.publish("p/hb/atv/ATV2", atv_heartbeat("ATV2"))
            await row.settle()
            assert machine.heard == []
            assert dict(there.refused) == {FOREIGN_KEY: 1}
        finally:
            row.close()

    asyncio.run(main())


def test_the_end_of_a_certificate_is_told_to_prometheus(folder: Path) -> None:
    async def main() -> None:
        with closing(row_of(folder, "M1")) as row:
            registry = CollectorRegistry()
            registry.register(BusMeter(row.buses[0]))
            until_s = registry.get_sample_value("dray_certificate_expiry_timestamp_seconds")
            assert until_s is not None
            now_s = (folder / "M1.pem").stat().st_mtime
            assert until_s - now_s == pytest.approx(DAYS * 86_400.0, abs=60.0)

    asyncio.run(main())


def test_who_has_no_certificate_of_this_plant_gets_no_link(folder: Path, stranger: Path) -> None:
    async def main() -> None:
        address = free_address()
        house = ZenohBus(Links(listen=(address,), identity=Identity.in_folder(folder, "M1")), "p")
        house.join("M1", lambda *_: None)
        # The forger knocks first: when the guest is in, it has been turned away.
        forger = ZenohBus(Links(peers=(address,), identity=Identity.in_folder(stranger, "M1")), "p")
        guest = ZenohBus(Links(peers=(address,), identity=Identity.in_folder(folder, "ATV1")), "p")
        try:
            async with asyncio.timeout(PATIENCE_S):
                while await guest.agents_present() != {"M1"}:
                    pass
            assert await forger.agents_present() == frozenset()
            assert house.inner.info.routers_zid() == [guest.inner.zid()]
        finally:
            for bus in (house, guest, forger):
                bus.close()

    asyncio.run(main())


def test_a_missing_file_is_named(folder: Path) -> None:
    with pytest.raises(SettingsError, match=r"ATV9\.pem: there is no such file; `dray certs`"):
        Identity.in_folder(folder, "ATV9")


def test_a_file_of_something_else_is_named(folder: Path, tmp_path: Path) -> None:
    nonsense = tmp_path / "nonsense.pem"
    nonsense.write_text("nonsense")
    good = Identity.in_folder(folder, "M1")
    with pytest.raises(SettingsError, match="cannot be used"):
        Seals(Identity(good.authority, nonsense, good.key), "p")

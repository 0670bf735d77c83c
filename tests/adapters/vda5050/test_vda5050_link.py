"""The link on a real broker: login, TLS, and a broker that is away, comes back, or is none."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import asynccontextmanager
from datetime import UTC, datetime, timedelta
from ipaddress import ip_address
from pathlib import Path

import pytest
from brokers import TestBroker, free_port
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec

from dray.adapters.memory_file import MemoryFile
from dray.adapters.vda5050.events import DAMAGED, Memory
from dray.adapters.vda5050.link import BrokerAddress, MqttLink, read_address
from dray.errors import SettingsError

PATIENCE_S = 60.0
"""Far beyond what a busy computer takes."""


class Ear:
    """Hears everything."""

    def __init__(self) -> None:
        self.lost: list[str] = []
        self.links = 0
        self.heard: list[tuple[str, bytes]] = []
        self._changed = asyncio.Event()

    def on_link(self) -> None:
        self.links += 1
        self._changed.set()

    def on_link_lost(self, reason: str) -> None:
        self.lost.append(reason)
        self._changed.set()

    def on_message(self, topic: str, data: bytes) -> None:
        self.heard.append((topic, data))
        self._changed.set()

    async def until(self, holds: Callable[[], bool]) -> None:
        async with asyncio.timeout(PATIENCE_S):
            while not holds():
                self._changed.clear()
                await self._changed.wait()


@asynccontextmanager
async def linked(address: BrokerAddress, client: str, *topics: str) -> AsyncIterator[tuple[MqttLink, Ear]]:
    link, ear = MqttLink(address, "uagv/v2/Yard/1", client, topics), Ear()
    task = asyncio.create_task(link.run(ear))
    try:
        yield link, ear
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


@pytest.fixture
def broker(tmp_path: Path) -> Iterator[TestBroker]:
    broker = TestBroker(tmp_path)
    broker.start()
    yield broker
    broker.stop()


def plain(port: int, **more: str) -> BrokerAddress:
    return BrokerAddress("127.0.0.1", port, tls=False, **more)  # type: ignore[arg-type]


def run(what: Awaitable[None]) -> None:
    async def main() -> None:
        await what

    asyncio.run(main())


def test_what_is_said_is_heard_and_a_broker_that_was_away_is_joined_again(broker: TestBroker) -> None:
    async def play() -> None:
        address = plain(broker.port)
        async with (
            linked(address, "us", "state", "connection") as (us, ours),
            linked(address, "it", "order") as (it, theirs),
        ):
            await ours.until(lambda: ours.links == 1)
            await theirs.until(lambda: theirs.links == 1)
            us.publish("order", b"go")
            it.publish("state", b"gone")
            it.publish("connection", b"there", retain=True)
            await theirs.until(lambda: theirs.heard == [("order", b"go")])
            await ours.until(lambda: len(ours.heard) == 2)
            await asyncio.to_thread(broker.stop)
            await ours.until(lambda: len(ours.lost) >= 2)
            assert ours.lost[-1].startswith(f"mqtt://127.0.0.1:{broker.port}: ")
            us.publish("order", b"nobody hears this")
            assert us.dropped == 1
            await asyncio.to_thread(broker.start)
            await ours.until(lambda: ours.links == 2)
            await theirs.until(lambda: theirs.links == 2)
            it.publish("state", b"again")
            await ours.until(lambda: ours.heard[-1] == ("state", b"again"))

    run(play())


def test_what_a_broker_keeps_is_told_to_who_comes_later(broker: TestBroker) -> None:
    async def play() -> None:
        address = plain(broker.port)
        async with linked(address, "it") as (it, theirs):
            await theirs.until(lambda: theirs.links == 1)
            it.publish("connection", b"there", retain=True)
            async with linked(address, "us", "connection") as (_, ours):
                await ours.until(lambda: ours.heard == [("connection", b"there")])

    run(play())


def test_nobody_at_the_address_is_told_by_its_name() -> None:
    async def play() -> None:
        port = free_port()
        async with linked(plain(port), "us") as (_, ours):
            await ours.until(lambda: len(ours.lost) >= 2)
            assert ours.lost[0].startswith(f"mqtt://127.0.0.1:{port}: ")
            assert "refused" in ours.lost[0]

    run(play())


@pytest.mark.slow
def test_who_may_not_log_in_is_told_so_and_who_may_is_let_in(tmp_path: Path) -> None:
    broker = TestBroker(tmp_path, user="dray", password="secret")
    broker.start()

    async def play() -> None:
        async with linked(plain(broker.port, user="dray", password="secret"), "us") as (_, ours):
            await ours.until(lambda: ours.links == 1)
        async with linked(plain(broker.port, user="dray", password="wrong"), "us") as (_, ours):
            await ours.until(lambda: len(ours.lost) >= 1)
            assert ours.links == 0

    try:
        run(play())
    finally:
        broker.stop()


# The client leaves it to Python to close a socket whose handshake has failed.
@pytest.mark.filterwarnings("ignore:Exception ignored in. <ssl.SSLSocket")
def test_with_tls_the_broker_must_be_signed_by_the_authority(tmp_path: Path) -> None:
    good, other = tmp_path / "good", tmp_path / "other"
    for folder in (good, other):
        folder.mkdir()
        certify(folder)
    broker = TestBroker(good, tls=True)
    broker.start()

    async def play() -> None:
        async with linked(
            BrokerAddress("127.0.0.1", broker.port, tls=True, authority=good / "authority.pem"), "us"
        ) as (_, ours):
            await ours.until(lambda: ours.links == 1)
        async with linked(
            BrokerAddress("127.0.0.1", broker.port, tls=True, authority=other / "authority.pem"), "us"
        ) as (_, ours):
            await ours.until(lambda: len(ours.lost) >= 1)
            assert ours.links == 0
            assert "certificate verify failed" in ours.lost[0]

    try:
        run(play())
    finally:
        broker.stop()


def test_files_for_tls_that_cannot_be_used_are_named(tmp_path: Path) -> None:
    no_file, no_certificate = tmp_path / "none.pem", tmp_path / "text.pem"
    no_certificate.write_text("no certificate")
    with pytest.raises(SettingsError, match=r"DRAY_BROKER_AUTHORITY.*none\.pem"):
        BrokerAddress("h", 1, tls=True, authority=no_file).context()
    with pytest.raises(SettingsError, match=r"DRAY_BROKER_CERTIFICATE.*text\.pem"):
        BrokerAddress("h", 1, tls=True, certificate=no_certificate).context()


@pytest.mark.parametrize(
    ("text", "read"),
    [
        ("mqtt://b", ("b", 1883, False)),
        ("mqtts://b", ("b", 8883, True)),
        ("mqtt://10.0.0.1:7", ("10.0.0.1", 7, False)),
    ],
)
def test_addresses(text: str, read: tuple[str, int, bool]) -> None:
    assert read_address(text) == read


@pytest.mark.parametrize("text", ["b", "http://b", "mqtt://", "mqtt://u:p@b", "mqtt://b/x", "mqtt://b:99999"])
def test_no_addresses(text: str) -> None:
    with pytest.raises(ValueError, match=r"mqtt://HOST|out of range"):
        read_address(text)


def test_what_is_remembered_outlives_its_process_and_a_damaged_file_is_said(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "ATV1.vda5050.json"
    memory = Memory(load="shaft", quantity=3)

    def file() -> MemoryFile[Memory]:
        return MemoryFile(path, Memory, DAMAGED)

    assert file().read() is None
    file().write(memory)
    assert file().read() == memory
    path.write_bytes(b"{")
    damaged = file()
    assert damaged.read() == DAMAGED
    assert "damaged" in DAMAGED.doubt
    assert str(path) in damaged.lost
    assert file().read() == DAMAGED


def certify(folder: Path) -> None:
    """An authority, and a broker on this machine that it has signed."""
    keys = {name: ec.generate_private_key(ec.SECP256R1()) for name in ("authority", "broker")}
    names = {name: x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, name)]) for name in keys}
    now = datetime.now(UTC)
    for name, key in keys.items():
        is_authority = name == "authority"
        builder = (
            x509.CertificateBuilder()
            .subject_name(names[name])
            .issuer_name(names["authority"])
            .public_key(key.public_key())
            .serial_number(x509.random_serial_number())
            .not_valid_before(now - timedelta(days=1))
            .not_valid_after(now + timedelta(days=10))
            .add_extension(x509.BasicConstraints(ca=is_authority, path_length=None), critical=True)
            .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
            .add_extension(
                x509.AuthorityKeyIdentifier.from_issuer_public_key(keys["authority"].public_key()),
                critical=False,
            )
        )
        if is_authority:
            usage = dict.fromkeys(
                (
                    "content_commitment",
                    "key_encipherment",
                    "data_encipherment",
                    "key_agreement",
                    "encipher_only",
                    "decipher_only",
                ),
                False,
            )
            builder = builder.add_extension(
                x509.KeyUsage(digital_signature=True, key_cert_sign=True, crl_sign=True, **usage),
                critical=True,
            )
        else:
            here = x509.SubjectAlternativeName([x509.IPAddress(ip_address("127.0.0.1"))])
            builder = builder.add_extension(here, critical=False)
        signed = builder.sign(keys["authority"], hashes.SHA256())
        (folder / f"{name}.pem").write_bytes(signed.public_bytes(serialization.Encoding.PEM))
    (folder / "broker.key").write_bytes(
        keys["broker"].private_bytes(
            serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
        )
    )

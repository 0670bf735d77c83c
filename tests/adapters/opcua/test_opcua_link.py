"""The link to an OPC UA server: a server of our own that is stopped, started anew, and asked for what it does not have."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any, Literal

import pytest
from asyncua import ua
from certificates import certify
from plc import PATIENCE_S, Plc, mapping
from signals_rig import BILL, ITEM, PRODUCT, Rig

from dray.adapters.mapping_file import has_address, load_mapping, parse_mapping
from dray.adapters.mqtt.mapping_file import MqttMapping
from dray.adapters.opcua.link import OpcUaLink
from dray.adapters.opcua.mapping_file import OpcUaMapping
from dray.adapters.signals.counting import ROOM_PIECES
from dray.adapters.signals.signal import Signal
from dray.body import Book, CycleDone, DockReady, OpenDock
from dray.errors import SettingsError

ALL = tuple(
    Signal(name)
    for name in (
        "pieces",
        "fault",
        "fault_text",
        "dock_ready",
        "run",
        "product",
        "dock_permit",
        "dock_vehicle",
        "alive",
    )
)


class Linked(Rig):
    """A machine's body behind a link; time passes by hand, but for the link's."""

    def __init__(self, spec: OpcUaMapping, folder: Path, password: str = "") -> None:
        self.link: OpcUaLink | None = None
        super().__init__(linked=False)
        self.mapping = spec
        self.begin()
        self.link = OpcUaLink(spec, folder, password)

    def write(self) -> None:
        if self.link is not None:
            self.link.write()

    async def until(self, seen: Callable[[], bool]) -> None:
        async with asyncio.timeout(PATIENCE_S):
            done = seen()
            while not done:
                await asyncio.sleep(0.02)
                done = seen()

    def pieces(self) -> int:
        return sum(isinstance(report, CycleDone) for report in self.reports)


@asynccontextmanager
async def linked(text: str, folder: Path, password: str = "") -> AsyncIterator[Linked]:
    """A machine that is linked to a server, as a mapping file says."""
    rig = Linked(parse_mapping(text.encode(), "mapping.yaml", OpcUaMapping), folder, password)
    assert rig.link is not None
    running = asyncio.create_task(rig.link.run(rig.body))
    try:
        yield rig
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)


def text_of(url: str, signals: tuple[Signal, ...] = ALL, more: str = "") -> str:
    """A mapping file."""
    lines = [
        f"url: {url}",
        "stock: {" + ", ".join(f"{item}: 100" for item in BILL) + "}",
        *more.splitlines(),
        "signals:",
    ]
    lines += [f'  {name}: {{node: "{tag["node"]}"}}' for name, tag in mapping(signals).items()]
    return "\n".join(lines)


def play(story: Coroutine[Any, Any, None]) -> None:
    asyncio.run(story)


def test_a_piece_and_a_dock_from_end_to_end(tmp_path: Path) -> None:
    async def story() -> None:
        async with Plc() as plc, linked(text_of(plc.url), tmp_path) as rig:
            await rig.until(lambda: rig.state.broken == "")
            rig.reports.clear()
            rig.body.instruct(Book("ATV1", ITEM, 0, task="M1-1", epoch=1))
            rig.start()
            await plc.until(Signal.RUN, True)
            await plc.until(Signal.PRODUCT, PRODUCT)
            rig.clock.pass_s(100.0)
            await plc.put(Signal.PIECES, 1)
            await rig.until(lambda: rig.pieces() == 1)
            await plc.until(Signal.RUN, False)
            rig.body.instruct(OpenDock(vehicle="ATV7", item=ITEM, quantity=5))
            await plc.until(Signal.DOCK_PERMIT, True)
            assert await plc.read(Signal.DOCK_VEHICLE) == "ATV7"
            await plc.put(Signal.DOCK_READY, True)
            await rig.until(lambda: DockReady(vehicle="ATV7") in rig.reports)
            rig.body.instruct(Book("ATV7", ITEM, 5, task="M1-2", epoch=1))
            await plc.until(Signal.DOCK_PERMIT, False)
            alive = await plc.read(Signal.ALIVE)
            async with asyncio.timeout(PATIENCE_S):
                again = alive
                while again == alive:
                    await asyncio.sleep(0.02)
                    again = await plc.read(Signal.ALIVE)

    play(story())


def test_a_product_is_written_before_run_and_the_body_hears_that_it_is_there(tmp_path: Path) -> None:
    async def story() -> None:
        async with Plc() as plc, linked(text_of(plc.url), tmp_path) as rig:
            await rig.until(lambda: rig.state.broken == "")
            written = plc.note_writes(Signal.RUN, Signal.PRODUCT)
            rig.start()
            await plc.until(Signal.RUN, True)
            # The mapping names `run` first.
            assert [each for each in written if each[1]] == [(Signal.PRODUCT, PRODUCT), (Signal.RUN, True)]
            await rig.until(lambda: rig.kept is not None and rig.kept.confirmed == PRODUCT)

    play(story())


def test_a_product_that_is_refused_is_not_confirmed(tmp_path: Path) -> None:
    async def story() -> None:
        async with Plc() as plc:
            plc.refuse(Signal.PRODUCT, {PRODUCT})
            async with linked(text_of(plc.url), tmp_path) as rig:
                await rig.until(lambda: rig.state.broken == "")
                rig.start()
                await rig.until(lambda: "does not take product" in rig.state.broken)
                assert rig.kept is not None
                assert rig.kept.confirmed == ""

    play(story())


def test_a_server_that_begins_anew_is_found_again_and_its_counter_goes_on(tmp_path: Path) -> None:
    async def story() -> None:
        async with Plc() as plc:
            port, url = plc.port, plc.url
            async with linked(text_of(url), tmp_path) as rig:
                await rig.until(lambda: rig.state.broken == "")
                rig.clock.pass_s(1_000.0)
                # As many as can come at one moment: this clock stands while values are on their way.
                await plc.put(Signal.PIECES, ROOM_PIECES)
                await rig.until(lambda: rig.pieces() == ROOM_PIECES)
                await plc.__aexit__()
                await rig.until(lambda: "is not heard" in rig.state.broken)
                rig.clock.pass_s(1_000.0)
                rig.body.instruct(OpenDock(vehicle="ATV7", item=ITEM, quantity=5))
                async with Plc(port, pieces=5) as again:
                    # What it was to be told while it was away reaches it now.
                    await again.until(Signal.DOCK_PERMIT, True)
                    await rig.until(lambda: rig.state.broken == "")
                    assert rig.pieces() == 5

    play(story())


NODES = {
    "ns=2;s=Press.pieces": "",
    "2:Press/2:pieces": "",
    "ns=2;s=Press.nothing": "pieces: ns=2;s=Press.nothing: BadNodeIdUnknown",
    "nsu=http://nobody;s=Press.pieces": "pieces: nsu=http://nobody",
    "2:Press/2:nothing": "pieces: 2:Press/2:nothing",
    "ns=two;s=x": "pieces: ns=two;s=x",
}
"""How a node may be named, and what is said where it is not there."""


class Awaited(asyncio.Event):
    """An event that tells when somebody waits for it."""

    def __init__(self) -> None:
        super().__init__()
        self.awaited = asyncio.Event()

    async def wait(self) -> Literal[True]:
        self.awaited.set()
        return await super().wait()


def test_a_link_that_is_ended_in_the_moment_in_which_something_is_to_be_written_ends(tmp_path: Path) -> None:
    async def story() -> None:
        async with Plc() as plc:
            rig = Linked(parse_mapping(text_of(plc.url).encode(), "mapping.yaml", OpcUaMapping), tmp_path)
            assert rig.link is not None
            rig.link._changed = changed = Awaited()
            running = asyncio.create_task(rig.link.run(rig.body))
            # Everything is written by then, and it waits for more.
            await changed.awaited.wait()
            rig.link.write()
            running.cancel()
            await asyncio.wait((running,), timeout=PATIENCE_S)
            assert running.cancelled()

    play(story())


def test_a_node_has_an_id_or_a_path_and_one_that_is_not_there_is_named(tmp_path: Path) -> None:
    async def story() -> None:
        async with Plc() as plc:
            for node, why in NODES.items():
                said = f'url: {plc.url}\nsignals: {{pieces: {{node: "{node}"}}}}'
                async with linked(said, tmp_path) as rig:
                    await rig.until(lambda why=why, rig=rig: "nothing was heard" not in rig.state.broken)
                    assert why in rig.state.broken
                    assert bool(why) == bool(rig.state.broken)

    play(story())


def test_bad_quality_is_no_value_and_a_value_that_cannot_be_written_is_a_problem(tmp_path: Path) -> None:
    async def story() -> None:
        async with Plc() as plc, linked(text_of(plc.url), tmp_path) as rig:
            await rig.until(lambda: rig.state.broken == "")
            await plc.put(Signal.PIECES, 9, ua.StatusCodes.BadSensorFailure)
            await rig.until(lambda: "no value for pieces: BadSensorFailure" in rig.state.broken)
            await plc.put(Signal.PIECES, 0)
            await rig.until(lambda: rig.state.broken == "")
            await plc.nodes[Signal.RUN].set_read_only()
            rig.body.instruct(Book("ATV1", ITEM, 0, task="M1-1", epoch=1))
            rig.start()
            await rig.until(
                lambda: (
                    "does not take run: BadUserAccessDenied" in rig.state.broken
                    or "does not take run: BadNotWritable" in rig.state.broken
                )
            )

    play(story())


def test_a_server_with_name_password_and_certificates(tmp_path: Path) -> None:
    server, client, stranger = (certify(tmp_path, name) for name in ("plc", "dray", "stranger"))
    more = "user: dray\nsecurity: Basic256Sha256\ncertificate: {0}\nkey: {1}\nserver: {2}"

    async def story() -> None:
        async with Plc(user=True, certificates=server) as plc:
            said = text_of(plc.url, more=more.format(client[0].name, client[1].name, server[0].name))
            async with linked(said, tmp_path, "secret") as rig:
                await rig.until(lambda: rig.state.broken == "")
            async with linked(said, tmp_path, "wrong") as rig:
                await rig.until(
                    lambda: (
                        "BadUserAccessDenied" in rig.state.broken
                        or "BadIdentityTokenRejected" in rig.state.broken
                    )
                )
            other = text_of(plc.url, more=more.format(client[0].name, client[1].name, stranger[0].name))
            async with linked(other, tmp_path, "secret") as rig:
                await rig.until(
                    lambda: "is not heard" in rig.state.broken and "nothing was heard" not in rig.state.broken
                )
                assert not rig.link or not rig.link.linked.is_set()

    play(story())


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "required field `signals`"),
        ("url: http://x\nsignals: {pieces: {node: a}}", r"\$.url"),
        ("url: opc.tcp://x\nsignals: {pieces: {nod: a}}", "unknown field `nod`"),
        ("url: opc.tcp://x\nsignals: {peaces: {node: a}}", "Invalid enum value 'peaces'"),
        ("url: opc.tcp://x\nuser: me\nsignals: {pieces: {node: a}}", "its password would be read by anybody"),
        (
            "url: opc.tcp://x\nsecurity: Basic256Sha256\nsignals: {pieces: {node: a}}",
            "certificate is missing",
        ),
        ("url: opc.tcp://x\nstock: {steel: -1}\nsignals: {pieces: {node: a}}", "stock"),
        ("url: [", "mapping.yaml"),
        ("url: \xff", "url"),
    ],
)
def test_a_mapping_file_that_cannot_be_used_says_where(text: str, why: str) -> None:
    with pytest.raises(SettingsError, match=why):
        parse_mapping(text.encode("utf-8"), "mapping.yaml", OpcUaMapping)


def test_a_mapping_file_that_is_not_there_or_is_another_file(tmp_path: Path) -> None:
    with pytest.raises(SettingsError, match="cannot be read"):
        load_mapping(tmp_path / "nothing.yaml", OpcUaMapping)
    big = tmp_path / "big.yaml"
    big.write_bytes(b"#" * 200_000)
    with pytest.raises(SettingsError, match="that is another file"):
        load_mapping(big, OpcUaMapping)


def test_the_examples_can_be_read() -> None:
    folder = Path(__file__).parents[3] / "examples" / "machines"
    files = sorted(folder.glob("*.yaml"))
    assert [file.name for file in files] == [
        "counter.yaml",
        "gate-mqtt.yaml",
        "gate.yaml",
        "mqtt.yaml",
        "opc-40001-1.yaml",
        "store.yaml",
    ]
    for file in files:
        spec = load_mapping(file, OpcUaMapping if has_address(file) else MqttMapping)
        if file.name.startswith("gate"):
            spec.check_gate()

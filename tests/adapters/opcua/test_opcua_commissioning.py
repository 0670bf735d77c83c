"""`dray machine check`: against a controller that works, one that lacks something, and none."""

from __future__ import annotations

import asyncio
import socket
from pathlib import Path

import msgspec
import pytest
from asyncua import ua
from certificates import certify
from plc import Plc, mapping
from signals_rig import PLANT, PRODUCT, SPEC

from dray.adapters import machine_acts
from dray.adapters.machine_acts import CONTAINER, GateSpec, Wanted
from dray.adapters.mapping_file import parse_mapping
from dray.adapters.opcua.commissioning import Commissioning
from dray.adapters.opcua.mapping_file import OpcUaMapping
from dray.adapters.signals.signal import LEVEL, Signal
from dray.adapters.system_clock import SystemClock

SIGNALS = tuple(
    Signal(name) for name in ("pieces", "fault", "dock_ready", "run", "dock_permit", "dock_vehicle")
)


def commissioning(url: str, folder: Path, wanted: Wanted, **tags: str) -> Commissioning:
    """Of the rig's machine; `tags` takes the place of a signal's in the mapping."""
    said = {name: f'{{node: "{tag["node"]}"}}' for name, tag in mapping(SIGNALS).items()} | tags
    text = f"url: {url}\nsignals:\n" + "\n".join(f"  {name}: {tag}" for name, tag in said.items())
    clock = SystemClock(asyncio.get_running_loop())
    return Commissioning(
        parse_mapping(text.encode(), "m.yaml", OpcUaMapping), folder, "", SPEC, PLANT, clock, wanted
    )


async def seen(done: Commissioning) -> dict[str, tuple[bool | None, str]]:
    return {step.name: (step.passed, step.text) async for step in done.run()}


async def play_machine(plc: Plc) -> None:
    """Make a piece when one is wanted, and open the dock for whoever stands there."""
    await plc.until(Signal.RUN, True)
    await plc.put(Signal.PIECES, 1)
    await plc.until(Signal.DOCK_PERMIT, True)
    await plc.put(Signal.DOCK_READY, True)
    await plc.until(Signal.DOCK_PERMIT, False)
    await plc.put(Signal.DOCK_READY, False)


def test_a_machine_that_works_makes_a_piece_and_opens_its_dock(tmp_path: Path) -> None:
    async def story() -> None:
        async with Plc() as plc:
            machine = asyncio.create_task(play_machine(plc))
            done = commissioning(plc.url, tmp_path, Wanted(cycle=True, dock=True))
            steps = await seen(done)
            await machine
        assert [name for name, (passed, _) in steps.items() if not passed] == []
        assert "UInt16, shows 0" in steps["pieces"][1]
        assert steps["cycle"][1].startswith(f"one {PRODUCT} after")
        assert "ready after" in steps["dock"][1]
        assert done.steps.passed
        # What it has, and the mapping lacks.
        assert '  bad: {node: "ns=2;s=Press.bad"}' in done.report()

    asyncio.run(story())


def test_what_is_only_looked_at_is_told_nothing(tmp_path: Path) -> None:
    """Its agent may be at work, and does not say again what it has said."""

    async def story() -> None:
        async with Plc() as plc:
            for signal in (Signal.RUN, Signal.DOCK_PERMIT):
                await plc.put(signal, True)
            done = commissioning(plc.url, tmp_path, Wanted())
            steps = await seen(done)
            assert done.steps.passed, steps
            assert steps["machine"][0]
            assert await plc.read(Signal.RUN) is True
            assert await plc.read(Signal.DOCK_PERMIT) is True

    asyncio.run(story())


def test_what_is_wrong_is_named_signal_by_signal_and_nothing_moves(tmp_path: Path) -> None:
    async def story() -> None:
        async with Plc() as plc:
            await plc.nodes[Signal.RUN].set_read_only()
            await plc.put(Signal.PIECES, 1)
            done = commissioning(
                plc.url,
                tmp_path,
                Wanted(cycle=True, dock=True),
                fault='{node: "ns=2;s=Press.nothing"}',
                bad='{node: "ns=2;s=Press.fault"}',
            )
            steps = await seen(done)
            assert await plc.read(Signal.DOCK_PERMIT) is False
        assert "BadNodeIdUnknown" in steps["fault"][1]
        assert "it is a pulse: say `edge: rising` or `falling`" in steps["bad"][1]
        assert "may not be written" in steps["run"][1]
        assert "cycle" not in steps
        assert not done.steps.passed

    asyncio.run(story())


def test_a_controller_that_is_not_there_is_said(tmp_path: Path, free_port: int) -> None:
    async def story() -> None:
        done = commissioning(f"opc.tcp://127.0.0.1:{free_port}", tmp_path, Wanted())
        steps = await seen(done)
        assert list(steps) == ["connection"]
        assert steps["connection"][0] is False

    asyncio.run(story())


@pytest.mark.parametrize("wanted", [Wanted(cycle=True), Wanted(dock=True)])
def test_a_check_that_fails_leaves_nothing_switched_on(
    wanted: Wanted, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nobody watches the machine after its check: it would make one piece after the other, or keep its dock open."""
    for name, value in (("CYCLES", 0.0), ("CYCLE_MIN_S", 0.5), ("DOCK_S", 0.5)):
        monkeypatch.setattr(machine_acts, name, value)

    async def story() -> None:
        async with Plc() as plc:
            written = plc.note_writes(Signal.RUN, Signal.DOCK_PERMIT)
            done = commissioning(plc.url, tmp_path, wanted)
            steps = await seen(done)
            assert steps["cycle" if wanted.cycle else "dock"][0] is False
            assert (Signal.RUN if wanted.cycle else Signal.DOCK_PERMIT, True) in written
            assert await plc.read(Signal.RUN) is False
            assert await plc.read(Signal.DOCK_PERMIT) is False

    asyncio.run(story())


def test_a_check_says_what_the_mapping_does_not_have(tmp_path: Path) -> None:
    async def story() -> None:
        async with Plc() as plc:
            done = commissioning(plc.url, tmp_path, Wanted())
            await seen(done)
        report = done.report()
        assert "no `alive`: it does not notice that its agent is away" in report
        assert "no `product`" in report
        assert "no `run`" not in report
        assert '  alive: {node: "ns=2;s=Press.alive"}' in report
        assert '  product: {node: "ns=2;s=Press.product"}' in report

    asyncio.run(story())


def test_a_speed_in_percent_needs_its_scale_and_units_are_shown(tmp_path: Path) -> None:
    """A machine that shows 100 and is told 1 would crawl."""

    async def story() -> None:
        async with Plc() as plc:
            node = mapping((Signal.SPEED,))["speed"]["node"]
            speed = f'{{node: "{node}"}}'
            steps = await seen(commissioning(plc.url, tmp_path, Wanted(), speed=speed))
            assert steps["speed"][0] is False
            assert "for percent say `scale: 100`" in steps["speed"][1]
            unit = ua.EUInformation(DisplayName=ua.LocalizedText("%"))
            await plc.nodes[Signal.SPEED].add_property(
                ua.NodeId("unit", 2), ua.QualifiedName("EngineeringUnits", 0), unit
            )
            speed = f'{{node: "{node}", scale: 100}}'
            steps = await seen(commissioning(plc.url, tmp_path, Wanted(), speed=speed))
            assert steps["speed"][0]
            assert steps["speed"][1].endswith("shows 100.0 %")

    asyncio.run(story())


def test_a_controller_with_name_password_and_certificates_is_checked(tmp_path: Path) -> None:
    server, client = (certify(tmp_path, name) for name in ("plc", "dray"))

    async def story() -> None:
        async with Plc(user=True, certificates=server) as plc:
            said = {
                "url": plc.url,
                "signals": mapping(SIGNALS),
                "user": "dray",
                "security": "Basic256Sha256",
                "certificate": client[0].name,
                "key": client[1].name,
                "server": server[0].name,
            }
            secured = msgspec.convert(said, OpcUaMapping)
            for password, passes in (("secret", True), ("wrong", False)):
                clock = SystemClock(asyncio.get_running_loop())
                done = Commissioning(secured, tmp_path, password, SPEC, PLANT, clock, Wanted())
                steps = await seen(done)
                assert steps["connection"][0] is passes
                assert done.steps.passed is passes
                assert "nothing is encrypted" not in steps["connection"][1]

    asyncio.run(story())


STORE = PLANT.storages["S1"]
ITEM = STORE.stocks[0].material


def of_a_store(url: str, folder: Path, wanted: Wanted, level: Signal, **form: int) -> Commissioning:
    """Of a storage whose controller tells a level where it tells another signal, in a form."""
    at_a_dock = mapping((Signal.DOCK_READY, Signal.DOCK_PERMIT, Signal.DOCK_VEHICLE))
    said = {"url": url, "signals": at_a_dock, "levels": {ITEM: mapping((level,))[level.value] | form}}
    clock = SystemClock(asyncio.get_running_loop())
    return Commissioning(msgspec.convert(said, OpcUaMapping), folder, "", STORE, PLANT, clock, wanted)


def test_a_storage_shows_its_levels_and_opens_its_dock(tmp_path: Path) -> None:
    async def open_dock(plc: Plc) -> None:
        await plc.until(Signal.DOCK_PERMIT, True)
        await plc.until(Signal.DOCK_VEHICLE, "check")
        await plc.put(Signal.DOCK_READY, True)
        await plc.until(Signal.DOCK_PERMIT, False)
        await plc.put(Signal.DOCK_READY, False)

    async def story() -> None:
        async with Plc(pieces=120) as plc:
            dock = asyncio.create_task(open_dock(plc))
            done = of_a_store(plc.url, tmp_path, Wanted(dock=True), Signal.PIECES)
            steps = await seen(done)
            await dock
        assert [name for name, (passed, _) in steps.items() if not passed] == []
        assert list(steps)[-3:] == [LEVEL + ITEM, "storage", "dock"]
        assert "shows 120" in steps[LEVEL + ITEM][1]
        assert "ready after" in steps["dock"][1]
        # A storage has no signals of a machine.
        assert "pieces:" not in done.report()

    asyncio.run(story())


def test_a_level_that_is_no_number_fails_the_check_of_a_storage(tmp_path: Path) -> None:
    async def story() -> None:
        async with Plc() as plc:
            steps = await seen(of_a_store(plc.url, tmp_path, Wanted(dock=True), Signal.PRODUCT))
            assert await plc.read(Signal.DOCK_PERMIT) is False
        assert steps[LEVEL + ITEM][0] is False
        assert "that is no number of pieces" in steps[LEVEL + ITEM][1]
        assert "dock" not in steps

    asyncio.run(story())


@pytest.mark.parametrize(
    ("level", "form", "said"),
    [
        (Signal.FAULT, {"at_least": 20}, ""),
        (Signal.FAULT, {}, "of a switch say how many lie there `at_least`"),
        (Signal.PRODUCT, {"at_least": 20}, "that is neither yes nor no"),
    ],
)
def test_a_level_is_a_number_or_a_switch_as_its_mapping_says(
    tmp_path: Path, level: Signal, form: dict[str, int], said: str
) -> None:
    async def story() -> None:
        async with Plc() as plc:
            done = of_a_store(plc.url, tmp_path, Wanted(), level, **form)
            passed, seen_there = (await seen(done))[LEVEL + ITEM]
        assert (passed, said in seen_there) == (not said, True)
        assert (f"a switch: {ITEM}" in done.report()) is bool(form)

    asyncio.run(story())


GATE_SIGNALS = (Signal.PIECES, Signal.GOAL, Signal.ADMITTED, Signal.ADMITTED_GOAL)


def of_the_gate(url: str, folder: Path, wanted: Wanted) -> Commissioning:
    said = msgspec.yaml.encode({"url": url, "signals": mapping(GATE_SIGNALS)})
    clock = SystemClock(asyncio.get_running_loop())
    parsed = parse_mapping(said, "gate.yaml", OpcUaMapping)
    parsed.check_gate()
    return Commissioning(parsed, folder, "", GateSpec(), PLANT, clock, wanted)


async def play_gate(plc: Plc, following: str) -> None:
    """A container of four pieces stands there, and comes in when it may; then another label is shown, or none."""
    await plc.put(Signal.GOAL, "O-7-1.1")
    await plc.until(Signal.ADMITTED_GOAL, "O-7-1.1")
    await plc.until(Signal.ADMITTED, CONTAINER)
    await plc.put(Signal.PIECES, 74)
    await plc.put(Signal.GOAL, following)


@pytest.mark.parametrize("following", ["", "O-8-1.1"])
def test_a_gate_lets_a_container_in_and_counts_it(following: str, tmp_path: Path) -> None:
    async def story() -> None:
        async with Plc(pieces=70) as plc:
            only_read = await seen(of_the_gate(plc.url, tmp_path, Wanted()))
            assert only_read["gate"] == (True, "nothing keeps it from working")
            assert only_read["container"][0] is None
            gate = asyncio.create_task(play_gate(plc, following))
            done = of_the_gate(plc.url, tmp_path, Wanted(dock=True))
            steps = await seen(done)
            await gate
            assert await plc.read(Signal.ADMITTED) == 0
        assert [name for name, (passed, _) in steps.items() if not passed] == []
        assert steps["container"][1].startswith("O-7-1.1: 4 pieces counted")
        assert '  fault: {node: "ns=2;s=Press.fault"}' in done.report()
        assert "dock_ready" not in done.report()

    asyncio.run(story())


@pytest.fixture
def free_port() -> int:
    """A port on which nobody listens."""
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        port: int = server.getsockname()[1]
    return port

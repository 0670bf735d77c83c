"""The OPC UA server of simulated machines, seen by a client in another thread."""

from __future__ import annotations

import asyncio
import contextlib
import queue
from pathlib import Path

import pytest
from asyncua import Client, ua

from dray.adapters.mapping_file import load_mapping
from dray.adapters.opcua.mapping_file import OpcUaMapping
from dray.adapters.signals.signal import LEVEL, Signal, Value
from dray.adapters.system_clock import SystemClock
from dray.errors import UnavailableError
from dray.plant import default_plant
from dray_sim.bodies.floor import Floor
from dray_sim.controllers import local_server as module
from dray_sim.controllers.local_server import local_server
from dray_sim.controllers.opcua_controllers import OpcUaControllers
from dray_sim.controllers.opcua_server import ControllerServer

PATIENCE_S = 60.0
"""Far beyond what a busy computer takes."""


async def shown(client: Client, node: str, value: Value) -> None:
    """Wait until a node shows it."""
    async with asyncio.timeout(PATIENCE_S):
        # The server tells nobody that it has taken a value in.
        while await client.get_node(node).read_value() != value:  # noqa: ASYNC110
            await asyncio.sleep(0.02)


def test_a_machine_shows_its_values_and_hears_what_is_written(tmp_path: Path) -> None:
    heard: queue.Queue[tuple[str, Signal, Value]] = queue.Queue()

    async def use(server: ControllerServer) -> None:
        async with Client(server.url) as client:
            server.show("M8", Signal.PIECES, 7)
            server.show("M8", Signal.FAULT_TEXT, "tool broken")
            await shown(client, "ns=2;s=M8.pieces", 7)
            await shown(client, "ns=2;s=M8.fault_text", "tool broken")
            await shown(client, "ns=2;s=M9.pieces", 0)
            await client.get_node("ns=2;s=M9.run").write_value(True)
            await client.get_node("ns=2;s=M8.dock_vehicle").write_value("ATV1")
            with pytest.raises(ua.UaStatusCodeError):
                await client.get_node("ns=2;s=M8.pieces").write_value(ua.Variant(8, ua.VariantType.UInt16))

    with local_server(["M8", "M9"], tmp_path) as server:
        for machine in ("M8", "M9"):
            server.connect(machine, lambda *said, who=machine: heard.put((who, *said)))
        asyncio.run(use(server))
        assert heard.get(timeout=PATIENCE_S) == ("M9", Signal.RUN, True)
        assert heard.get(timeout=PATIENCE_S) == ("M8", Signal.DOCK_VEHICLE, "ATV1")
        assert heard.empty()


def test_a_storage_shows_its_levels_and_has_nothing_but_a_dock(tmp_path: Path) -> None:
    heard: queue.Queue[tuple[Signal, Value]] = queue.Queue()
    store = default_plant().stores["S1"]
    item = store.stocks[0].material

    async def use(server: ControllerServer) -> None:
        async with Client(server.url) as client:
            server.show("S1", LEVEL + item, 70_000)
            await shown(client, f"ns=2;s=S1.level.{item}", 70_000)
            await client.get_node("ns=2;s=S1.dock_vehicle").write_value("ATV1")
            with pytest.raises(ua.UaStatusCodeError):
                await client.get_node(f"ns=2;s=S1.level.{item}").write_value(
                    ua.Variant(8, ua.VariantType.UInt32)
                )
            with pytest.raises(ua.UaStatusCodeError):
                await client.get_node("ns=2;s=S1.pieces").read_value()

    with local_server([], tmp_path, [store]) as server:
        server.connect("S1", lambda *said: heard.put(said))
        asyncio.run(use(server))
        assert heard.get(timeout=PATIENCE_S) == (Signal.DOCK_VEHICLE, "ATV1")


def test_a_mapping_file_has_the_life_of_its_floor_and_another_floor_another_one(tmp_path: Path) -> None:
    plant = default_plant()

    async def begin(server: ControllerServer) -> None:
        clock = SystemClock(asyncio.get_running_loop())
        floor, controllers = Floor(plant, clock, seed=1), OpcUaControllers(clock, server, 1.0)
        controllers.build_machine(floor.workcells["M8"])
        controllers.build_gate(floor.gate)
        controllers.end()

    lives = []
    for _ in range(2):
        with local_server(["M8"], tmp_path, gate=True) as server:
            asyncio.run(begin(server))
            lives.append(server.life)
        for name in ("M8", "gate"):
            mapping = load_mapping(tmp_path / f"{name}.yaml", OpcUaMapping)
            assert f", life {server.life}" in mapping.source(Signal.PIECES)
    assert len(set(lives)) == len(lives)


class Ear:
    """Hears what it has subscribed to."""

    def datachange_notification(self, *_: object) -> None:
        """Anything."""


def test_a_server_that_ends_while_a_client_is_connected_leaves_no_task(tmp_path: Path) -> None:
    async def story() -> None:
        server = ControllerServer(["M8"], tmp_path)
        await asyncio.to_thread(server.__enter__)
        client = Client(server.url)
        await client.connect()
        subscription = await client.create_subscription(100.0, Ear())
        await subscription.subscribe_data_change([client.get_node("ns=2;s=M8.pieces")])
        await asyncio.to_thread(server.__exit__)
        assert asyncio.all_tasks(server.loop) == set()
        with contextlib.suppress(Exception):
            await client.disconnect()
        client.disconnect_socket()

    asyncio.run(asyncio.wait_for(story(), 3 * PATIENCE_S))


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(UnavailableError, match="file"), local_server(["M8"], tmp_path / "file"):
        pass


def test_without_the_extra_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "find_spec", lambda _name: None)
    with pytest.raises(UnavailableError, match=r"asyncua.*dray\[opcua\]"), local_server(["M8"], Path()):
        pass

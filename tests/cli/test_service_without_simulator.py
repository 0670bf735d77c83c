"""In service nothing needs the simulator: commands answer and an agent works where `dray_sim` cannot be imported."""

from __future__ import annotations

import asyncio
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from asyncua import Client

from dray.adapters.mapping_file import load_mapping
from dray.adapters.opcua.mapping_file import OpcUaMapping

WITHOUT = "import sys; sys.modules['dray_sim'] = None; from dray.cli import main; main()"
"""`dray` in an interpreter in which every import of the simulator fails."""

PATIENCE_S = 60.0
"""For a process that starts, on a computer that is busy."""


def dray(*args: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", WITHOUT, *args],
        capture_output=True,
        text=True,
        cwd=cwd,
        check=False,
        timeout=PATIENCE_S,
    )


@pytest.mark.parametrize(
    "command", [("agent",), ("strategist",), ("gateway",), ("historian",), ("fleet",), ("fleet", "up")]
)
def test_commands_of_a_service_need_no_simulator(command: tuple[str, ...], tmp_path: Path) -> None:
    told = dray(*command, "--help", cwd=tmp_path)
    assert told.returncode == 0, told.stderr
    assert "Usage: " in told.stdout


def test_the_simulator_is_out_of_reach_here(tmp_path: Path) -> None:
    told = dray("sim", "list", cwd=tmp_path)
    assert told.returncode == 1
    assert "No module named 'dray_sim" in told.stderr


@pytest.fixture
def bus(tmp_path: Path) -> Iterator[dict[str, str]]:
    """The settings of an agent, on the bus of a simulated floor in a process of its own."""
    with floor(tmp_path) as settings:
        yield settings


@contextmanager
def floor(tmp_path: Path, *options: str) -> Iterator[dict[str, str]]:
    """A simulated floor in a process of its own; the settings of an agent on its bus."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{probe.getsockname()[1]}"
    plain = {**os.environ, "DRAY_BUS_PLAIN": "true"}
    process = subprocess.Popen(
        [sys.executable, "-m", "dray", "floor", *options],
        stdout=subprocess.PIPE,
        text=True,
        env={**plain, "DRAY_BUS_LISTEN": address},
        cwd=tmp_path,
    )
    with process:
        assert process.stdout is not None
        assert process.stdout.readline() == "floor is ready\n"
        try:
            yield {**plain, "DRAY_BUS_PEERS": address}
        finally:
            process.kill()


@pytest.mark.slow
@pytest.mark.parametrize("agent", [("agent", "atv", "ATV1"), ("agent", "machine", "M1"), ("agent", "gate")])
def test_an_agent_takes_part_and_leaves_without_the_simulator(
    agent: tuple[str, ...], bus: dict[str, str], tmp_path: Path
) -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", WITHOUT, *agent],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=bus,
        cwd=tmp_path,
    )
    with process:
        assert process.stdout is not None
        assert process.stdout.readline() == f"{agent[-1]} is ready\n"
        process.send_signal(signal.SIGTERM)
        _, told = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0, told


@pytest.mark.slow
def test_a_machine_of_the_floor_may_have_a_controller_and_then_its_agent_needs_no_simulator(
    tmp_path: Path,
) -> None:
    async def until_alive(url: str) -> None:
        async with asyncio.timeout(PATIENCE_S), Client(url) as client:
            # The agent says nowhere else that it speaks to the controller.
            while not await client.get_node("ns=2;s=M1.alive").read_value():  # noqa: ASYNC110
                await asyncio.sleep(0.05)

    with floor(tmp_path, "--opcua", str(tmp_path / "controllers")) as settings:
        file = tmp_path / "controllers" / "M1.yaml"
        command = (sys.executable, "-c", WITHOUT, "agent", "machine", "M1")
        process = subprocess.Popen(
            (*command, "--body", "opcua", "--mapping", str(file)),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=settings,
            cwd=tmp_path,
        )
        with process:
            assert process.stdout is not None
            assert process.stdout.readline() == "M1 is ready\n"
            asyncio.run(until_alive(load_mapping(file, OpcUaMapping).url))
            process.send_signal(signal.SIGTERM)
            _, told = process.communicate(timeout=PATIENCE_S)
        assert process.returncode == 0, told
        refused = subprocess.run(
            command,
            capture_output=True,
            text=True,
            env=settings,
            cwd=tmp_path,
            check=False,
            timeout=PATIENCE_S,
        )
        assert refused.returncode == 1
        assert "start its agent with the --body that the floor was started for" in refused.stderr

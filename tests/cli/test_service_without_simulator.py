"""In service nothing needs the simulator: commands answer and an agent works where `dray_sim` cannot be imported."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

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
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{probe.getsockname()[1]}"
    plain = {**os.environ, "DRAY_BUS_PLAIN": "true"}
    floor = subprocess.Popen(
        [sys.executable, "-m", "dray", "floor"],
        stdout=subprocess.PIPE,
        text=True,
        env={**plain, "DRAY_BUS_LISTEN": address},
        cwd=tmp_path,
    )
    with floor:
        assert floor.stdout is not None
        assert floor.stdout.readline() == "floor is ready\n"
        yield {**plain, "DRAY_BUS_PEERS": address}
        floor.kill()


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

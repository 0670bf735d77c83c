"""The end of a fleet whose `dray fleet up` was killed: what it has left behind is named, ended, and no one else."""

from __future__ import annotations

import asyncio
import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from actor import make_actor
from registries import NOBODY, write_registry

from dray.adapters.processes import Process
from dray.cli.fleet.ending import end_fleet
from dray.cli.fleet.folder import FLEET_LOCK, REGISTRY, alone
from dray.cli.fleet.software import Software
from dray.cli.fleet.supervisor import FleetOptions, run_fleet
from dray.errors import UnavailableError
from dray.plant import default_plant
from dray.settings import Settings


class Left:
    """A process that is in the registry of a folder, and what it says."""

    def __init__(self, folder: Path, software: Software) -> None:
        environment = {**os.environ, "TOLD": "here"}
        self.process = subprocess.Popen(
            software.command("agent"), env=environment, stdout=subprocess.PIPE, text=True
        )
        assert self.process.stdout is not None
        self.out = self.process.stdout
        assert self.out.readline() == "1.0 agent here\n"


@pytest.fixture
def left(tmp_path: Path) -> Iterator[Left]:
    """A process that nobody keeps any more."""
    there = Left(tmp_path, make_actor(tmp_path, "1.0"))
    with there.process:
        yield there
        there.process.kill()


def options(folder: Path) -> FleetOptions:
    return FleetOptions(
        Settings(), default_plant(), folder, speed=1.0, plain=True, demand=False, metrics=False
    )


def test_what_a_killed_fleet_has_left_behind_hinders_the_next_and_can_be_ended(
    tmp_path: Path, left: Left
) -> None:
    pid = left.process.pid
    write_registry(tmp_path, NOBODY, Process.of(pid), NOBODY)
    with pytest.raises(UnavailableError, match=rf"ATV1 \({pid}\); end them with `dray fleet down`"):
        asyncio.run(run_fleet(options(tmp_path)))
    assert asyncio.run(end_fleet(tmp_path)) == 1
    assert left.out.readline() == "1.0 ends by SIGINT\n"
    assert not (tmp_path / REGISTRY).exists()


def test_whoever_has_the_number_of_one_that_has_ended_is_left_alone(tmp_path: Path, left: Left) -> None:
    write_registry(tmp_path, NOBODY, Process(left.process.pid, "another birth"))
    assert asyncio.run(end_fleet(tmp_path)) == 0
    assert left.process.poll() is None


def test_a_fleet_that_is_kept_is_ended_by_its_supervisor(tmp_path: Path, left: Left) -> None:
    supervisor = Process.of(left.process.pid)
    write_registry(tmp_path, supervisor, supervisor)
    assert asyncio.run(end_fleet(tmp_path)) == 1
    assert left.out.readline() == "1.0 ends by SIGTERM\n"


def test_somebody_elses_fleet_is_told_of_in_one_error(
    tmp_path: Path, left: Left, monkeypatch: pytest.MonkeyPatch
) -> None:
    process = Process.of(left.process.pid)
    write_registry(tmp_path, NOBODY, process, process)

    def refuse(handle: int, number: int) -> None:
        raise PermissionError

    monkeypatch.setattr("signal.pidfd_send_signal", refuse)
    with pytest.raises(UnavailableError, match="belongs to another user"):
        asyncio.run(end_fleet(tmp_path))
    assert (tmp_path / REGISTRY).exists()


def test_a_fleet_whose_supervisor_ends_without_its_processes_is_ended_all_the_same(
    tmp_path: Path, left: Left
) -> None:
    with subprocess.Popen(["sleep", "60"]) as supervisor:
        write_registry(tmp_path, Process.of(supervisor.pid), Process.of(left.process.pid))
        assert asyncio.run(end_fleet(tmp_path)) == 1
    assert left.out.readline() == "1.0 ends by SIGINT\n"
    assert not (tmp_path / REGISTRY).exists()


def test_a_folder_has_one_fleet(tmp_path: Path) -> None:
    (tmp_path / "logs").mkdir()
    busy = pytest.raises(UnavailableError, match="another one is at work")
    with alone(tmp_path, FLEET_LOCK, "`dray fleet up`", "wait"), busy:
        asyncio.run(run_fleet(options(tmp_path)))
    with alone(tmp_path, FLEET_LOCK, "`dray fleet up`", "wait"):
        pass

"""The registry of a fleet that nobody has started, for tests of whoever reads one."""

from __future__ import annotations

from pathlib import Path

import msgspec

from dray.adapters.processes import Process
from dray.cli.fleet.folder import REGISTRY
from dray.cli.fleet.process_registry import Member, ProcessRegistry
from dray.cli.fleet.software import Software

NOBODY = Process(1, "")


def write_registry(folder: Path, supervisor: Process, *processes: Process) -> None:
    """Vehicles ATV1, ATV2 and so on, one for each of these processes."""
    software = Software("python", "1.0", 1)
    members = tuple(
        Member(
            pid=each.pid,
            born=each.born,
            name=f"ATV{number}",
            kind="atv",
            address="",
            starts=1,
            software=software,
            proven=software,
        )
        for number, each in enumerate(processes, 1)
    )
    registry = ProcessRegistry("plant", plain=True, supervisor=supervisor, members=members)
    (folder / REGISTRY).write_bytes(msgspec.json.encode(registry))

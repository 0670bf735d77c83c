"""A running `dray up` with an operator of all areas: which vehicle and which machine have work is left to the factory."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

OPERATOR = "floater"

AREAS = ("AREA1", "AREA2", "AREA3", "AREA4")


@contextmanager
def dray_with_floater(
    start_dray: Callable[..., Any], folder: Path, speed: float, *, stepped: bool = False
) -> Iterator[Any]:
    """Start it on a database in this folder; the operator's link is in its `links`. It must stop cleanly."""
    database = f"sqlite:///{folder / 'dray.db'}"
    dray = start_dray("--speed", str(speed), "--seed", "3", url=database, stepped=stepped)

    def user(*arguments: str) -> str:
        command = [sys.executable, "-m", "dray", "user", *arguments, "--db", database]
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()

    user("add", OPERATOR, *(word for area in AREAS for word in ("--area", area)))
    dray.links[OPERATOR] = user("link", OPERATOR, "--url", dray.url)
    yield dray
    assert dray.stop() == 0, dray.output()

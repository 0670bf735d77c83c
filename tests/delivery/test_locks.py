"""What runs in a plant is locked, real machines included."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_the_image_is_installed_from_a_lock_that_has_what_real_machines_need() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = [*project["dependencies"], *project["optional-dependencies"]["opcua"]]
    lock = (ROOT / "requirements.txt").read_text(encoding="utf-8")
    locked = {line.partition("==")[0].lower() for line in lock.splitlines() if "==" in line}
    names = {re.match(r"[A-Za-z0-9._-]+", each).group().lower() for each in wanted}  # type: ignore[union-attr]
    assert "asyncua" in names
    assert names <= locked
    assert "-r /tmp/requirements.txt" in (ROOT / "Dockerfile").read_text(encoding="utf-8")

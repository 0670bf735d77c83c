"""Other versions of Dray for tests: an environment of their own, with a copy of our packages that is a little different."""

from __future__ import annotations

import shutil
import sysconfig
import venv
from collections.abc import Mapping
from pathlib import Path

import dray
import dray_sim
from dray import __version__


def make_version(folder: Path, version: str, patches: Mapping[str, tuple[str, str]] | None = None) -> Path:
    """Make an environment with another version.

    Args:
        folder: made for it.
        version: what it says that it is.
        patches: by module, as `protocol/vehicle/atv.py`: a text that stands in it once, and what takes its place.

    Returns:
        Its interpreter.
    """
    venv.create(folder, symlinks=True)
    packages = Path(sysconfig.get_path("purelib", vars={"base": str(folder), "platbase": str(folder)}))
    inside = Path(dray.__file__).parent
    # With what is compiled already: else every start would compile it anew.
    shutil.copytree(inside, packages / "dray")
    shutil.copytree(Path(dray_sim.__file__).parent, packages / "dray_sim")
    root = inside.parents[1]
    shutil.copytree(root / "migrations", packages / "dray/store/migrations", dirs_exist_ok=True)
    shutil.copytree(root / "frontend/templates", packages / "dray/gateway/templates", dirs_exist_ok=True)
    (packages / "others.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    for module, (old, new) in {"__init__.py": (__version__, version), **(patches or {})}.items():
        file = packages / "dray" / module
        file.write_text(patched(file, old, new), encoding="utf-8")
    return folder / "bin/python"


def patched(file: Path, old: str, new: str) -> str:
    """The text of a file with one change.

    Raises:
        AssertionError: `old` does not stand in it once.
    """
    text = file.read_text(encoding="utf-8")
    assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times in {file}"
    return text.replace(old, new)

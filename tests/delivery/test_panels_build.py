"""The panels are built while a gateway serves them: neither new nor open pages ask for files that are gone."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

from dray.gateway.http.assets import NotBuilt, Panels

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def build() -> ModuleType:
    """`hatch_build.py`, which belongs to no package."""
    spec = importlib.util.spec_from_file_location("hatch_build", ROOT / "hatch_build.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def built(folder: Path, number: int) -> Path:
    """A folder as Vite leaves it."""
    (folder / ".vite").mkdir(parents=True)
    (folder / "assets").mkdir()
    (folder / "assets" / f"main-{number}.js").write_text(f"export const n = {number};")
    (folder / "icon.svg").write_text(f"<svg>{number}</svg>")
    (folder / ".vite" / "manifest.json").write_text(
        f'{{"src/manager/main.tsx": {{"file": "assets/main-{number}.js"}}}}'
    )
    return folder


def scripts(static: Path) -> list[str]:
    return sorted(file.name for file in (static / "assets").iterdir())


def test_a_gateway_names_the_files_of_the_newest_build_and_those_before_stay(
    build: ModuleType, tmp_path: Path
) -> None:
    static = tmp_path / "static"
    panels = Panels(static)
    with pytest.raises(NotBuilt):
        panels.asset("src/manager/main.tsx")
    for number in (1, 2, 3):
        build.publish(built(tmp_path / str(number), number), static)
        assert panels.asset("src/manager/main.tsx") == f"/static/assets/main-{number}.js"
        assert (static / "icon.svg").read_text() == f"<svg>{number}</svg>"
    assert scripts(static) == ["main-2.js", "main-3.js"]


def test_files_of_a_build_without_a_list_are_those_before(build: ModuleType, tmp_path: Path) -> None:
    static = built(tmp_path / "static", 1)
    build.publish(built(tmp_path / "2", 2), static)
    assert scripts(static) == ["main-1.js", "main-2.js"]


def test_a_wheel_has_the_newest_build_only(build: ModuleType, tmp_path: Path) -> None:
    static = tmp_path / "static"
    for number in (1, 2):
        build.publish(built(tmp_path / str(number), number), static)
    build.remove_others(static, build.listed(static))
    assert scripts(static) == ["main-2.js"]
    assert (static / ".vite" / "manifest.json").is_file()

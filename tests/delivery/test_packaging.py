"""A wheel that is installed where nothing else is has everything inside: panels, templates, migrations."""

from __future__ import annotations

import subprocess
import sys
import urllib.request
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

pytestmark = pytest.mark.slow


@pytest.fixture(autouse=True)
def no_sources(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is installed is asked, also where the environment names a folder with the sources."""
    monkeypatch.delenv("PYTHONPATH", raising=False)


def run(*command: str | Path, cwd: Path) -> str:
    """Run to a good end, else show what it said."""
    done = subprocess.run(
        command,
        cwd=cwd,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=500,
        check=False,
    )
    assert done.returncode == 0, done.stdout
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Built as `python -m build` does: an sdist, then the wheel from nothing but that sdist."""
    dist = tmp_path_factory.mktemp("dist")
    run(sys.executable, "-m", "build", "--no-isolation", "--outdir", str(dist), str(ROOT), cwd=dist)
    [built] = dist.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def python(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The interpreter of an empty environment with the locked packages and the wheel."""
    home = tmp_path_factory.mktemp("empty")
    # Our pip installs there; what Python does not run need not be compiled.
    venv.create(home, with_pip=False)
    python = home / "bin/python"
    pip = (sys.executable, "-m", "pip", "--python", python, "install", "--quiet", "--no-compile")
    run(*pip, "--disable-pip-version-check", "--require-hashes", "-r", ROOT / "requirements.txt", cwd=home)
    run(*pip, "--disable-pip-version-check", "--no-deps", wheel, cwd=home)
    return python


def test_the_wheel_holds_code_panels_templates_and_migrations_and_nothing_to_build_with(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    for needed in (
        "dray/cli/__init__.py",
        "dray/plant/default.yaml",
        "dray/plant/examples/large.yaml",
        "dray/plant/examples/two-halls.yaml",
        "dray/plant/examples/workshop.yaml",
        "dray_sim/clock/loop.py",
        "dray/store/migrations/env.py",
    ):
        assert needed in names
    assert any(name.startswith("dray/store/migrations/versions/") for name in names)
    assert any(name.startswith("dray/gateway/templates/") and name.endswith(".html") for name in names)
    assert any(name.startswith("dray/gateway/static/") and name.endswith(".js") for name in names)
    assert any(name.startswith("dray/gateway/static/") and name.endswith(".css") for name in names)
    assert {name.split("/")[0].split("-")[0] for name in names} == {"dray", "dray_sim"}
    assert not [name for name in names if "node_modules" in name or name.endswith((".ts", ".tsx", ".db"))]


def test_an_installed_wheel_runs_dray_up_with_panels_and_database(python: Path, start_dray) -> None:
    where = run(
        python,
        "-P",
        "-E",
        "-c",
        "import dray, dray_sim; print(dray.__file__, dray_sim.__file__)",
        cwd=python.parent,
    )
    assert str(ROOT) not in where
    dray = start_dray("--no-demand", python=python)
    page = urllib.request.urlopen(f"{dray.url}/login", timeout=10).read().decode()
    assert "/static/" in page
    ready = urllib.request.urlopen(f"{dray.url}/readyz", timeout=10)
    assert ready.status == 200
    ready.close()
    assert dray.stop() == 0, dray.output()

"""A campaign that is ended goes on where it was, and the ledger says on which code each claim was last seen to hold."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

RUN_CAMPAIGN = str(Path(__file__).parents[1] / "tools/run_campaign.py")

TESTS = """
import os
import signal
import time
from pathlib import Path

import pytest

pytestmark = pytest.mark.campaign


def log(name):
    with (Path(__file__).parents[1] / "log").open("a") as file:
        file.write(name + " ")


def test_a(record_property):
    log("a")
    record_property("seeds", "0 to 7")


def test_b():
    root = Path(__file__).parents[1]
    if not (root / "goes-on").exists():
        while not any(root.glob("artifacts/campaigns/*.json")):
            time.sleep(0.01)
        os.kill(os.getppid(), signal.{signal})
        signal.pause()
    log("b")


def test_c():
    log("c")
    assert 1 == 2
"""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A repository with one campaign."""
    (tmp_path / "tests").mkdir()
    write(tmp_path, "SIGTERM")
    (tmp_path / ".gitignore").write_text(
        "artifacts\nlog\ngoes-on\n__pycache__\n.pytest_cache\n", encoding="utf-8"
    )
    git(tmp_path, "init", "--quiet")
    commit(tmp_path)
    return tmp_path


def write(project: Path, signal: str) -> None:
    (project / "tests/test_it.py").write_text(TESTS.replace("{signal}", signal), encoding="utf-8")


def git(project: Path, *arguments: str) -> str:
    names = ("-c", "user.name=a", "-c", "user.email=a@example.invalid")
    done = subprocess.run(
        ["git", *names, *arguments], cwd=project, check=True, capture_output=True, text=True
    )
    return done.stdout.strip()


def commit(project: Path) -> str:
    git(project, "add", "--all")
    git(project, "commit", "--quiet", "--message", "a")
    return git(project, "rev-parse", "--short", "HEAD")


def run(project: Path) -> int:
    fixed = {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    options = ("-p", "xdist", "-n", "1", "-m", "campaign", "--rootdir", str(project))
    return subprocess.run(
        [sys.executable, RUN_CAMPAIGN, *options, "-W", "ignore"],
        env={**os.environ, **fixed},
        cwd=project,
        capture_output=True,
        check=False,
    ).returncode


def ledger(project: Path) -> list[str]:
    return [
        line
        for line in (project / "docs/campaigns.md").read_text(encoding="utf-8").splitlines()
        if line.startswith("| 2")
    ]


def ran(project: Path) -> str:
    return (project / "log").read_text(encoding="utf-8").strip()


@pytest.mark.slow
@pytest.mark.parametrize("signal", ["SIGTERM", "SIGINT"])
def test_a_campaign_that_is_ended_goes_on_and_what_failed_runs_again(project: Path, signal: str) -> None:
    (project / "docs").mkdir()
    write(project, signal)
    (project / "read-me").touch()
    commit(project)
    first = git(project, "log", "-1", "--format=%h", "--", "tests")
    assert run(project) != 0
    assert ran(project) == "a"
    assert f"| {first} | `tests/test_it.py` | 1 of 1 tests held | 0 to 7 |" in ledger(project)[0]

    (project / "goes-on").touch()
    commit(project)  # the ledger: no code
    assert run(project) == 1
    assert ran(project) == "a b c"
    assert run(project) == 1
    assert ran(project) == "a b c c"
    [row] = ledger(project)
    assert f"| {first} | `tests/test_it.py` | 2 of 3 tests held; `test_c` failed: " in row


@pytest.mark.slow
def test_other_code_begins_anew_and_keeps_the_rows_of_the_old(project: Path) -> None:
    (project / "docs").mkdir()
    (project / "goes-on").touch()
    first = git(project, "rev-parse", "--short", "HEAD")
    assert run(project) == 1
    mended = (project / "tests/test_it.py").read_text(encoding="utf-8").replace("1 == 2", "1 == 1")
    (project / "tests/test_it.py").write_text(mended, encoding="utf-8")
    assert run(project) == 0
    second = commit(project)
    assert run(project) == 0
    assert run(project) == 0
    assert ran(project) == "a b c a b c a b c"
    found = [row.split("|")[2].strip() for row in ledger(project)]
    assert found == [second, f"{first}+", first]

"""How tests are told that did not run, or ran twice: skipped ones fail under CI, forbidden ones never, many second tries always; all are loud."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from variants import later

TESTS = """
import pytest
from forbidden import forbidden


def test_a():
    pytest.skip("no browser")


def test_b():
    forbidden("no multicast")


@pytest.fixture
def several():
    forbidden("no namespaces")


def test_c(several):
    pass
"""


@pytest.mark.parametrize(
    ("ci", "code", "counts"),
    [*later(("", 0, "1 skipped, 2 forbidden")), ("true", 1, "1 failed, 2 forbidden")],
)
def test_what_is_forbidden_fails_nowhere_and_what_is_skipped_fails_under_ci(
    tmp_path: Path, ci: str, code: int, counts: str
) -> None:
    (tmp_path / "test_it.py").write_text(TESTS, encoding="utf-8")
    done = run(tmp_path, CI=ci)
    assert done.returncode == code, done.stdout
    assert counts in done.stdout
    assert "2 TESTS ARE FORBIDDEN BY THIS MACHINE" in done.stdout
    assert "test_it.py::test_b: no multicast" in done.stdout
    assert "test_it.py::test_c: no namespaces" in done.stdout


SECOND_TRIES = """
import pytest

tried = set()


@pytest.mark.flaky(reruns=1)
@pytest.mark.parametrize("each", range({0}))
def test_a(each):
    if each not in tried:
        tried.add(each)
        pytest.fail("too late")
"""


@pytest.mark.parametrize(("count", "code"), [(3, 0), (4, 1)])
def test_a_second_try_is_loud_and_many_of_them_fail_the_run(tmp_path: Path, count: int, code: int) -> None:
    (tmp_path / "test_it.py").write_text(SECOND_TRIES.format(count), encoding="utf-8")
    done = run(tmp_path, "-p", "pytest_rerunfailures", CI="true")
    assert done.returncode == code, done.stdout
    assert f"{count} TESTS FAILED AND RAN ONCE MORE" in done.stdout
    assert "test_it.py::test_a[0]: Failed: too late" in done.stdout
    assert f"{count} passed, {count} rerun" in done.stdout


def run(folder: Path, *options: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run the tests in a folder with our conftest."""
    # Of ours the conftest alone: a plugin that is loaded takes longer than these tests.
    fixed = {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1", "PYTHONPATH": str(Path(__file__).parent)}
    return subprocess.run(
        [sys.executable, "-m", "pytest", "-p", "conftest", *options, "--rootdir", str(folder), str(folder)],
        env={**os.environ, **fixed, **environment},
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )

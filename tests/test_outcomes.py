"""How tests are told that did not run, or ran again: skipped ones fail under CI, forbidden ones never, what passes alone is unsteady."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from runpy import run_path

import pytest
from variants import later, variants

RUN_TESTS = str(Path(__file__).parents[1] / "tools/run_tests.py")

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


CHANCE = """
import os
import signal
from pathlib import Path

import pytest


def is_first(name):
    path = Path(__file__).with_name(name)
    if path.exists():
        return False
    path.touch()
    return True


def hung_s(name):
    # Plenty once it does not hang any more: a busy computer is no fault of it.
    return 60.0 if Path(__file__).with_name(name).exists() else 0.2


def test_that_passes():
    pass


def test_that_fails_once():
    assert not is_first("fails"), "too late"


@pytest.fixture
def ends_badly_once():
    yield
    assert not is_first("ends"), "left open"


def test_whose_end_fails_once(ends_badly_once):
    pass


@pytest.mark.timeout(hung_s("hangs"))
def test_that_hangs_once():
    while is_first("hangs"):
        while True:
            pass


def test_that_dies_once():
    if is_first("dies"):
        os._exit(3)
"""

DEAF = """
def test_that_hangs_once_and_hears_no_signal():
    if is_first("deaf"):
        signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGALRM])
        while True:
            pass
"""

ENDLESS = """
import time

import pytest


@pytest.fixture
def never_ends():
    yield
    while True:
        time.sleep(1)


def test_that_fails(never_ends):
    raise AssertionError("wrong")


def test_that_passes():
    pass
"""

ALWAYS = """
def test_that_fails_always():
    raise AssertionError("wrong")


@pytest.mark.timeout(0.2)
def test_that_hangs_always():
    while True:
        pass


def test_that_dies_always():
    os._exit(3)
"""

UNSTEADY = {
    "test_it.py::test_that_fails_once": "AssertionError: too late",
    "test_it.py::test_whose_end_fails_once": "AssertionError: left open",
    "test_it.py::test_that_hangs_once": "Failed: Timeout (>0.2s) from pytest-timeout.",
    "test_it.py::test_that_dies_once": "crashed while running 'test_it.py::test_that_dies_once'",
}


@pytest.mark.slow
def test_what_fails_beside_others_and_passes_alone_is_unsteady(tmp_path: Path) -> None:
    done = run_again(tmp_path, CHANCE)
    assert done.returncode == 0, done.stdout
    assert "unsteady: 4" in done.stdout
    assert_unsteady(tmp_path, done, UNSTEADY)


def test_what_fails_alone_twice_is_red(tmp_path: Path) -> None:
    done = run_again(tmp_path, CHANCE + ALWAYS)
    assert done.returncode == 1, done.stdout
    assert "unsteady: 4" in done.stdout
    assert "failed: 3" in done.stdout
    assert "!!! test_it.py::test_that_fails_always: AssertionError: wrong" in done.stdout
    assert done.stdout.count("again alone") == 2
    assert_unsteady(tmp_path, done, UNSTEADY)


@pytest.mark.slow
def test_what_hangs_and_hears_no_signal_is_ended_with_its_process(tmp_path: Path) -> None:
    done = run_again(tmp_path, CHANCE + DEAF, "-o", "faulthandler_timeout=3")
    assert done.returncode == 0, done.stdout
    assert "unsteady: 5" in done.stdout


def test_a_test_that_runs_for_minutes_is_named_once() -> None:
    watch = run_path(RUN_TESTS)["Watch"]()
    for test, begun_s in {"short": 0.0, "long": 0.0, "later": 200.0}.items():
        watch.began(test, begun_s)
    watch.pytest_runtest_logfinish("short")
    assert watch.overdue(299.0) == {}
    assert watch.overdue(310.0) == {"long": 310.0}
    assert watch.overdue(400.0) == {}


def test_a_test_whose_process_has_died_is_not_named_as_running() -> None:
    """Xdist reports it as of no phase, and no end of it is logged."""
    watch = run_path(RUN_TESTS)["Watch"]()

    def reported(when: str) -> pytest.TestReport:
        return pytest.TestReport("dies", ("test_it.py", None, "dies"), {}, "failed", "crashed", when)  # type: ignore[arg-type]

    watch.began("dies", 0.0)
    for when in ("setup", "call"):
        watch.pytest_runtest_logreport(reported(when))
    assert watch.overdue(310.0) == {"dies": 310.0}
    watch.began("dies", 400.0)
    watch.pytest_runtest_logreport(reported("???"))
    assert watch.overdue(800.0) == {}


@pytest.mark.slow
def test_the_end_of_a_failed_test_is_bounded(tmp_path: Path) -> None:
    """Pytest takes the timers of a failed test back, for a debugger."""
    (tmp_path / "test_it.py").write_text(ENDLESS, encoding="utf-8")
    bounds = [f"{name}={value}" for name, value in {"timeout": 2, "faulthandler_timeout": 3}.items()]
    plugins = ("-p", "xdist", "-p", "pytest_timeout", "-n", "1", "-o", "faulthandler_exit_on_timeout=true")
    done = run(tmp_path, *plugins, *(word for bound in bounds for word in ("-o", bound)))
    assert done.returncode == 1, done.stdout
    assert "FAILED test_it.py::test_that_fails (call): AssertionError: wrong" in done.stdout
    assert "crashed while running 'test_it.py::test_that_fails'" in done.stdout
    assert "1 passed" in done.stdout


@pytest.mark.parametrize("tests", variants(["import nowhere", ""]))
def test_what_cannot_be_read_and_a_run_without_tests_are_not_tried_again(tmp_path: Path, tests: str) -> None:
    done = run_again(tmp_path, tests)
    assert done.returncode != 0, done.stdout
    assert "again alone" not in done.stdout
    assert_unsteady(tmp_path, done, {})


def test_many_failures_have_one_cause_and_are_not_tried_again(tmp_path: Path) -> None:
    many = 'import pytest\n@pytest.mark.parametrize("each", range(41))\ndef test_it(each):\n    assert each < 0\n'
    done = run_again(tmp_path, many)
    assert done.returncode == 1, done.stdout
    assert "failed: 41" in done.stdout
    assert "again alone" not in done.stdout


@pytest.mark.slow
def test_a_test_that_is_not_found_again_has_failed(tmp_path: Path) -> None:
    once = """
import os

import pytest


@pytest.mark.parametrize("each", [os.environ.get("PYTEST_XDIST_TESTRUNUID")])
def test_whose_name_is_another_each_time(each):
    raise AssertionError
"""
    done = run_again(tmp_path, once)
    assert done.returncode != 0, done.stdout
    assert "did not run again" in done.stdout


@pytest.mark.slow
def test_runs_of_several_names_are_kept_side_by_side(tmp_path: Path) -> None:
    run_again(tmp_path, CHANCE, name="test")
    run_again(tmp_path, "def test_a(): pass", name="test-long")
    kept = json.loads((tmp_path / "artifacts/unsteady.json").read_text(encoding="utf-8"))
    assert len(kept["test"]) == 4
    assert kept["test-long"] == []


def run_again(
    folder: Path, tests: str, *options: str, name: str = "test"
) -> subprocess.CompletedProcess[str]:
    """Run tests as `make test` does, on two workers."""
    (folder / "test_it.py").write_text(tests, encoding="utf-8")
    plugins = ("-p", "xdist", "-p", "pytest_timeout", "-o", "faulthandler_exit_on_timeout=true")
    return subprocess.run(
        [sys.executable, RUN_TESTS, name, "-n", "2", *plugins, *options, "--rootdir", str(folder)],
        env={**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"},
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )


def assert_unsteady(folder: Path, done: subprocess.CompletedProcess[str], unsteady: dict[str, str]) -> None:
    """These tests are told at the end and kept, each with its first failure."""
    kept = json.loads((folder / "artifacts/unsteady.json").read_text(encoding="utf-8"))["test"]
    assert {each["test"] for each in kept} == set(unsteady)
    for each in kept:
        assert unsteady[each["test"]] in each["first_failure"]
        assert f"!!! {each['test']}: {each['first_failure']}" in done.stdout


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

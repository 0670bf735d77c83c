"""Versions: an interpreter is asked which it has, and keeps to its own packages."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from dray import __version__
from dray.cli.fleet.software import OWN, ask
from dray.errors import SettingsError
from dray.messages import WIRE_VERSION


def test_an_environment_says_which_version_it_has() -> None:
    found = ask(Path(sys.executable))
    assert found == OWN
    assert (found.version, found.wire) == (__version__, WIRE_VERSION)


@pytest.mark.parametrize(
    ("program", "reason"),
    [
        ("#!/bin/sh\necho no module named dray >&2; exit 1\n", "no module named dray"),
        ("#!/bin/sh\necho dray 0.0.1\n", "dray 0.0.1"),
        ("no program", "cannot be run"),
    ],
)
def test_what_has_no_version_to_update_to_is_refused(tmp_path: Path, program: str, reason: str) -> None:
    python = tmp_path / "python"
    python.write_text(program, encoding="utf-8")
    python.chmod(0o700)
    with pytest.raises(SettingsError, match=reason):
        ask(python)


def test_no_interpreter_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SettingsError, match=r"--python: .* cannot be run"):
        ask(tmp_path / "python")


def test_another_interpreter_does_not_get_our_packages(tmp_path: Path) -> None:
    variables = {"PYTHONPATH": "/ours", "PYTHONHOME": "/ours", "DRAY_PORT": "1"}
    other = type(OWN)(str(tmp_path / "python"), "2.0", WIRE_VERSION)
    assert other.environment(variables) == {"DRAY_PORT": "1"}
    assert OWN.environment(variables) == variables

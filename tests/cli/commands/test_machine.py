"""`dray machine check`: what it is given, and what comes of a controller that is not there."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

Call = Callable[..., tuple[int, str, str]]

MAPPING = 'url: opc.tcp://127.0.0.1:9\nsignals: {pieces: {node: "ns=2;s=x"}}\n'
"""A controller where nobody listens."""

STORE = 'url: opc.tcp://127.0.0.1:9\nsignals: {dock_permit: {node: "ns=2;s=x"}}\n'
"""The same of a storage's dock."""


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (("M1",), "--mapping: a controller's body needs the file that names its signals"),
        (("M99", "--mapping", "{file}"), "NAME: there is no 'M99'"),
        (("M1", "--mapping", "nothing.yaml"), "nothing.yaml cannot be read"),
    ],
)
def test_what_cannot_be_used_is_said(
    call: Call, tmp_path: Path, arguments: tuple[str, ...], why: str
) -> None:
    file = tmp_path / "mapping.yaml"
    file.write_text(MAPPING, encoding="utf-8")
    code, _, told = call("machine", "check", *(argument.format(file=file) for argument in arguments))
    assert code == 2
    assert why in told


def test_a_controller_that_is_not_there_fails_the_check_and_is_in_the_report(
    call: Call, tmp_path: Path
) -> None:
    file, report = tmp_path / "mapping.yaml", tmp_path / "report.md"
    file.write_text(MAPPING, encoding="utf-8")
    code, *_ = call("machine", "check", "M1", "--mapping", str(file), "--out", str(report))
    assert code == 1
    assert "NO   connection" in report.read_text(encoding="utf-8")


def test_a_report_that_cannot_be_written_is_told_before_the_machine_is_asked(
    call: Call, tmp_path: Path
) -> None:
    file = tmp_path / "mapping.yaml"
    file.write_text(MAPPING, encoding="utf-8")
    code, out, told = call(
        "machine", "check", "M1", "--mapping", str(file), "--out", str(tmp_path / "no/r.md")
    )
    assert (code, out) == (1, "")
    assert "choose another file for --out" in told


@pytest.mark.parametrize(
    ("text", "option", "why"),
    [
        (MAPPING, (), "signals.pieces: a storage has dock_ready, dock_permit, dock_vehicle, alive only"),
        (STORE, ("--cycle",), "--cycle: S1 is a storage: it makes nothing"),
    ],
)
def test_what_is_no_storages_is_said(
    call: Call, tmp_path: Path, text: str, option: tuple[str, ...], why: str
) -> None:
    file = tmp_path / "mapping.yaml"
    file.write_text(text, encoding="utf-8")
    code, _, told = call("machine", "check", "S1", "--mapping", str(file), *option)
    assert code == 2
    assert why in told


def test_the_dock_of_a_storage_is_checked_without_any_count_of_pieces(call: Call, tmp_path: Path) -> None:
    file = tmp_path / "mapping.yaml"
    file.write_text(STORE, encoding="utf-8")
    code, said, _ = call("machine", "check", "S1", "--mapping", str(file))
    assert code == 1
    assert "NO   connection" in said

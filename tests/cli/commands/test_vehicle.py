"""`dray vehicle`: what is missing is said; a dialogue is played again."""

from __future__ import annotations

import sys
from pathlib import Path

from typer.testing import CliRunner

sys.path.insert(0, str(Path(__file__).parents[2] / "simulation/kits"))
sys.path.insert(0, str(Path(__file__).parents[2] / "adapters/vda5050"))
import pytest
from vda_rig import PROFILE, Rig
from yard import LIGHT, PLANT, drive

from dray.adapters.vda5050.dialogue import Head, Recorder
from dray.cli import app
from dray.errors import SettingsError, UnavailableError


@pytest.fixture
def dialogue(tmp_path: Path) -> Path:
    path = tmp_path / "d.jsonl"
    rig = Rig(PROFILE, linked=False)
    recorder = Recorder(path, Head("ATV1", PLANT.id, LIGHT.id, PROFILE))
    rig.body.record = recorder.write
    rig.link()
    rig.do(drive("west", "middle"), for_s=30.0)
    recorder.close()
    return path


@pytest.fixture(autouse=True)
def in_the_yard(monkeypatch: pytest.MonkeyPatch) -> None:
    """The yard is too small to be a plant file."""
    monkeypatch.setattr("dray.cli.commands.plant.chosen_plant", lambda _file: PLANT)


def test_a_dialogue_is_played_again(dialogue: Path) -> None:
    done = CliRunner().invoke(app, ["vehicle", "replay", str(dialogue)])
    assert done.exit_code == 0, done.output
    assert "-> Tell       WayDone" in done.stdout
    assert done.stdout.splitlines()[-1].endswith("words of ours, all as recorded")


def test_another_profile_says_otherwise(dialogue: Path, tmp_path: Path) -> None:
    profile = tmp_path / "p.yaml"
    profile.write_text("version: '3.0'\n", encoding="utf-8")
    options = ["--profile", str(profile), "--quiet"]
    done = CliRunner().invoke(app, ["vehicle", "replay", str(dialogue), *options])
    assert done.exit_code == 1
    assert done.stdout.startswith("recorded: ")


def test_a_report_that_cannot_be_written_is_told_before_the_vehicle_is_asked(tmp_path: Path) -> None:
    options = ["--broker", "mqtt://127.0.0.1:1", "--manufacturer", "ACME", "--serial", "1", "--drive", "-"]
    out = ["--out", str(tmp_path / "no/report.md")]
    with pytest.raises(UnavailableError, match=r"there is no folder .*choose another file for --out"):
        CliRunner().invoke(app, ["vehicle", "check", *options, *out], catch_exceptions=False)


@pytest.mark.parametrize("command", [["check"], ["record", "x.jsonl"]])
def test_what_is_missing_is_said(command: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SettingsError, match="--broker: a body by VDA 5050 needs it"):
        CliRunner().invoke(app, ["vehicle", *command], catch_exceptions=False)

"""The command line: exit codes and messages. What the commands do is tested in their own rooms."""

from __future__ import annotations

import json
import socket
import sqlite3
import subprocess
import sys
from contextlib import closing
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest
import typer

from dray import __version__
from dray.cli import app
from dray.messages import WIRE_VERSION
from dray_sim import scenarios
from dray_sim.run.evidence import Check, Evidence
from dray_sim.run.site import Site

PLANT_FILE = Path(str(files("dray.plant") / "default.yaml"))


class Outcome:
    def __init__(self, code: int, out: str, err: str) -> None:
        self.code, self.out, self.err = code, out, err


@pytest.fixture
def dray(call, monkeypatch, tmp_path):
    """Run the command line in this process, in an empty folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "160")

    def run(*args: str | Path) -> Outcome:
        return Outcome(*call(*args))

    return run


def test_the_version_is_told(dray) -> None:
    assert dray("--version").out == f"dray {__version__}, wire version {WIRE_VERSION}\n"


def test_help_names_every_command_and_loads_nothing_heavy() -> None:
    """A cold process: what help needs is seen in `sys.modules`."""
    script = (
        "import sys; sys.argv = ['dray', '--help']\n"
        "from dray.cli import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "print([name for name in ('fastapi', 'sqlalchemy', 'uvicorn', 'asyncio', 'msgspec') if name in sys.modules])"
    )
    out = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout
    own = ("up", "fault", "bench", "sim", "plant", "db", "user", "key", "link", "certs", "wire")
    processes = ("fleet", "agent", "strategist", "floor", "gateway", "historian")
    for command in (*own, *processes):
        assert f" {command} " in out
    assert out.splitlines()[-1] == "[]"


INTERRUPTED_WHILE_LOADING = """
import runpy, sys


class Impatience:
    def find_spec(self, name, path, target=None):
        if name == "typer":
            raise KeyboardInterrupt


sys.meta_path.insert(0, Impatience())
sys.argv = ["dray", "--version"]
runpy.run_module("dray", run_name="__main__")
"""


def test_whoever_is_impatient_gets_no_traceback() -> None:
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPTED_WHILE_LOADING], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "")


def test_an_unknown_command_is_refused_with_exit_code_2(dray) -> None:
    assert dray("fly").code == 2


# --- plant check -------------------------------------------------------------------------------------


def test_a_good_plant_is_described(dray) -> None:
    done = dray("plant", "check", PLANT_FILE)
    assert done.code == 0, done.err
    assert "12 machines" in done.out


def test_every_fault_of_a_plant_is_named_with_exit_code_2(dray, tmp_path) -> None:
    broken = tmp_path / "broken.yaml"
    text = PLANT_FILE.read_text()
    broken.write_text(text.replace("width_m: 60", "width_m: -60").replace("height_m: 40", "height_m: high"))
    done = dray("plant", "check", broken)
    assert done.code == 2
    assert done.out == ""
    assert "width_m" in done.err
    assert "height_m" in done.err
    assert f"{broken}:" in done.err
    assert "Traceback" not in done.err


def test_a_plant_file_that_is_not_there_is_named(dray) -> None:
    done = dray("plant", "check", "nowhere.yaml")
    assert done.code == 2
    assert "nowhere.yaml" in done.err


# --- sim ---------------------------------------------------------------------------------------------


def test_scenarios_are_listed(dray) -> None:
    done = dray("sim", "list")
    assert done.code == 0
    assert "day" in done.out


def test_an_unknown_scenario_names_those_that_there_are(dray) -> None:
    done = dray("sim", "run", "night")
    assert done.code == 2
    assert "'night'" in done.err
    assert "day" in done.err


def test_a_report_that_cannot_be_written_is_said_in_one_line(dray, monkeypatch) -> None:
    stub_scenario(monkeypatch)
    done = dray("sim", "run", "stub", "--json", "no/such/folder/report.json")
    assert done.code == 1
    assert done.err.count("\n") == 1


def test_a_report_is_printed_and_written_as_json(dray, monkeypatch, tmp_path) -> None:
    stub_scenario(monkeypatch)
    done = dray("sim", "run", "stub", "--seed", "7", "--json", "report.json")
    assert done.code == 0
    assert "stub, seed 7: held" in done.out
    written = json.loads((tmp_path / "report.json").read_text())
    assert written["seed"] == 7
    assert written["checks"] == [{"name": "Water is wet", "held": True, "figure": "very"}]


def test_a_claim_that_does_not_hold_ends_with_exit_code_1_and_names_the_check(dray, monkeypatch) -> None:
    stub_scenario(monkeypatch, held=False)
    done = dray("sim", "run", "stub", "--seed", "7")
    assert done.code == 1
    assert "did not hold" in done.out
    assert "Water is wet: no (very)" in done.err
    assert "dray sim run stub --seed 7" in done.err


def test_a_broken_invariant_ends_with_exit_code_1_and_the_command_that_replays_it(dray, monkeypatch) -> None:
    stub_scenario(monkeypatch, invariants="invariant 2 is broken")
    done = dray("sim", "run", "stub", "--seed", "7")
    assert done.code == 1
    assert "invariant 2 is broken" in done.err
    assert "dray sim run stub --seed 7" in done.err


class Stub:
    name, shows, source = "stub", "Nothing.", "ours"

    def __init__(self, held: bool, invariants: str) -> None:
        self._held, self._invariants = held, invariants

    def run(self, seed: int, site: Site) -> Evidence:
        assert not site.is_other
        return Evidence(
            scenario="stub",
            seed=seed,
            source="ours",
            claim="Water is wet.",
            story="It is poured out.",
            held=self._held and self._invariants == "held",
            checks=(Check("Water is wet", self._held, "very"),),
            tables=(),
            measured={},
            invariants=self._invariants,
            trace="",
        )


def stub_scenario(monkeypatch, *, held: bool = True, invariants: str = "held") -> None:
    monkeypatch.setattr(scenarios, "SCENARIOS", {"stub": Stub(held, invariants)})


# --- db ----------------------------------------------------------------------------------------------


def test_a_database_is_created_and_upgrading_it_again_changes_nothing(dray, tmp_path) -> None:
    for _ in range(2):
        done = dray("db", "upgrade", "--db", "sqlite:///new.db")
        assert done.code == 0, done.err
        assert "up to date" in done.out
    with closing(sqlite3.connect(tmp_path / "new.db")) as database:
        tables = database.execute("SELECT name FROM sqlite_master").fetchall()
    assert ("orders",) in tables


def test_a_database_that_cannot_be_written_is_said_with_a_remedy(dray) -> None:
    done = dray("db", "upgrade", "--db", "sqlite:///no/such/folder/dray.db")
    assert done.code == 1
    assert "no/such/folder/dray.db" in done.err
    assert "--db" in done.err
    assert "Traceback" not in done.err


def test_a_url_of_no_database_names_the_option(dray) -> None:
    done = dray("db", "upgrade", "--db", "mongo:///x")
    assert done.code == 2
    assert done.err.startswith("dray: --db:")


# --- up ----------------------------------------------------------------------------------------------


def test_a_port_in_use_is_said_before_anything_starts(dray) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        done = dray("up", "--port", str(port))
    assert done.code == 1
    assert str(port) in done.err
    assert "--port" in done.err
    assert not Path("dray.db").exists()


@pytest.mark.parametrize(
    ("option", "value"), [("--speed", "0"), ("--speed", "-1"), ("--speed", "nan"), ("--port", "70000")]
)
def test_an_option_out_of_range_is_refused(dray, option, value) -> None:
    done = dray("up", option, value)
    assert done.code == 2
    assert option in done.err


NUMBERS = {
    ("up", "--speed"): "above 0",
    ("fleet", "up", "--speed"): "from 0.1 to 50",
    ("fleet", "update", "--python", "python", "--patience"): "of at least 1",
    ("fleet", "kill", "ATV1", "--away"): "of at least 1",
    ("sim", "run", "day", "--load"): "from 0.001 to 10",
    ("sim", "run", "day", "--hours"): "from 0.05 to 2000",
    ("sim", "plants", "--hours"): "from 0.1 to 1000",
    ("plant", "check", "workshop", "--load"): "from 0 to 1",
    ("plant", "new", "--yes", "--cycle"): "from 1 to 36000",
}


@pytest.mark.parametrize("text", ["nan", "inf", "1e400", "-1", "", "0,5"])
@pytest.mark.parametrize("command", NUMBERS, ids=" ".join)
def test_what_is_no_number_is_refused_with_what_is_allowed(dray, command, text) -> None:
    done = dray(*command, text)
    assert done.code == 2
    said = " ".join(done.err.replace("│", " ").split())
    assert f"{text!r}: give a number {NUMBERS[command]}" in said
    assert command[-1] in said


def test_a_scenario_that_there_is_not_is_refused_with_those_that_there_are(dray) -> None:
    done = dray("up", "--scenario", "case-7")
    assert done.code == 2
    assert "case-7" in done.err
    assert "case-4-promised" in done.err
    done = dray("up", "--scenario", "case-4", "--plant", "workshop")
    assert done.code == 2
    assert "--plant" in done.err
    assert not Path("dray-scenario.db").exists()


@pytest.mark.parametrize("speed", ["0", "51", "nan"])
def test_a_speed_that_no_fleet_can_have_is_refused(dray, speed) -> None:
    done = dray("fleet", "up", "--speed", speed)
    assert done.code == 2
    assert "--speed" in done.err
    assert not Path("fleet").exists()


def test_a_fleet_whose_port_is_in_use_says_so_before_anything_is_made(dray) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        done = dray("fleet", "up", "--port", str(port))
    assert done.code == 1
    assert f"port {port} on 127.0.0.1" in done.err
    assert "--port" in done.err
    assert {each.name for each in Path("fleet").iterdir()} == {"fleet.lock", "logs"}


@pytest.mark.parametrize("command", [("up",), ("fleet", "up")])
def test_the_plant_file_of_the_environment_counts(dray, monkeypatch, tmp_path, command) -> None:
    (tmp_path / "broken.yaml").write_text("plant: [")
    monkeypatch.setenv("DRAY_PLANT_FILE", "broken.yaml")
    done = dray(*command, "--port", "0")
    assert done.code == 2
    assert "broken.yaml" in done.err


def test_up_refuses_a_broken_plant_file(dray, tmp_path) -> None:
    (tmp_path / "broken.yaml").write_text("plant: [")
    done = dray("up", "--plant", "broken.yaml", "--port", "0")
    assert done.code == 2
    assert "broken.yaml" in done.err


def parameters() -> list[tuple[str, str]]:
    """Every option and argument of every command, with its help."""
    found: list[tuple[str, str]] = []

    def walk(command: Any, path: str) -> None:
        own = (each for each in command.params if each.name != "help")
        found.extend((f"{path} {each.opts[0]}", getattr(each, "help", None) or "") for each in own)
        for name, inner in getattr(command, "commands", {}).items():
            walk(inner, f"{path} {name}")

    walk(typer.main.get_command(app), "dray")
    return found


def test_every_option_and_argument_says_what_it_is() -> None:
    told = parameters()
    assert len(told) > 200
    assert [name for name, text in told if not text.endswith(".")] == [], "no text, or no sentence"
    # A text that begins in the middle names no thing: of what, which, how many of what?
    halves = ("Of ", "Likewise", "Its URL", "How long", "How many", "Where to", "Which ones")
    assert [name for name, text in told if text.startswith(halves)] == []

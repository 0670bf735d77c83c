"""`dray sim explore`: what it prints, and how it ends. What is searched is tested with the simulator."""

from __future__ import annotations

import json
import re
from functools import partial

import pytest

from dray_sim.checks.bounds import Bounds
from dray_sim.explore.code_key import CodeKey


@pytest.fixture
def explore(call, monkeypatch, tmp_path):
    """Run the command in this process; returns its exit code, stdout and stderr."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "160")
    return partial(call, "sim", "explore")


@pytest.fixture
def impatient(monkeypatch) -> None:
    """No task may take any time, so every run breaks."""
    monkeypatch.setattr(Bounds, "task_s", lambda *_: 1.0)


@pytest.mark.slow
def test_a_search_that_holds_sums_up(explore, tmp_path) -> None:
    code, out, _ = explore("--seeds", "1:3", "--profile", "faultless", "--jobs", "1", "--json", "found.json")
    assert code == 0
    assert "2 seeds: none broken" in out
    assert "seeds a minute and core" in out
    summary = json.loads((tmp_path / "found.json").read_text())
    assert summary["runs"] == 2
    assert summary["violations"] == []


def test_a_search_with_a_ledger_goes_on_and_its_summary_counts_all(explore, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr("dray_sim.explore.code_key.played_code", lambda: CodeKey("0123456", "0" * 16))
    options = ("--profile", "faultless", "--no-traffic", "--jobs", "1", "--ledger", "kept/searches.jsonl")
    code, out, _ = explore("--seeds", "1:2", *options)
    assert code == 0
    assert "1 seeds: none broken" in out

    code, out, _ = explore("--seeds", "1:3", *options, "--json", "found.json")
    assert code == 0
    assert "2 seeds, 1 of them played before: none broken" in out
    assert json.loads((tmp_path / "found.json").read_text())["before"] == 1
    lines = (tmp_path / "kept/searches.jsonl").read_text(encoding="utf-8").splitlines()
    assert [json.loads(line)["outcome"]["seed"] for line in lines] == [1, 2]
    assert {json.loads(line)["commit"] for line in lines} == {"0123456"}


def test_a_ledger_that_is_something_else_is_told_as_such(explore, tmp_path) -> None:
    (tmp_path / "notes").write_text("mine", encoding="utf-8")
    code, out, err = explore("--seeds", "1:2", "--ledger", "notes")
    assert code == 2
    assert out == ""
    assert "--ledger: notes is no ledger of a search" in err


def test_a_ledger_is_not_for_one_seed(explore, tmp_path) -> None:
    code, out, err = explore("--seed", "1", "--ledger", "kept.jsonl")
    assert (code, out) == (2, "")
    assert "--ledger: is for many seeds" in err


@pytest.mark.parametrize("file", ["nowhere/found.json", "."])
def test_a_summary_that_cannot_be_written_is_told_before_a_seed_is_played(
    explore, monkeypatch, file: str
) -> None:
    monkeypatch.setattr("dray_sim.explore.search.search", lambda *_, **__: pytest.fail("it was played"))
    code, _, err = explore("--seeds", "1:3", "--json", file)
    assert code == 1
    assert "choose another file for --json" in err


@pytest.mark.campaign
def test_a_violation_comes_with_its_story_and_the_command_that_replays_it(explore, impatient) -> None:
    code, out, _ = explore("--seeds", "7:9", "--jobs", "1")
    assert code == 1
    assert "invariant 1 is broken" in out
    replay = next(line for line in out.splitlines() if line.startswith("replay: "))
    seed = replay.split(" --seed ")[1].split()[0]
    assert replay == f"replay: dray sim explore --seed {seed} --traffic"

    code, again, _ = explore("--seed", seed)
    assert code == 1
    assert next(line for line in out.splitlines() if "is broken at" in line) in again
    assert f"seed {seed}: " in again
    assert re.search(r"^ +[\d.]+ s  \w+ ", again, re.MULTILINE)


def test_a_replay_says_what_the_seed_stands_for(explore) -> None:
    code, out, _ = explore("--seed", "2", "--profile", "faultless", "--no-traffic")
    assert code == 0
    assert "machine" in out.splitlines()[0]
    assert "held" in out.splitlines()
    assert "trace " in out


@pytest.mark.parametrize("seeds", ["7", "5:", "a:b", "-1:4", "9:9", "9:3"])
def test_seeds_that_are_none_are_told_as_such(explore, seeds: str) -> None:
    code, out, err = explore(f"--seeds={seeds}")
    assert code == 2
    assert out == ""
    assert "--seeds" in err
    assert seeds in err


def test_an_unknown_profile_is_told_with_the_known_ones(explore) -> None:
    code, _, err = explore("--seed", "1", "--profile", "storm")
    assert code == 2
    assert "'storm'" in err
    assert "links" in err


def test_a_search_that_is_stopped_by_hand_tells_what_it_has_seen(explore, monkeypatch) -> None:
    def stop(_self: object, _plant: object, _habits: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Bounds, "__init__", stop)
    code, out, _ = explore("--seeds", "0:4", "--jobs", "1")
    assert code == 1
    assert "0 seeds of 4, stopped by hand" in out

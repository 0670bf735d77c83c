"""The ledger of campaigns gets the rows of searches: which seeds of a profile were played on which code, and what broke."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import msgspec
import pytest

from dray_sim.explore.ledger import Entry
from dray_sim.explore.outcome import Outcome

RECORD_SEARCHES = str(Path(__file__).parents[1] / "tools/record_searches.py")

BEFORE = """# Campaigns

| day | commit | campaign | seen | seeds |
| --- | --- | --- | --- | --- |
| 2026-11-20 | 1111111 | `tests/test_it.py` | 3 of 3 tests held |  |
| 2026-11-18 | 1111111 | `dray sim explore --profile calls` | 1 of 1 seeds held; 1.0 h of factory time, 3 transports | 5 to 5 |
"""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs/campaigns.md").write_text(BEFORE, encoding="utf-8")
    return tmp_path


def keep(project: Path, *entries: Entry) -> None:
    with (project / "searches.jsonl").open("ab") as file:
        file.writelines(msgspec.json.encode(entry) + b"\n" for entry in entries)


def entry(
    seed: int,
    *,
    code: str = "new",
    commit: str = "2222222",
    day: str = "2026-11-21",
    profile: str = "calls",
    broken: str = "",
    traffic: bool = True,
) -> Entry:
    outcome = Outcome(seed, profile, broken, 3600.0, 3, 0, 0, 100, {}, traffic=traffic)
    return Entry(code, commit, day, 4.0, outcome)


def record(project: Path) -> list[str]:
    command = [sys.executable, RECORD_SEARCHES, "searches.jsonl"]
    done = subprocess.run(command, cwd=project, capture_output=True, text=True, check=True)
    text = (project / "docs/campaigns.md").read_text(encoding="utf-8")
    rows = [line for line in text.splitlines() if line.startswith("| 2")]
    assert all(row in rows for row in done.stdout.splitlines())
    return rows


def test_each_profile_and_code_gets_its_row_and_the_newest_day_stands_first(project: Path) -> None:
    keep(
        project,
        *(entry(seed, code="old", commit="1111111", day="2026-11-19") for seed in (7, 5, 6)),
        entry(9, code="old", commit="1111111", day="2026-11-19", broken="invariant 1 is\nbroken | here"),
        entry(9),
        entry(3, traffic=False),
    )
    old = (
        "| 2026-11-19 | 1111111 | `dray sim explore --profile calls` | 3 of 4 seeds held; "
        "9 broke: invariant 1 is broken / here; 4.0 h of factory time, 12 transports | 5 to 7, 9 to 9 |"
    )
    without = (
        "| 2026-11-21 | 2222222 | `dray sim explore --profile calls --no-traffic` | "
        "1 of 1 seeds held; 1.0 h of factory time, 3 transports | 3 to 3 |"
    )
    new = (
        "| 2026-11-21 | 2222222 | `dray sim explore --profile calls` | "
        "1 of 1 seeds held; 1.0 h of factory time, 3 transports | 9 to 9 |"
    )
    tests = "| 2026-11-20 | 1111111 | `tests/test_it.py` | 3 of 3 tests held |  |"
    assert record(project) == [without, new, tests, old]
    assert record(project) == [without, new, tests, old]


def test_a_row_grows_with_the_seeds_that_are_played_and_knows_the_commit_once_there_is_one(
    project: Path,
) -> None:
    keep(project, entry(1, commit="1111111+"), entry(2, commit="1111111+"))
    first = record(project)[0]
    assert "| 1111111+ | `dray sim explore --profile calls` | 2 of 2 seeds held;" in first
    keep(project, entry(3, commit="2222222"), entry(3, commit="2222222"))
    second, *others = record(project)
    assert not any("1111111+" in row for row in others)
    assert "| 2222222 | `dray sim explore --profile calls` | 3 of 3 seeds held;" in second
    assert second.endswith("| 1 to 3 |")


def test_many_violations_are_told_in_few_words(project: Path) -> None:
    keep(project, *(entry(seed, broken=f"why {seed}") for seed in range(7)))
    assert (
        "| 0 of 7 seeds held; 0 broke: why 0; 1 broke: why 1; 2 broke: why 2; 3 broke: why 3; 4 broke: why 4; "
        "so did 5, 6; 7.0 h of factory time"
    ) in record(project)[0]


def test_without_a_ledger_nothing_is_written(project: Path) -> None:
    command = [sys.executable, RECORD_SEARCHES, "searches.jsonl"]
    done = subprocess.run(command, cwd=project, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "searches.jsonl" in done.stderr
    assert (project / "docs/campaigns.md").read_text(encoding="utf-8") == BEFORE


def test_a_file_without_a_played_seed_is_told_and_writes_nothing(project: Path) -> None:
    (project / "searches.jsonl").write_text("my notes\n", encoding="utf-8")
    command = [sys.executable, RECORD_SEARCHES, "searches.jsonl"]
    done = subprocess.run(command, cwd=project, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "no played seed in searches.jsonl" in done.stderr
    assert (project / "docs/campaigns.md").read_text(encoding="utf-8") == BEFORE

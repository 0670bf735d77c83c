"""A search that was ended goes on: each played seed is in the ledger, and counts for the code that has played it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import msgspec
import pytest

from dray.errors import SettingsError, UnavailableError
from dray_sim.explore import search as searching
from dray_sim.explore.code_key import PLAYED, ROOT, CodeKey, code_key, played_code
from dray_sim.explore.ledger import HEAD, Entry, Ledger, read_ledger
from dray_sim.explore.outcome import Outcome
from dray_sim.explore.search import search

CODE = CodeKey("0123456", "0123456789abcdef")

SEARCH = """
import sys
from pathlib import Path
from dray_sim.explore.code_key import CodeKey
from dray_sim.explore.ledger import Ledger
from dray_sim.explore.search import search

if __name__ == "__main__":
    ledger = Ledger(Path(sys.argv[1]), CodeKey("0123456", "0123456789abcdef"))
    search(0, 10_000, profile="faultless", jobs=2, ledger=ledger)
"""


@pytest.fixture
def played(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """No run is played: the seeds that would have been; every seventh one breaks."""
    seeds: list[int] = []

    def try_seed(seed: int, profile: str, *, traffic: bool) -> Outcome:
        seeds.append(seed)
        return outcome(seed, profile, traffic=traffic)

    monkeypatch.setattr(searching, "try_seed", try_seed)
    return seeds


@pytest.fixture
def ledger(tmp_path: Path) -> Ledger:
    return Ledger(tmp_path / "kept/searches.jsonl", CODE)


def outcome(seed: int, profile: str = "all", *, traffic: bool = True) -> Outcome:
    broken = f"invariant 1 is broken at {seed}" if seed % 7 == 0 else ""
    return Outcome(seed, profile, broken, 3600.0, 3, 2, 1, 100, {"Crashed": 1}, traffic=traffic)


def test_a_search_that_was_stopped_goes_on_and_counts_all(ledger: Ledger, played: list[int]) -> None:
    def stop(outcome: Outcome) -> None:
        if outcome.seed == 13:
            signal.raise_signal(signal.SIGTERM)

    first = search(10, 20, traffic=True, ledger=ledger, progress=stop)
    assert first.interrupted
    assert played == [10, 11, 12, 13]

    told: list[int] = []
    whole = search(8, 20, traffic=True, ledger=ledger, progress=lambda outcome: told.append(outcome.seed))
    assert played == [10, 11, 12, 13, 8, 9, *range(14, 20)]
    assert told == list(range(8, 20))
    assert (whole.runs, whole.before, whole.broken, whole.transports) == (12, 4, 1, 36)
    assert [found.seed for found in whole.violations] == [14]

    again = search(8, 20, traffic=True, ledger=ledger)
    assert msgspec.structs.replace(again, before=4) == whole
    assert len(played) == 12


def test_what_other_code_or_another_profile_has_played_does_not_count(
    ledger: Ledger, played: list[int]
) -> None:
    search(1, 3, traffic=True, ledger=ledger)
    other = Ledger(ledger.path, CodeKey("7654321", "fedcba9876543210"))
    assert search(1, 3, traffic=True, ledger=other).before == 0
    assert search(1, 3, traffic=False, ledger=ledger).before == 0
    assert search(1, 3, profile="links", traffic=True, ledger=ledger).before == 0
    assert played == [1, 2] * 4
    assert search(1, 3, traffic=True, ledger=ledger).before == 2


def test_a_line_that_was_torn_anywhere_costs_only_its_own_seed(ledger: Ledger, played: list[int]) -> None:
    search(1, 3, traffic=True, ledger=ledger)
    whole = ledger.path.read_bytes()
    first_line = whole.index(b"\n") + 1
    for end in range(first_line, len(whole)):
        ledger.path.write_bytes(whole[:end])
        played.clear()
        summary = search(1, 4, traffic=True, ledger=ledger)
        # Without its line break alone, the last line is whole.
        assert played == ([3] if end == len(whole) - 1 else [2, 3]), end
        assert (summary.runs, summary.broken) == (3, 0)
        assert [entry.outcome.seed for entry in read_ledger(ledger.path)] == [1, 2, 3]


def test_a_first_line_that_was_torn_is_no_other_file(ledger: Ledger, played: list[int]) -> None:
    ledger.path.parent.mkdir()
    for end in range(len(HEAD) + 1):
        ledger.path.write_bytes(HEAD[:end])
        assert search(1, 2, traffic=True, ledger=ledger).before == 0
        assert search(1, 2, traffic=True, ledger=ledger).before == 1


def test_a_file_that_is_no_ledger_is_refused_and_left_as_it_was(ledger: Ledger, played: list[int]) -> None:
    ledger.path.parent.mkdir()
    ledger.path.write_text("my notes\n", encoding="utf-8")
    with pytest.raises(SettingsError, match=r"searches\.jsonl is no ledger"):
        search(1, 2, ledger=ledger)
    assert ledger.path.read_text(encoding="utf-8") == "my notes\n"
    with pytest.raises(UnavailableError, match="choose another file for --ledger"):
        search(1, 2, ledger=Ledger(ledger.path.parent, CODE))
    assert played == []


@pytest.mark.parametrize("text", ['{\n  "first": 0\n}\n', "\nmy notes\n", "{\n", '{"co\n\nmy notes'])
def test_a_file_that_begins_like_a_ledger_and_is_none_is_left_as_it_was(
    ledger: Ledger, played: list[int], text: str
) -> None:
    ledger.path.parent.mkdir()
    ledger.path.write_text(text, encoding="utf-8")
    if text == "{\n":  # It may be a torn line.
        assert search(1, 2, ledger=ledger).runs == 1
        return
    with pytest.raises(SettingsError, match="is no ledger of a search: choose another file"):
        search(1, 2, ledger=ledger)
    assert ledger.path.read_text(encoding="utf-8") == text


def test_a_line_is_small_and_tells_its_code(ledger: Ledger) -> None:
    ledger.begin()
    ledger.add(outcome(7), 4.5)
    [entry] = read_ledger(ledger.path)
    assert (entry.commit, entry.code, entry.took_s, entry.outcome) == (*CODE, 4.5, outcome(7))
    assert ledger.path.read_bytes().startswith(HEAD)
    assert ledger.played("all", traffic=True) == {7: entry}


@pytest.mark.slow
def test_a_search_that_is_killed_has_kept_what_each_of_its_processes_has_played(ledger: Ledger) -> None:
    script = ledger.path.parent.with_suffix(".py")
    script.write_text(SEARCH, encoding="utf-8")
    lines: list[Entry] = []
    with subprocess.Popen([sys.executable, script, ledger.path], start_new_session=True) as process:
        while len(lines) < 3 and process.poll() is None:
            with suppress(subprocess.TimeoutExpired):
                process.wait(0.02)
            lines = list(read_ledger(ledger.path)) if ledger.path.exists() else []
        os.killpg(process.pid, signal.SIGKILL)
    assert len(lines) >= 3
    kept = ledger.played("faultless", traffic=False)
    assert len(kept) >= 3
    last = max(kept) + 1
    # No seed has to be waited for: those between were being played, and are played now.
    summary = search(0, last, profile="faultless", ledger=ledger)
    assert (summary.runs, summary.before, summary.broken) == (last, len(kept), 0)


def test_code_has_another_key_when_a_file_of_it_changes(tmp_path: Path) -> None:
    def git(*arguments: str) -> None:
        names = ("-c", "user.name=a", "-c", "user.email=a@example.invalid")
        subprocess.run(["git", *names, *arguments], cwd=tmp_path, check=True, capture_output=True)

    for folder in ("code", "code/left-out", "other"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "a.py").write_text("1", encoding="utf-8")
    git("init", "--quiet")
    git("add", "--all")
    git("commit", "--quiet", "--message", "a")
    paths = ("code", ":(exclude)code/left-out", "not-there")
    before = code_key(tmp_path, paths)
    assert not before.commit.endswith("+")

    for folder in ("code/left-out", "other"):
        (tmp_path / folder / "a.py").write_text("2", encoding="utf-8")
    assert code_key(tmp_path, paths) == before

    (tmp_path / "code/b.py").write_text("1", encoding="utf-8")
    new = code_key(tmp_path, paths)
    assert new.commit == f"{before.commit}+"
    (tmp_path / "code/b.py").write_text("2", encoding="utf-8")
    changed = code_key(tmp_path, paths)
    assert len({before.digest, new.digest, changed.digest}) == 3

    git("add", "--all")
    git("commit", "--quiet", "--message", "b")
    committed = code_key(tmp_path, paths)
    assert committed.digest == changed.digest
    assert committed.commit not in (before.commit, changed.commit)

    (tmp_path / "code/b.py").unlink()
    gone = code_key(tmp_path, paths)
    assert gone.commit == f"{committed.commit}+"
    (tmp_path / "code/b.py").write_text("", encoding="utf-8")
    assert len({gone.digest, code_key(tmp_path, paths).digest, committed.digest}) == 3


def test_code_without_a_repository_keeps_no_seeds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dray_sim.explore.code_key.ROOT", tmp_path)
    with pytest.raises(SettingsError, match="--ledger: Dray must run from its git repository"):
        played_code()


PRINT_MODULES = """
import sys
import dray_sim.explore.search
print(*(name for name in sys.modules if name.startswith("dray")))
"""


def test_a_search_imports_nothing_that_its_key_leaves_out() -> None:
    left_out = tuple(
        path.removeprefix(":(exclude)").removeprefix("backend/").removeprefix("sim/").replace("/", ".")
        for path in PLAYED
        if path.startswith(":(exclude)")
    )
    assert left_out == ("dray.cli", "dray.gateway", "dray.store", "dray_sim.bench")
    assert all((ROOT / path).exists() for path in PLAYED if not path.startswith(":"))
    done = subprocess.run([sys.executable, "-c", PRINT_MODULES], check=True, capture_output=True, text=True)
    assert [name for name in done.stdout.split() if name.startswith(left_out)] == []

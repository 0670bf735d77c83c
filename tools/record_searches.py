"""Write the rows of searches into `docs/campaigns.md`: which seeds of a profile were played on which code, and what broke.

Usage: python tools/record_searches.py LEDGER...

A ledger is a file that `dray sim explore --ledger` has written. It may have seeds of several profiles and codes: each of
them gets its row. Called again after more seeds were played, it replaces the row.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from itertools import chain
from pathlib import Path

from run_campaign import put_rows

from dray.errors import DrayError
from dray_sim.explore.ledger import Entry, read_ledger

TOLD = 5
"""Violations that a row tells in words; of further ones it names the seeds."""


def main(ledgers: list[str]) -> int:
    """Write the rows; 0 when that was done."""
    if not ledgers:
        print(f"{__doc__}", file=sys.stderr)
        return 2
    try:
        entries = list(chain.from_iterable(read_ledger(Path(ledger)) for ledger in ledgers))
    except DrayError as error:
        print(error, file=sys.stderr)
        return 1
    if not entries:
        print(
            f"no played seed in {', '.join(ledgers)}: name files of dray sim explore --ledger",
            file=sys.stderr,
        )
        return 1
    rows = rows_of(entries)
    # A search that began before its code was committed has a row of that time.
    put_rows(rows, gone={(entry.commit, _name(entry)) for entry in entries})
    for row in rows.values():
        print(row)
    return 0


def rows_of(entries: Iterable[Entry]) -> dict[tuple[str, str], str]:
    """The rows by commit and search, the newest first."""
    searches: dict[tuple[str, str], dict[int, Entry]] = {}
    for entry in entries:
        search = (entry.code, _name(entry))
        # The newest search last, and each seed once: it was played twice when two searches ran at once.
        played = searches[search] = searches.pop(search, {})
        played[entry.outcome.seed] = entry
    rows: dict[tuple[str, str], str] = {}
    for (_, name), played in reversed(searches.items()):
        commit = min((entry.commit for entry in played.values()), key=lambda commit: commit.endswith("+"))
        rows.setdefault((commit, name), _row(commit, name, [played[seed] for seed in sorted(played)]))
    return rows


def _name(entry: Entry) -> str:
    outcome = entry.outcome
    return f"dray sim explore --profile {outcome.profile}" + ("" if outcome.traffic else " --no-traffic")


def _row(commit: str, name: str, played: list[Entry]) -> str:
    outcomes = [entry.outcome for entry in played]
    broken = [outcome for outcome in outcomes if outcome.broken]
    hours = sum(outcome.duration_s for outcome in outcomes) / 3600.0
    transports = sum(outcome.transports for outcome in outcomes)
    seen = f"{len(outcomes) - len(broken)} of {len(outcomes)} seeds held"
    for outcome in broken[:TOLD]:
        seen += f"; {outcome.seed} broke: {' '.join(outcome.broken.split())}".replace("|", "/")
    if len(broken) > TOLD:
        seen += "; so did " + ", ".join(str(outcome.seed) for outcome in broken[TOLD:])
    seen += f"; {hours:.1f} h of factory time, {transports} transports"
    day = max(entry.day for entry in played)
    return f"| {day} | {commit} | `{name}` | {seen} | {_ranges([one.seed for one in outcomes])} |"


def _ranges(seeds: list[int]) -> str:
    """Ascending seeds, as ranges."""
    ranges: list[list[int]] = []
    for seed in seeds:
        if ranges and seed == ranges[-1][1] + 1:
            ranges[-1][1] = seed
        else:
            ranges.append([seed, seed])
    return ", ".join(f"{first} to {last}" for first, last in ranges)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

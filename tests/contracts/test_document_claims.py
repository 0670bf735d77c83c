"""Documents say what is there: their links and paths lead somewhere, their lists and counts are those of the code and of their tables."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from textwrap import wrap

import pytest

from dray_sim.explore.profile import PROFILES
from dray_sim.run.evidence import LINE
from dray_sim.run.scenario import Scenario
from dray_sim.scenarios import SCENARIOS
from dray_sim.scenarios.document import Section, write

ROOT = Path(__file__).parents[2]

NO_SOURCES = frozenset({".git", ".venv", "node_modules", "static", "artifacts", "__pycache__", "coverage"})
"""Folders that hold nothing that documents name; with a dot all others, too, but `.ci`."""

ABSENT = frozenset({"generated/openapi.ts", "artifacts/unsteady.json"})
"""Made by commands, and not kept."""

FILE = re.compile(r"[\w.-]+(?:/[\w.-]+)+\.(?:py|tsx?|mjs|md|ya?ml|json|toml|html)|[\w-]+\.py")
"""What looks like a file of ours: with a folder, or of Python."""


@cache
def files() -> tuple[str, ...]:
    found: list[str] = []
    for folder, folders, names in os.walk(ROOT):
        folders[:] = [
            each for each in folders if each not in NO_SOURCES and (each[0] != "." or each == ".ci")
        ]
        found += [Path(folder, name).relative_to(ROOT).as_posix() for name in names]
    return tuple(found)


@cache
def ends() -> frozenset[str]:
    """Every path as a document may name it: from any of its folders on."""
    parts = (file.split("/") for file in files())
    return frozenset("/".join(each[start:]) for each in parts for start in range(len(each)))


DOCUMENTS = sorted(
    file for file in files() if file.endswith(".md") and not file.startswith(("tests/", "frontend/"))
)


@cache
def headings(path: Path) -> frozenset[str]:
    """The anchors of a document, as GitHub makes them."""
    titles = re.findall(r"^#+ (.+)$", path.read_text(encoding="utf-8"), re.MULTILINE)
    return frozenset(re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles)


def dead_links(text: str, beside: Path) -> list[str]:
    """Relative links that lead to no file, or to no heading.

    Args:
        text: a document.
        beside: its own path.
    """
    dead = []
    for link in re.findall(r"\]\(([^)\s]+)\)|(?:src|href)=\"([^\"]+)\"", text):
        target = link[0] or link[1]
        if re.match(r"\w+:", target):
            continue
        place, _, heading = target.partition("#")
        path = beside.parent / place if place else beside
        if not path.exists() or (heading and path.suffix == ".md" and heading not in headings(path)):
            dead.append(target)
    return dead


def missing_files(text: str) -> list[str]:
    """Files that are named in code spans, and are not there. What is written in capitals stands for another name."""
    named = (word.strip(".,;:()") for span in re.findall(r"`([^`\n]+)`", text) for word in span.split())
    return [
        word
        for word in named
        if FILE.fullmatch(word)
        and re.sub(r"^(\.\./)+|^dray/", "", word) not in ends() | ABSENT
        and not re.search(r"\b[A-Z]{2,}\d*\b", word)
    ]


def test_every_link_of_a_document_leads_somewhere() -> None:
    texts = {name: (ROOT / name).read_text(encoding="utf-8") for name in DOCUMENTS}
    assert len(texts) > 25
    assert {name: dead for name, text in texts.items() if (dead := dead_links(text, ROOT / name))} == {}


def test_every_file_that_a_document_names_is_there() -> None:
    texts = {name: (ROOT / name).read_text(encoding="utf-8") for name in DOCUMENTS}
    assert {name: missing for name, text in texts.items() if (missing := missing_files(text))} == {}


def test_a_link_and_a_file_that_are_not_there_are_found() -> None:
    text = "[a](nothing.md), [b](protocol.md#nothing), [c](protocol.md#right-of-way), `protocol/nothing.py`, `protocol/states.py`"
    assert dead_links(text, ROOT / "docs" / "search.md") == ["nothing.md", "protocol.md#nothing"]
    assert missing_files(text) == ["protocol/nothing.py"]


def test_search_lists_every_profile_once() -> None:
    text = (ROOT / "docs" / "search.md").read_text(encoding="utf-8")
    (table,) = re.findall(r"^\| profile \|.*?(?=\n\n)", text, re.MULTILINE | re.DOTALL)
    assert sorted(re.findall(r"^\| `([\w-]+)` \| .+ \|$", table, re.MULTILINE)) == sorted(PROFILES)


# --- what commands write ----------------------------------------------------------------------------

WRITTEN = (ROOT / "docs" / "scenarios.md").read_text(encoding="utf-8")


def sections() -> Iterator[tuple[str, str]]:
    """Each scenario's name, and its section of docs/scenarios.md."""
    texts = re.split(r"^(?=## )", WRITTEN, flags=re.MULTILINE)[1:]
    yield from ((text.split("\n", 1)[0].removeprefix("## "), text.rstrip("\n")) for text in texts)


def by_hand(name: str, text: str) -> list[str]:
    """The parts of a section that no command writes: whatever is neither claim, story, verdict, table, report nor command."""
    scenario = SCENARIOS[name]
    known = {f"## {name}", "Held.", f"`dray sim run {name} --seed 1`"}
    if isinstance(scenario, Scenario):
        said = f"**Claim** ({scenario.source}). {scenario.claim}", f"**Done.** {scenario.story}"
        known |= {"\n".join(wrap(each, LINE)) for each in said}
    blocks = re.split(r"\n\s*\n", re.sub(r"^```\n.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL).strip())
    return [
        block
        for block in blocks
        if block not in known
        and not all(line.startswith("|") for line in block.splitlines())
        and not re.fullmatch(r"[^\n]+:", block)
    ]


def test_the_head_of_the_scenarios_is_the_one_that_the_command_writes() -> None:
    parts = [
        Section(name, SCENARIOS[name].shows, SCENARIOS[name].source, held=True, failure="", text=text)
        for name, text in sections()
    ]
    assert write(parts, 1) == WRITTEN


def test_nothing_is_written_by_hand_into_the_scenarios_and_their_claims_are_those_of_the_code() -> None:
    assert {name: found for name, text in sections() if (found := by_hand(name, text))} == {}


def test_a_remark_in_the_scenarios_is_found() -> None:
    name, text = next(sections())
    assert by_hand(name, f"{text}\n\nA remark.") == ["A remark."]


BENCHMARKS = (ROOT / "docs" / "benchmarks.md").read_text(encoding="utf-8")


def measured(benchmark: str) -> list[list[str]]:
    """The rows of one benchmark, as cells."""
    lines = [line for line in BENCHMARKS.splitlines() if re.match(rf"\| {benchmark}\b", line)]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


@pytest.mark.parametrize(("benchmark", "of"), [("traffic", " of traffic"), ("history", "")])
def test_benchmarks_count_their_figures_aims_and_misses(benchmark: str, of: str) -> None:
    aims = [row[3] for row in measured(benchmark) if row[3]]
    missed = sum("MISSED" in aim for aim in aims)
    verdict = f"{missed} of which are missed" if missed else "all of which are met"
    assert f"{len(measured(benchmark))} figures{of}, {len(aims)} with an aim, {verdict}" in BENCHMARKS


def test_benchmarks_name_every_floor_on_which_an_aim_is_missed() -> None:
    (told,) = re.findall(r"^What is missed: .*?(?=\n\n)", BENCHMARKS, re.MULTILINE | re.DOTALL)
    missed = {row[0].split()[1].rstrip(":") for row in measured("traffic .*") if "MISSED" in row[3]}
    floors = {name for name in missed if name != "the"}
    assert len(floors) > 3
    assert floors - set(re.findall(r"`([\w-]+)`", told)) == set()

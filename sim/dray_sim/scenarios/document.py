"""docs/scenarios.md: the reports of all scenarios in one document, made by one command.

The same seed gives the same bytes on any computer and with any number of processes.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor, as_completed

import msgspec

from dray_sim.run.scenario import HERE
from dray_sim.run.site import Site
from dray_sim.scenarios import SCENARIOS
from dray_sim.scenarios.ghosts import compared

COMMAND = "dray sim report --out docs/scenarios.md"


class Section(msgspec.Struct, frozen=True):
    """One scenario's part of the document."""

    name: str
    shows: str
    source: str
    held: bool
    failure: str
    text: str


def section(name: str, seed: int, site: Site = HERE) -> Section:
    """Play a scenario, and write its part."""
    scenario = SCENARIOS[name]
    outcome = scenario.run(seed, site)
    ghosts = compared(name, seed, site, outcome)
    return Section(
        name=name,
        shows=scenario.shows,
        source=scenario.source,
        held=not outcome.failure,
        failure=outcome.failure,
        text=outcome.document() if ghosts is None else f"{outcome.document()}\n\n{ghosts.document()}",
    )


def sections(
    seed: int,
    jobs: int,
    done: Callable[[Section], None],
    names: Iterable[str] = tuple(SCENARIOS),
    site: Site = HERE,
) -> list[Section]:
    """Play scenarios in processes of their own, for the memory of one must not show in another.

    Args:
        seed: of all of them.
        jobs: how many at once.
        done: told of each as soon as it has ended.
        names: of the scenarios.
        site: plant and load; most scenarios have only their own, with right of way or without.

    Returns:
        Their parts, in the order of the names.
    """
    ordered = list(names)
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, mp_context=spawn, max_tasks_per_child=1) as pool:
        futures = {name: pool.submit(section, name, seed, site) for name in ordered}
        for future in as_completed(futures.values()):
            done(future.result())
        return [futures[name].result() for name in ordered]


def write(parts: list[Section], seed: int, site: Site = HERE) -> str:
    """The whole document."""
    return "\n\n".join((_head(parts, seed, site), *(part.text for part in parts))) + "\n"


def _head(parts: list[Section], seed: int, site: Site) -> str:
    held = sum(part.held for part in parts)
    command = COMMAND if site == HERE else f"{COMMAND} {'--traffic' if site.traffic else '--no-traffic'}"
    lines = [
        "# Scenarios",
        "",
        f"Made by `{command}` with seed {seed}; do not edit.",
        "[scenario-notes.md](scenario-notes.md) is written by hand: which sections are older, and what was measured beside.",
        "Every figure comes from a run in virtual time with all invariants of [protocol.md](protocol.md) on, and the",
        "same seed gives the same figures. Times are factory seconds. `dray sim run NAME --seed N` plays one with",
        "another seed; it exits with 1 when its claim does not hold.",
        "",
        f"{held} of {len(parts)} held.",
        "",
        "| scenario | what it shows | source | held |",
        "| --- | --- | --- | --- |",
        *map(_row, parts),
    ]
    return "\n".join(lines)


def _row(part: Section) -> str:
    held = "yes" if part.held else "**no**"
    return f"| [{part.name}](#{part.name}) | {part.shows} | {part.source or '-'} | {held} |"

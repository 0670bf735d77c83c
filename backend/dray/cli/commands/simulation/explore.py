"""`dray sim explore`: random plants, loads and faults over many seeds, in search of violations."""

from __future__ import annotations

import re
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from dray.cli.runtime.options import Traffic
from dray.errors import SettingsError

if TYPE_CHECKING:
    from dray_sim.explore.outcome import Outcome, Summary

DEFAULT_SEEDS = "0:200"
"""A few minutes on one core."""

SHOWN = 3
"""Violations printed with their last lines; the others only with the command that replays them."""


def explore(
    seeds: Annotated[str, typer.Option(help="Seeds from A to before B.", metavar="A:B")] = DEFAULT_SEEDS,
    seed: Annotated[
        int | None, typer.Option(help="Replay this one alone, and say what it stands for.")
    ] = None,
    jobs: Annotated[int, typer.Option(help="Processes; 0 for one per core.", min=0)] = 0,
    profile: Annotated[str, typer.Option(help="Profile: the kind of plants, loads and faults.")] = "all",
    traffic: Traffic = None,
    json: Annotated[Path | None, typer.Option(help="Write the summary here too.")] = None,
    ledger: Annotated[
        Path | None,
        typer.Option(
            help="Keep each played seed here; those that this code has played are not played again."
        ),
    ] = None,
) -> None:
    """Try many seeds: a random plant, load and schedule of faults each. Exit 1 on a broken invariant."""
    from dray.cli.runtime.options import right_of_way
    from dray.cli.runtime.output import check_writable, one_of, write_json
    from dray_sim.explore.profile import PROFILES
    from dray_sim.explore.search import cores

    one_of(PROFILES, profile, "--profile")
    on = right_of_way(traffic)
    if json is not None:
        check_writable(json, "--json")
    if seed is not None and ledger is not None:
        raise SettingsError(
            "--ledger", "is for many seeds: leave it out with --seed, which plays its seed anew"
        )
    if seed is not None:
        outcome = _replay(seed, profile, traffic=on)
        if json is not None:
            write_json(json, outcome)
        raise typer.Exit(1 if outcome.broken else 0)
    first, last = _range(seeds)
    summary, took_s = _search(first, last, profile, jobs or cores(), traffic=on, kept=ledger)
    _tell(summary, took_s)
    if json is not None:
        write_json(json, summary)
    if summary.broken or summary.interrupted:
        raise typer.Exit(1)


def _range(seeds: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d+):(\d+)", seeds)
    if match is None:
        raise SettingsError("--seeds", f"{seeds!r} is not A:B, two whole numbers with a colon between them")
    first, last = int(match[1]), int(match[2])
    if first >= last:
        raise SettingsError("--seeds", f"{seeds} holds no seed; the second number must be the larger one")
    return first, last


def _replay(seed: int, profile: str, *, traffic: bool) -> Outcome:
    from dray_sim.explore.play import play
    from dray_sim.explore.run import draw

    run = draw(seed, profile, traffic=traffic)
    typer.echo(f"seed {seed}: {run}")
    for line in run.timetable():
        typer.echo(f"  {line}")
    outcome = play(run, listen=True)
    _tell_story(outcome)
    typer.echo(
        f"{outcome.broken or 'held'}\n"
        f"{outcome.duration_s:.0f} s of factory time, {outcome.transports} transports, "
        f"{outcome.takeovers} takeovers, {outcome.restarts} restarts, trace {outcome.trace}"
    )
    return outcome


def _search(
    first: int, last: int, profile: str, jobs: int, *, traffic: bool, kept: Path | None
) -> tuple[Summary, float]:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    from dray_sim.explore.code_key import played_code
    from dray_sim.explore.ledger import Ledger
    from dray_sim.explore.search import search

    ledger = None if kept is None else Ledger(kept, played_code())
    began_s = time.monotonic()
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("exploring", total=last - first)
        broken = 0

        def advance(outcome: Outcome) -> None:
            nonlocal broken
            broken += bool(outcome.broken)
            bar.update(task, advance=1, description=f"{broken} broken" if broken else "exploring")

        summary = search(
            first, last, profile=profile, traffic=traffic, jobs=jobs, progress=advance, ledger=ledger
        )
    return summary, time.monotonic() - began_s


def _tell(summary: Summary, took_s: float) -> None:
    for outcome in summary.violations[:SHOWN]:
        typer.echo(f"seed {outcome.seed}")
        _tell_story(outcome)
        typer.echo(f"{outcome.broken}\nreplay: {outcome.replay}\n")
    for outcome in summary.violations[SHOWN:]:
        typer.echo(f"{outcome.broken}\nreplay: {outcome.replay}\n")
    asked = summary.last - summary.first
    stopped = f" of {asked}, stopped by hand" if summary.interrupted else ""
    before = f", {summary.before} of them played before" if summary.before else ""
    typer.echo(f"{summary.runs} seeds{stopped}{before}: {summary.broken or 'none'} broken")
    typer.echo(
        f"{summary.virtual_s / 3600:.1f} h of factory time, {summary.transports} transports, "
        f"{summary.takeovers} takeovers, {summary.restarts} restarts"
    )
    if summary.faults:
        typer.echo("faults: " + ", ".join(f"{kind} {count}" for kind, count in summary.faults.items()))
    typer.echo(f"{summary.rate:.0f} seeds a minute and core; {took_s:.0f} s with {summary.jobs} processes")


def _tell_story(outcome: Outcome) -> None:
    for line in outcome.story:
        typer.echo(f"  {line}")

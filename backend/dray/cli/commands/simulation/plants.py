"""`dray sim plants`: generated plants, each at work for some hours."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from dray.cli.runtime.options import Traffic

if TYPE_CHECKING:
    from dray_sim.plants.judgement_file import JudgementFile
    from dray_sim.plants.play import Judgement, Kind


def plants(
    count: Annotated[int, typer.Option(help="How many, one for each seed from --first on.", min=1)] = 40,
    first: Annotated[int, typer.Option(help="The first seed.", min=0)] = 0,
    seed: Annotated[
        int | None, typer.Option(help="Replay this one alone, with all its figures.", min=0)
    ] = None,
    kind: Annotated[
        str, typer.Option(help="raster: a raster of roads; halls: lanes of any shape, often too narrow.")
    ] = "raster",
    small: Annotated[bool, typer.Option("--small", help="Plants of a few machines and vehicles.")] = False,
    hours: Annotated[float, typer.Option(help="Of demand.", min=0.1, max=1000.0)] = 4.0,
    jobs: Annotated[int, typer.Option(help="Processes; 0 for one per core.", min=0)] = 0,
    traffic: Traffic = None,
    json: Annotated[Path | None, typer.Option(help="Write the judgements here too.")] = None,
    keep: Annotated[
        Path | None,
        typer.Option(
            help="Append each judgement to this file at once, and leave out plants that are in it: a run that was ended goes on."
        ),
    ] = None,
    write: Annotated[Path | None, typer.Option(help="Write the plant of --seed to this file.")] = None,
    vehicles: Annotated[
        str,
        typer.Option(
            help="Instead: the floor of --seed with fleets of these sizes (2,4,8), each for --hours, at orders that take all of the "
            "machines' time."
        ),
    ] = "",
) -> None:
    """Generate plants of any shape, run each at a load that it can serve, and judge it.

    Criteria: every order is delivered, no battery gets empty, no carrier waits longer than its promise and two
    minutes, every invariant holds. Exit 1 when a plant fails and neither `dray plant check` nor the verdict says why.
    """
    from dray.cli.runtime.options import right_of_way
    from dray.cli.runtime.output import write_json
    from dray.errors import SettingsError
    from dray_sim.explore.search import cores
    from dray_sim.plants.judgement_file import JudgementFile
    from dray_sim.plants.many import play_seeds
    from dray_sim.plants.play import replay_of

    drawn: Kind = "halls" if kind == "halls" else "raster"
    if kind != drawn:
        raise SettingsError("--kind", f"{kind} is none: choose raster or halls")
    _check_files(json, keep, write, is_one=seed is not None, compares=bool(vehicles))
    if seed is not None:
        first, count, jobs = seed, 1, 1
        if write is not None:
            _write(seed, drawn, small, write)
    on = right_of_way(traffic)
    if vehicles:
        _compare_fleets(first, drawn, _sizes(vehicles), small=small, hours=hours, traffic=on, json=json)
        return
    kept = None if keep is None else JudgementFile(keep)
    judged: list[Judgement] = [] if kept is None else list(kept.judged)
    done = frozenset() if kept is None else kept.replays
    left_out = frozenset(
        each
        for each in range(first, first + count)
        if replay_of(each, drawn, small=small, hours=hours, traffic=on) in done
    )
    played = play_seeds(
        first,
        count,
        drawn,
        small=small,
        hours=hours,
        traffic=on,
        jobs=jobs or cores(),
        left_out=left_out,
        at_once=kept is not None,
    )
    stopped = _collect(played, kept, judged, whole=seed is not None)
    if json is not None:
        write_json(json, judged)
    if _tell(judged) or stopped:
        raise typer.Exit(1)


def _collect(
    played: Generator[Judgement, None, None],
    kept: JudgementFile | None,
    judged: list[Judgement],
    *,
    whole: bool,
) -> bool:
    """Print and keep each judgement; returns whether Ctrl-C has stopped that."""
    with closing(played):
        try:
            for each in played:
                if kept is not None:
                    kept.add(each)
                judged.append(each)
                for line in each.tell(whole=whole):
                    typer.echo(line)
        except KeyboardInterrupt:
            goes_on = "" if kept is None else "; the same command goes on"
            typer.echo(f"stopped by hand{goes_on}")
            return True
    return False


def _check_files(
    json: Path | None, keep: Path | None, write: Path | None, *, is_one: bool, compares: bool
) -> None:
    """Check the options for files before plants are played for hours."""
    from dray.cli.runtime.output import check_writable
    from dray.errors import SettingsError

    if keep is not None and (is_one or compares):
        raise SettingsError("--keep", "is for many plants: leave it out with --seed and --vehicles")
    if write is not None and not is_one:
        raise SettingsError("--write", "writes the plant of one seed: give --seed, too")
    if json is not None:
        check_writable(json, "--json")


def _tell(judged: Sequence[Judgement]) -> int:
    """Print the sums, and return how many plants failed without an explanation."""
    from dray_sim.run.evidence import HELD

    failed = [each for each in judged if each.failures]
    unnamed = [each for each in failed if not each.named]
    typer.echo(
        f"{len(judged)} plants: {len(judged) - len(failed)} served, {len(failed) - len(unnamed)} failed as foreseen "
        f"or explained, {len(unnamed)} failed"
    )
    broken = sum(each.invariants != HELD for each in judged)
    delivered, orders = sum(each.delivered for each in judged), sum(each.orders for each in judged)
    typer.echo(f"{delivered} of {orders} orders delivered, {broken} plants with a broken invariant")
    return len(unnamed)


def _sizes(text: str) -> tuple[int, ...]:
    from dray.errors import SettingsError

    sizes = tuple(int(each) for each in text.split(",") if each.strip().isdecimal() and int(each) > 0)
    if len(sizes) != text.count(",") + 1:
        raise SettingsError("--vehicles", f"{text} is no list of numbers above 0: give it as 2,4,8")
    return sizes


def _compare_fleets(
    seed: int,
    kind: Kind,
    sizes: tuple[int, ...],
    *,
    small: bool,
    hours: float,
    traffic: bool,
    json: Path | None,
) -> None:
    from dray.cli.runtime.output import write_json
    from dray_sim.plants.fleet_sizes import HEADING, FleetSize, play_sizes

    typer.echo(HEADING)
    rows: list[FleetSize] = []
    for row in play_sizes(seed, sizes, kind, small=small, hours=hours, traffic=traffic):
        rows.append(row)
        typer.echo(row.tell())
    if json is not None:
        write_json(json, rows)
    if not all(row.holds for row in rows):
        raise typer.Exit(1)


def _write(seed: int, kind: Kind, small: bool, file: Path) -> None:
    from dray.cli.runtime.output import write_text
    from dray.plant import plant_yaml
    from dray_sim.plants.play import plant_of

    write_text(file, plant_yaml(plant_of(seed, kind, small=small)), "--write")

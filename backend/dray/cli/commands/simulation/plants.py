"""`dray sim plants`: generated plants, each at work for some hours."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from dray.cli.runtime.options import Traffic, number

if TYPE_CHECKING:
    from dray_sim.plants.fleet_sizes import Floor
    from dray_sim.plants.play import Judgement, Kind
    from dray_sim.plants.run_file import RunFile


def plants(
    count: Annotated[
        int, typer.Option(help="Number of plants, one for each seed from --first on.", min=1)
    ] = 40,
    first: Annotated[int, typer.Option(help="The first seed.", min=0)] = 0,
    seed: Annotated[
        int | None, typer.Option(help="Replay this one alone, with all its figures.", min=0)
    ] = None,
    kind: Annotated[
        str, typer.Option(help="raster: a raster of roads; halls: lanes of any shape, often too narrow.")
    ] = "raster",
    small: Annotated[bool, typer.Option("--small", help="Plants of a few machines and vehicles.")] = False,
    hours: Annotated[
        float,
        typer.Option(
            parser=number(least=0.1, most=1000.0),
            metavar="HOURS",
            help="Factory hours in which orders are placed, from 0.1 to 1000.",
        ),
    ] = 4.0,
    jobs: Annotated[int, typer.Option(help="Processes; 0 for one per core.", min=0)] = 0,
    traffic: Traffic = None,
    json: Annotated[Path | None, typer.Option(help="Write the judgements here too.")] = None,
    keep: Annotated[
        Path | None,
        typer.Option(
            help="Append each result to this file at once, and leave out what is in it: a run that was ended goes on."
        ),
    ] = None,
    write: Annotated[Path | None, typer.Option(help="Write the plant of --seed to this file.")] = None,
    vehicles: Annotated[
        str,
        typer.Option(
            help="Instead: the floor of --seed or --plant with fleets of these sizes (2,4,8), each for --hours, at orders that take "
            "all of the machines' time. Says whether a fleet carries less than a smaller one."
        ),
    ] = "",
    runs: Annotated[
        int,
        typer.Option(
            help="With --vehicles: runs of each fleet; all fleets have the same orders.", min=1, max=1000
        ),
    ] = 5,
    plant: Annotated[
        str | None,
        typer.Option(
            help="With --vehicles: a plant file, or the name of a shipped plant, instead of --seed."
        ),
    ] = None,
) -> None:
    """Generate plants of any shape, run each at a load that it can serve, and judge it.

    Criteria: every order is delivered, no battery gets empty, no carrier waits longer than its promise and two
    minutes, every invariant holds. Exit 1 when a plant fails and neither `dray plant check` nor the verdict says why.
    With --vehicles exit 1 when an invariant is broken.
    """
    from dray.cli.runtime.options import right_of_way
    from dray.errors import SettingsError
    from dray_sim.explore.search import cores

    drawn: Kind = "halls" if kind == "halls" else "raster"
    if kind != drawn:
        raise SettingsError("--kind", f"{kind} is none: choose raster or halls")
    if plant is not None and (not vehicles or seed is not None):
        raise SettingsError("--plant", "is the floor of --vehicles: give it without --seed")
    _check_files(json, write, is_one=seed is not None)
    if keep is not None and seed is not None and not vehicles:
        raise SettingsError("--keep", "is for many runs: leave it out with --seed, or give --vehicles")
    if seed is not None:
        first, count = seed, 1
        if write is not None:
            _write(seed, drawn, small, write)
    on, processes = right_of_way(traffic), jobs or cores()
    if vehicles:
        floor, sizes = _floor(first, drawn, small, plant), _sizes(vehicles)
        _compare_fleets(floor, sizes, keep, json, hours=hours, traffic=on, runs=runs, jobs=processes)
    else:
        seeds, whole = range(first, first + count), seed is not None
        _judge(seeds, drawn, keep, json, small=small, hours=hours, traffic=on, jobs=processes, whole=whole)


def _judge(
    seeds: range,
    kind: Kind,
    keep: Path | None,
    json: Path | None,
    *,
    small: bool,
    hours: float,
    traffic: bool,
    jobs: int,
    whole: bool,
) -> None:
    from dray.cli.runtime.output import write_json
    from dray_sim.plants.many import play_seeds
    from dray_sim.plants.play import Judgement, replay_of
    from dray_sim.plants.run_file import RunFile

    kept = None if keep is None else RunFile(keep, Judgement, "judgement of a plant")
    # Two processes that shared the file may have judged the same plant.
    done = {} if kept is None else {each.replay: each for each in kept.kept}
    judged = list(done.values())
    left_out = frozenset(
        seed for seed in seeds if replay_of(seed, kind, small=small, hours=hours, traffic=traffic) in done
    )
    played = play_seeds(
        seeds.start,
        len(seeds),
        kind,
        small=small,
        hours=hours,
        traffic=traffic,
        jobs=jobs,
        left_out=left_out,
        at_once=kept is not None,
    )
    stopped = _collect(played, kept, judged, whole=whole)
    if json is not None:
        write_json(json, judged)
    if _tell(judged) or stopped:
        raise typer.Exit(1)


def _collect(
    played: Generator[Judgement, None, None],
    kept: RunFile[Judgement] | None,
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


def _check_files(json: Path | None, write: Path | None, *, is_one: bool) -> None:
    """Check the options for files before plants are played for hours."""
    from dray.cli.runtime.output import check_writable
    from dray.errors import SettingsError

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


def _floor(seed: int, kind: Kind, small: bool, plant: str | None) -> Floor:
    from dray.plant import load_plant
    from dray_sim.plants.fleet_sizes import Floor, drawn_floor

    if plant is None:
        return drawn_floor(seed, kind, small=small)
    return Floor(f"plant {plant}", load_plant(plant).file)


def _compare_fleets(
    floor: Floor,
    sizes: tuple[int, ...],
    keep: Path | None,
    json: Path | None,
    *,
    hours: float,
    traffic: bool,
    runs: int,
    jobs: int,
) -> None:
    from dray.cli.runtime.output import write_json
    from dray_sim.plants.fleet_sizes import HEADING, FleetRun, FleetSize, play_sizes
    from dray_sim.plants.run_file import RunFile

    kept = None if keep is None else RunFile(keep, FleetRun, "run of a fleet")
    typer.echo(HEADING)
    rows: list[FleetSize] = []
    for row in play_sizes(floor, sizes, runs=runs, hours=hours, traffic=traffic, jobs=jobs, keep=kept):
        rows.append(row)
        typer.echo(row.tell())
    verdicts = [row.fall.verdict for row in rows if row.fall]
    typer.echo(
        f"{floor.name}: {verdicts.count('falls')} fleets fall by more than 5 %, {verdicts.count('holds')} hold, "
        f"{verdicts.count('open')} open (more --runs would tell)"
    )
    if json is not None:
        write_json(json, rows)
    if not all(row.holds for row in rows):
        raise typer.Exit(1)


def _write(seed: int, kind: Kind, small: bool, file: Path) -> None:
    from dray.cli.runtime.output import write_text
    from dray.plant import plant_yaml
    from dray_sim.plants.play import plant_of

    write_text(file, plant_yaml(plant_of(seed, kind, small=small)), "--write")

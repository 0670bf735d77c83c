"""`dray sim`: named scenarios in virtual time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from dray.cli.commands.simulation.explore import explore
from dray.cli.commands.simulation.plants import plants
from dray.cli.commands.simulation.vehicles import vehicles
from dray.cli.runtime.options import Traffic, number

if TYPE_CHECKING:
    from dray_sim.scenarios.document import Section

app = typer.Typer(no_args_is_help=True, help="Named scenarios in virtual time.")
app.command()(explore)
app.command()(plants)
app.command()(vehicles)


@app.callback()
def sim() -> None:
    """Named scenarios in virtual time."""


@app.command("list")
def list_scenarios() -> None:
    """List the scenarios."""
    from dray.cli.runtime.output import table
    from dray_sim.scenarios import LIVE, SCENARIOS

    rows = [(name, "any" if each.moves else "its own", each.shows) for name, each in SCENARIOS.items()]
    table(("scenario", "plant", "what it shows"), rows)
    typer.echo(f"Live in the panels, by `dray up --scenario NAME`: {', '.join(LIVE)}.")


@app.command()
def run(
    name: Annotated[str, typer.Argument(help="A scenario, as `dray sim list` names it.")],
    seed: Annotated[int, typer.Option(help="Seed of everything that is left to chance.")] = 1,
    plant: Annotated[
        Path | None,
        typer.Option(help="A plant file, or the name of a shipped plant, instead of the scenario's own."),
    ] = None,
    load: Annotated[
        float | None,
        typer.Option(
            parser=number(least=0.001, most=10.0),
            metavar="FRACTION",
            help="Part of the machines' time that the orders take, from 0.001 to 10; 0.7 is 70 %. Else the scenario's own.",
        ),
    ] = None,
    hours: Annotated[
        float | None,
        typer.Option(
            parser=number(least=0.05, most=2_000.0),
            metavar="HOURS",
            help="Factory hours in which orders are placed, from 0.05 to 2000. Else the scenario's own.",
        ),
    ] = None,
    strategists: Annotated[
        int | None, typer.Option(help="Number of strategists, which share the orders; else 1.", min=1, max=9)
    ] = None,
    traffic: Traffic = None,
    json: Annotated[Path | None, typer.Option(help="Write the report here too.")] = None,
) -> None:
    """Play a scenario and print its report; the same seed gives the same report.

    It ends with a verdict: the shortage, its resource, and a figure for each resource. Scenarios about certain machines take no
    --plant, --load or --hours, and say so; `dray sim list` tells which do.

    Exit 1 when its claim did not hold, or an invariant was broken.
    """
    from dray.cli.runtime.options import right_of_way
    from dray.cli.runtime.output import one_of, write_json
    from dray.cli.runtime.plant_errors import tell_errors
    from dray.plant import load_plant
    from dray_sim.run.site import Site
    from dray_sim.scenarios import SCENARIOS

    site = Site(None if plant is None else load_plant(plant), load, hours, right_of_way(traffic), strategists)
    scenario = one_of(SCENARIOS, name, "scenario")
    if site.plant is not None and scenario.moves:
        tell_errors(site.plant, traffic=site.traffic, load_frac=load)
    outcome = scenario.run(seed, site)
    typer.echo(outcome.describe())
    if json is not None:
        write_json(json, outcome)
    if outcome.failure:
        options = {"plant": plant, "load": load, "hours": hours, "strategists": strategists}
        given = "".join(f" --{option} {value}" for option, value in options.items() if value is not None)
        given += " --traffic" if site.traffic else " --no-traffic"
        typer.echo(f"dray: {outcome.failure}\nreplay: dray sim run {name} --seed {seed}{given}", err=True)
        raise typer.Exit(1)


@app.command()
def report(
    out: Annotated[Path, typer.Option(help="The Markdown file to write.")] = Path("docs/scenarios.md"),
    seed: Annotated[int, typer.Option(help="Seed of all scenarios.")] = 1,
    jobs: Annotated[int, typer.Option(help="Number of scenarios that run at once.", min=1)] = 2,
    traffic: Traffic = None,
) -> None:
    """Play all scenarios and write their reports into one document. Takes some minutes.

    Exit 1 when a claim did not hold; the document is written all the same, and says so.
    """
    from dray.cli.runtime.options import right_of_way
    from dray.cli.runtime.output import write_text
    from dray_sim.run.site import Site
    from dray_sim.scenarios.document import sections, write

    def done(part: Section) -> None:
        typer.echo(f"{part.name}: {part.failure or 'held'}", err=True)

    site = Site(traffic=right_of_way(traffic))
    parts = sections(seed, jobs, done, site=site)
    write_text(out, write(parts, seed, site), "--out")
    if not all(part.held for part in parts):
        raise typer.Exit(1)

"""`dray sim`: named scenarios in virtual time."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(no_args_is_help=True, help="Named scenarios in virtual time.")


@app.callback()
def sim() -> None:
    """Named scenarios in virtual time."""


@app.command("list")
def list_scenarios() -> None:
    """What can be run."""
    from dray.cli.output import table
    from dray_sim.scenarios import SCENARIOS

    table(("scenario", "what it shows"), [(name, _first_line(run)) for name, run in SCENARIOS.items()])


@app.command()
def run(
    name: Annotated[str, typer.Argument(help="A scenario, as `dray sim list` names it.")],
    seed: Annotated[int, typer.Option(help="Everything that is left to chance follows from it.")] = 1,
    json: Annotated[Path | None, typer.Option(help="Write the report here too.")] = None,
) -> None:
    """Play a scenario and print its report; the same seed gives the same report. Exit 1 on a broken invariant."""
    from dray.cli.output import one_of, write_json
    from dray_sim.report import describe
    from dray_sim.scenario import HELD
    from dray_sim.scenarios import SCENARIOS

    report = one_of(SCENARIOS, name, "scenario")(seed)
    typer.echo(describe(report))
    if json is not None:
        write_json(json, report)
    if report.invariants != HELD:
        typer.echo(f"dray: {report.invariants}\nreplay: dray sim run {name} --seed {seed}", err=True)
        raise typer.Exit(1)


def _first_line(function: object) -> str:
    module = sys.modules[getattr(function, "__module__", "")]
    return (module.__doc__ or "").strip().split("\n\n")[0].replace("\n", " ")

"""`dray sim`: named scenarios in virtual time."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dray.cli.explore import explore
from dray.cli.plants import plants

app = typer.Typer(no_args_is_help=True, help="Named scenarios in virtual time.")
app.command()(explore)
app.command()(plants)


@app.callback()
def sim() -> None:
    """Named scenarios in virtual time."""


@app.command("list")
def list_scenarios() -> None:
    """What can be run."""
    from dray.cli.output import table
    from dray_sim.scenarios import SCENARIOS

    table(("scenario", "what it shows"), [(name, each.shows) for name, each in SCENARIOS.items()])


@app.command()
def run(
    name: Annotated[str, typer.Argument(help="A scenario, as `dray sim list` names it.")],
    seed: Annotated[int, typer.Option(help="Everything that is left to chance follows from it.")] = 1,
    json: Annotated[Path | None, typer.Option(help="Write the report here too.")] = None,
) -> None:
    """Play a scenario and print its report; the same seed gives the same report.

    Exit 1 when its claim did not hold, or an invariant was broken.
    """
    from dray.cli.output import one_of, write_json
    from dray_sim.scenarios import SCENARIOS

    outcome = one_of(SCENARIOS, name, "scenario").run(seed)
    typer.echo(outcome.describe())
    if json is not None:
        write_json(json, outcome)
    if outcome.failure:
        typer.echo(f"dray: {outcome.failure}\nreplay: dray sim run {name} --seed {seed}", err=True)
        raise typer.Exit(1)


@app.command()
def report(
    out: Annotated[Path, typer.Option(help="The Markdown file to write.")] = Path("docs/scenarios.md"),
    seed: Annotated[int, typer.Option(help="Of all scenarios.")] = 1,
    jobs: Annotated[int, typer.Option(help="How many run at once.", min=1)] = 2,
) -> None:
    """Play all scenarios and write their reports into one document. Takes some minutes.

    Exit 1 when a claim did not hold; the document is written all the same, and says so.
    """
    from dray.cli.output import write_text
    from dray_sim.document import sections, write

    parts = sections(seed, jobs, lambda part: typer.echo(f"{part.name}: {part.failure or 'held'}", err=True))
    write_text(out, write(parts, seed), "--out")
    if not all(part.held for part in parts):
        raise typer.Exit(1)

"""`dray plant`: plant files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from dray.plant import Plant

app = typer.Typer(no_args_is_help=True, help="Plant files.")


@app.callback()
def plant() -> None:
    """Plant files."""


@app.command()
def check(
    file: Annotated[Path, typer.Argument(help="A plant file (YAML), or the name of a shipped plant.")],
    strict: Annotated[bool, typer.Option("--strict", help="Exit 2 when there is a warning.")] = False,
    json: Annotated[Path | None, typer.Option(help="Write the warnings here too.")] = None,
) -> None:
    """Validate a plant file; every fault is named by line and field, and the exit code is 2.

    A file without faults is looked through for what will starve: each warning has a figure and says what to do.
    """
    from dray.cli.output import write_json
    from dray.plant import load_plant, sum_up
    from dray.plant.advice import advice

    chosen = load_plant(file)
    typer.echo(sum_up(chosen))
    warnings = advice(chosen)
    for warning in warnings:
        typer.echo(f"{file}: {warning.field}: warning: {warning.kind}: {warning.text}")
    if json is not None:
        write_json(json, warnings)
    if strict and warnings:
        raise typer.Exit(2)


@app.command("json")
def as_json(
    file: Annotated[Path | None, typer.Argument(help="A plant file (YAML); else the default plant.")] = None,
) -> None:
    """Write a plant as JSON, every default filled in: for agents that read no YAML."""
    import msgspec

    typer.echo(msgspec.json.format(msgspec.json.encode(chosen_plant(file).file)))


def chosen_plant(file: Path | None) -> Plant:
    """The plant of a file, or the default plant.

    Raises:
        PlantError: the file cannot be used.
    """
    from dray.plant import default_plant, load_plant

    return default_plant() if file is None else load_plant(file)

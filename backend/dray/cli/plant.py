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
    file: Annotated[Path, typer.Argument(help="A plant file (YAML).")],
) -> None:
    """Validate a plant file; every fault is named by line and field, and the exit code is 2."""
    from dray.plant import check_plant

    typer.echo(check_plant(file))


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

"""`dray wire`: the agents' messages as documents, for authors of other agents."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(no_args_is_help=True, help="The agents' messages, as schemas.")


@app.callback()
def wire() -> None:
    """The agents' messages, as schemas."""


@app.command()
def write(
    folder: Annotated[Path, typer.Argument(help="The folder to write.")] = Path("docs/wire"),
    release: Annotated[
        bool, typer.Option("--release", help="Let the next version be compared with this one.")
    ] = False,
) -> None:
    """Write the JSON Schema of every message and the AsyncAPI document of the bus."""
    from dray.cli.runtime.output import write_text
    from dray.wire.documents import RELEASED, documents, released

    files = documents()
    if release:
        files[RELEASED] = released()
    (folder / "schemas").mkdir(parents=True, exist_ok=True)
    # A removed message leaves no schema behind.
    for stale in {*folder.glob("schemas/*.json")} - {folder / name for name in files}:
        stale.unlink()
    for name, text in files.items():
        write_text(folder / name, text, "FOLDER")
    typer.echo(f"{folder}: {len(files)} files")

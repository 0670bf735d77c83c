"""`dray compose`: a plant as containers."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dray.cli.runtime.options import Strategists

DEPLOY = Path("deploy/prometheus")


def compose(
    plant: Annotated[
        Path | None,
        typer.Option("--plant", help="A plant file; else DRAY_PLANT_FILE, else the default plant."),
    ] = None,
    strategists: Strategists = None,
    folder: Annotated[Path, typer.Option(help="Dray's sources, of which the image is built.")] = Path(),
) -> None:
    """Write docker-compose.yml, Prometheus' targets and certificates for every process of a plant.

    Existing certificates stay; the authority's key belongs in no container, and gets into none.
    """
    import os

    from dray.cli.commands.plant import chosen_plant
    from dray.cli.compose.certificates import USER, certify
    from dray.cli.compose.document import CERTIFICATES, compose_text, targets_text
    from dray.cli.runtime.options import load_settings
    from dray.cli.runtime.plant_errors import tell_errors
    from dray.errors import SettingsError, UnavailableError
    from dray.plant import is_shipped

    settings = load_settings(plant_file=plant, strategists=strategists)
    file, many = settings.plant_file, settings.strategists
    chosen = chosen_plant(file)
    tell_errors(chosen, traffic=settings.traffic)
    if not (folder / DEPLOY / "prometheus.yml").is_file():
        raise SettingsError(
            str(folder), f"has no {DEPLOY}: name Dray's sources by --folder, since the image is built of them"
        )
    if file is None:
        seen = ""
    elif is_shipped(file):
        seen = str(file)
    else:
        seen = _seen_from(folder, file)
    texts = {
        folder / "docker-compose.yml": compose_text(chosen, seen, many),
        folder / DEPLOY / "targets.json": targets_text(chosen, many),
    }
    for path, text in texts.items():
        try:
            path.write_text(text, encoding="utf-8")
        except OSError as error:
            raise UnavailableError(
                str(path), error.strerror or str(error), "choose another --folder"
            ) from None
    made = certify(chosen, folder / CERTIFICATES, many)
    typer.echo(
        f"{folder / 'docker-compose.yml'} and {folder / DEPLOY / 'targets.json'} are those of {chosen.id}; "
        f"{made} certificates made in {folder / CERTIFICATES}"
    )
    if os.geteuid() != 0:
        typer.echo(f"Let the containers read theirs: sudo chown -R {USER} {folder / CERTIFICATES}/*/")


def _seen_from(folder: Path, file: Path) -> str:
    """A path for a compose file in this folder: it begins with a dot, as volume names never do."""
    import os

    path = Path(os.path.relpath(file, folder)).as_posix()
    return path if path.startswith(".") else f"./{path}"

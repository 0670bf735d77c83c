"""Command line options that become settings."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from dray.errors import SettingsError

if TYPE_CHECKING:
    from dray.settings import Settings

SettingsFile = Annotated[
    Path | None,
    typer.Option("--settings", help="A file of DRAY_...=... lines; the environment wins over it."),
]

OPTIONS = {"--database-url": "--db", "--gateway-name": "--name", "--plant-file": "--plant"}
"""Options whose name is not that of the setting."""


def load_settings(settings_file: Path | None = None, **options: object) -> Settings:
    """A file, overridden by the environment, overridden by the options that were given.

    Raises:
        SettingsError: names the option as the user typed it.
    """
    from dray.settings import Settings

    try:
        return Settings.load(settings_file, **options)
    except SettingsError as error:
        raise SettingsError(OPTIONS.get(error.name, error.name), error.reason) from None

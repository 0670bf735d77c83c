"""Command line options that become settings."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
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

Traffic = Annotated[
    bool | None,
    typer.Option(
        "--traffic/--no-traffic",
        help="Whether vehicles take up room, and drive with right of way; else DRAY_TRAFFIC.",
        show_default=False,
    ),
]
"""None: the setting counts (`right_of_way`)."""

PanelUrl = Annotated[
    str | None,
    typer.Option(
        "--url", help="Where the panel is; else DRAY_HOST and DRAY_PORT, else http://127.0.0.1:8000."
    ),
]

Strategists = Annotated[
    int | None,
    typer.Option(
        "--strategists",
        min=1,
        max=9,
        help="Number of strategists, which share the orders; else DRAY_STRATEGISTS, else 1.",
    ),
]


def number(*, least: float = 0.0, most: float = math.inf, above: bool = False) -> Callable[[str], float]:
    """The parser of an option with a number; a refused text is named, with what is allowed.

    Args:
        least: the smallest number.
        most: the largest one.
        above: whether `least` itself is refused.
    """
    low = f"above {least:g}" if above else f"of at least {least:g}" if most == math.inf else f"from {least:g}"
    allowed = low if most == math.inf else f"{low} {'and at most' if above else 'to'} {most:g}"

    def parse(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value) or value < least or value > most or (above and value == least):
            raise typer.BadParameter(f"{text!r}: give a number {allowed}")
        return value

    return parse


OPTIONS = {"--database-url": "--db", "--gateway-name": "--name", "--plant-file": "--plant"}
"""Options whose name differs from the setting's."""


def right_of_way(traffic: bool | None) -> bool:
    """Whether vehicles drive with right of way: by the option, else by the setting.

    Raises:
        SettingsError: a variable is invalid.
    """
    return load_settings(traffic=traffic).traffic


def load_settings(settings_file: Path | None = None, **options: object) -> Settings:
    """Settings from a file, overridden by the environment, overridden by the given options.

    Probably misspelt variables are named on stderr.

    Raises:
        SettingsError: names the option as the user typed it.
    """
    from dray.settings import Settings, misspelt

    try:
        settings = Settings.load(settings_file, **options)
    except SettingsError as error:
        raise SettingsError(OPTIONS.get(error.name, error.name), error.reason) from None
    for name, meant in misspelt(settings_file).items():
        _say_once(f"dray: {name} is no setting and is not used; is {meant} meant?")
    return settings


@cache
def _say_once(line: str) -> None:
    """Print a line once, though a command may load its settings several times."""
    typer.echo(line, err=True)

"""A version of Dray: what is installed in one environment of Python."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import msgspec

from dray import __version__
from dray.errors import SettingsError
from dray.messages import WIRE_VERSION

ANSWER_S = 60.0
"""Longest wait for `dray --version`, which takes a second on a computer with nothing else to do."""

OF_ONE_PYTHON = ("PYTHONPATH", "PYTHONHOME")
"""Variables by which the packages of one environment would be used by another."""

_TOLD = re.compile(r"dray (\S+), wire version (\d+)")


class Software(msgspec.Struct, frozen=True):
    """One version in one place.

    Attributes:
        python: the interpreter, as an absolute path.
        version: as `dray --version` and heartbeats say it.
        wire: the version of the wire that it speaks.
    """

    python: str
    version: str
    wire: int

    def command(self, *arguments: str) -> tuple[str, ...]:
        """What to start for `dray` with these arguments."""
        # Not what lies in the working folder, by chance.
        return (self.python, "-P", "-m", "dray", *arguments)

    def environment(self, variables: Mapping[str, str]) -> dict[str, str]:
        """The variables to start it with: without those that belong to our own interpreter."""
        ours = () if self.python == OWN.python else OF_ONE_PYTHON
        return {name: value for name, value in variables.items() if name not in ours}


OWN = Software(sys.executable, __version__, WIRE_VERSION)
"""What runs at this moment."""


def ask(python: Path) -> Software:
    """The software of an environment.

    Args:
        python: its interpreter.

    Raises:
        SettingsError: it cannot be run, or has no Dray that says which it is.
    """
    # As it was given: an environment is known by the link that leads to its interpreter.
    asked = Software(str(python.absolute()), "", 0)
    try:
        done = subprocess.run(  # noqa: S603 - a program that the person at the command line has named
            asked.command("--version"),
            env=asked.environment(os.environ),
            capture_output=True,
            text=True,
            check=False,
            timeout=ANSWER_S,
        )
    except OSError as error:
        raise SettingsError("--python", f"{python} cannot be run: {error.strerror or error}") from None
    except subprocess.TimeoutExpired:
        reason = f"{python} has not said which Dray it has within {ANSWER_S:.0f} s"
        raise SettingsError("--python", reason) from None
    told = _TOLD.fullmatch(done.stdout.strip())
    if told is None:
        said = (done.stderr or done.stdout).strip().rpartition("\n")[2] or "nothing"
        raise SettingsError("--python", f"{python} has no Dray that can be updated to; it says: {said}")
    return msgspec.structs.replace(asked, version=told[1], wire=int(told[2]))

"""A version of Dray, as installed in one Python environment."""

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
"""Timeout of `dray --version`, which takes a second on an idle computer."""

OF_ONE_PYTHON = ("PYTHONPATH", "PYTHONHOME")
"""Variables that would make one environment use another's packages."""

_TOLD = re.compile(r"dray (\S+), wire version (\d+)")


class Software(msgspec.Struct, frozen=True):
    """One version in one environment.

    Attributes:
        python: the interpreter, as an absolute path.
        version: the version, as in `dray --version` and heartbeats.
        wire: its wire version.
    """

    python: str
    version: str
    wire: int

    def command(self, *arguments: str) -> tuple[str, ...]:
        """The command line of `dray` with these arguments."""
        # Not a package that happens to be in the working folder.
        return (self.python, "-P", "-m", "dray", *arguments)

    def environment(self, variables: Mapping[str, str]) -> dict[str, str]:
        """The environment to start it with: without the variables of our own interpreter."""
        ours = () if self.python == OWN.python else OF_ONE_PYTHON
        return {name: value for name, value in variables.items() if name not in ours}


OWN = Software(sys.executable, __version__, WIRE_VERSION)
"""The running software."""


def ask(python: Path) -> Software:
    """The software of an environment.

    Args:
        python: its interpreter.

    Raises:
        SettingsError: it cannot be run, or its Dray does not report its version.
    """
    # Keep the given path: the link to its interpreter identifies an environment.
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

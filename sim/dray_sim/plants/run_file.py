"""A file of results, one JSON line per run: many runs can be ended at any moment, and go on later.

A line is in the file as soon as its run is over. A line without an end was being written when the process was killed:
it is left out, and its run is made again. Nothing is cut off, so several processes may share a file. The file says
nothing about the version of the code: use another file for another version.
"""

from __future__ import annotations

from pathlib import Path
from typing import Generic, TypeVar

import msgspec

from dray.errors import SettingsError, UnavailableError

OPTION = "--keep"

BEGIN = b'{"seed":'
"""How a line begins, so `seed` is the first field of every struct that is kept. A line without an end that begins
otherwise is something else."""

T = TypeVar("T", bound=msgspec.Struct)


class RunFile(Generic[T]):
    """The results of a file, in its order; a file that is not there is made.

    Args:
        path: of the file.
        kind: of result; a line with another kind is refused.
        name: of this kind in words.

    Attributes:
        kept: the results.

    Raises:
        SettingsError: a line is no such result.
        UnavailableError: the file cannot be read or written.
    """

    def __init__(self, path: Path, kind: type[T], name: str) -> None:
        self._path, self._kind, self._name = path, kind, name
        self.kept: list[T] = []
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with path.open("a+b") as file:
                file.seek(0)
                lines = file.read().split(b"\n")
                for number, line in enumerate(lines, 1):
                    if (result := self._read(line, number)) is not None:
                        self.kept.append(result)
                if lines[-1]:
                    file.write(b"\n")
        except OSError as error:
            raise self._unavailable(error) from None

    def add(self, result: T) -> None:
        """Append a result.

        Raises:
            UnavailableError: the file cannot be written.
        """
        try:
            with self._path.open("ab") as file:
                file.write(msgspec.json.encode(result) + b"\n")
        except OSError as error:
            raise self._unavailable(error) from None
        self.kept.append(result)

    def _read(self, line: bytes, number: int) -> T | None:
        """The result of a line; None for one without an end."""
        try:
            return msgspec.json.decode(line, type=self._kind)
        except msgspec.DecodeError as error:
            is_whole = isinstance(error, msgspec.ValidationError)
            if not is_whole and BEGIN.startswith(line[: len(BEGIN)]):
                return None
            reason = f"line {number} of {self._path} is no {self._name} ({error}): choose another file"
            raise SettingsError(OPTION, reason) from None

    def _unavailable(self, error: OSError) -> UnavailableError:
        reason = error.strerror or str(error)
        return UnavailableError(str(self._path), reason, f"choose another file for {OPTION}")

"""A file of results, one JSON line per run: many runs can be ended at any moment, and go on later.

A line is in the file as soon as its run is over. A last line without an end was being written when the process was
killed: it is cut off, and its run is made again. The file says nothing about the version of the code: use another file
for another version.
"""

from __future__ import annotations

from pathlib import Path
from typing import Generic, TypeVar

import msgspec

from dray.errors import SettingsError, UnavailableError

OPTION = "--keep"

BEGIN = b'{"seed":'
"""How a line begins, so `seed` is the first field of every struct that is kept. A rest that begins otherwise is something
else, and is not cut off."""

T = TypeVar("T", bound=msgspec.Struct)


class RunFile(Generic[T]):
    """The results of a file, in its order; none if there is no such file yet.

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
            text = path.read_bytes() if path.exists() else b""
            whole = text[: text.rfind(b"\n") + 1]
            for number, line in enumerate(whole.splitlines(), 1):
                self.kept.append(self._read(line, number))
            if rest := text[len(whole) :]:
                if not BEGIN.startswith(rest[: len(BEGIN)]):
                    self._read(rest, len(self.kept) + 1)
                path.write_bytes(whole)
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

    def _read(self, line: bytes, number: int) -> T:
        try:
            return msgspec.json.decode(line, type=self._kind)
        except msgspec.DecodeError as error:
            reason = f"line {number} of {self._path} is no {self._name} ({error}): choose another file"
            raise SettingsError(OPTION, reason) from None

    def _unavailable(self, error: OSError) -> UnavailableError:
        reason = error.strerror or str(error)
        return UnavailableError(str(self._path), reason, f"choose another file for {OPTION}")

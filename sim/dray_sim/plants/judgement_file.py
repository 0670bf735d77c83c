"""A file of judgements, one JSON line per plant: a run over many plants can be ended at any moment, and goes on later.

A line is in the file as soon as its plant is judged. A last line without an end was being written when the process was
killed: it is cut off, and its plant is played again. The file says nothing about the version of the code: use another
file for another version.
"""

from __future__ import annotations

from pathlib import Path

import msgspec

from dray.errors import SettingsError, UnavailableError
from dray_sim.plants.play import Judgement

OPTION = "--keep"

BEGIN = b'{"seed":'
"""How a line begins. A rest that begins otherwise is something else, and is not cut off."""


class JudgementFile:
    """The judgements of a file, in its order; none if there is no such file yet.

    Args:
        path: of the file.

    Raises:
        SettingsError: a line is no judgement.
        UnavailableError: the file cannot be read or written.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.judged: list[Judgement] = []
        try:
            text = path.read_bytes() if path.exists() else b""
            whole = text[: text.rfind(b"\n") + 1]
            for number, line in enumerate(whole.splitlines(), 1):
                self.judged.append(self._read(line, number))
            if rest := text[len(whole) :]:
                if not BEGIN.startswith(rest[: len(BEGIN)]):
                    self._read(rest, len(self.judged) + 1)
                path.write_bytes(whole)
        except OSError as error:
            raise self._unavailable(error) from None

    @property
    def replays(self) -> frozenset[str]:
        """The commands that repeat its plants: they name the seed, and how it was played."""
        return frozenset(each.replay for each in self.judged)

    def add(self, judgement: Judgement) -> None:
        """Append a judgement.

        Raises:
            UnavailableError: the file cannot be written.
        """
        try:
            with self._path.open("ab") as file:
                file.write(msgspec.json.encode(judgement) + b"\n")
        except OSError as error:
            raise self._unavailable(error) from None
        self.judged.append(judgement)

    def _read(self, line: bytes, number: int) -> Judgement:
        try:
            return msgspec.json.decode(line, type=Judgement)
        except msgspec.DecodeError as error:
            reason = (
                f"line {number} of {self._path} is no judgement of a plant ({error}): choose another file"
            )
            raise SettingsError(OPTION, reason) from None

    def _unavailable(self, error: OSError) -> UnavailableError:
        reason = error.strerror or str(error)
        return UnavailableError(str(self._path), reason, f"choose another file for {OPTION}")

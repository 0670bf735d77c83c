"""A file of judgements, one JSON line per plant: a run over many plants can be ended at any moment, and goes on later.

A line is in the file as soon as its plant is judged. A line without an end was being written when the process was
killed: it is left out, and its plant is played again. Nothing is cut off, so several runs may share a file. The file
says nothing about the version of the code: use another file for another version.
"""

from __future__ import annotations

from pathlib import Path

import msgspec

from dray.errors import SettingsError, UnavailableError
from dray_sim.plants.play import Judgement

OPTION = "--keep"

BEGIN = b'{"seed":'
"""How a line begins. A line without an end that begins otherwise is something else."""


class JudgementFile:
    """The judgements of a file, in its order, each plant once; a file that is not there is made.

    Args:
        path: of the file.

    Raises:
        SettingsError: a line is no judgement.
        UnavailableError: the file cannot be read or written.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        judged: dict[str, Judgement] = {}
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with path.open("a+b") as file:
                file.seek(0)
                *lines, rest = file.read().split(b"\n")
                for number, line in enumerate((*lines, rest), 1):
                    if (judgement := self._read(line, number)) is not None:
                        judged.setdefault(judgement.replay, judgement)
                if rest:
                    file.write(b"\n")
        except OSError as error:
            raise self._unavailable(error) from None
        self.judged = list(judged.values())

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

    def _read(self, line: bytes, number: int) -> Judgement | None:
        """The judgement of a line; None for one without an end."""
        try:
            return msgspec.json.decode(line, type=Judgement)
        except msgspec.DecodeError as error:
            is_whole = isinstance(error, msgspec.ValidationError)
            if not is_whole and BEGIN.startswith(line[: len(BEGIN)]):
                return None
            reason = (
                f"line {number} of {self._path} is no judgement of a plant ({error}): choose another file"
            )
            raise SettingsError(OPTION, reason) from None

    def _unavailable(self, error: OSError) -> UnavailableError:
        reason = error.strerror or str(error)
        return UnavailableError(str(self._path), reason, f"choose another file for {OPTION}")

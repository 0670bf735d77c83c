"""The ledger of a search: a file with one line per played seed, so that a search that was ended goes on.

Each process of a search appends the line of a seed as soon as the seed is played, in one piece. A process that is killed
leaves at most a torn last line, and its seed is played again. A line holds for the code that it names, and for no other.
"""

from __future__ import annotations

import datetime as dt
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import msgspec

from dray.errors import SettingsError, UnavailableError
from dray_sim.explore.code_key import CodeKey
from dray_sim.explore.outcome import Outcome

REMEDY = "choose another file for --ledger"

HEAD = b'{"code":"'
"""Every line begins with it."""


class Entry(msgspec.Struct, frozen=True):
    """One played seed. `code` stands first: see `HEAD`."""

    code: str
    """Digest of the code that played it."""
    commit: str
    """Its commit (see `CodeKey`)."""
    day: str
    """The day (UTC)."""
    took_s: float
    """Processor time."""
    outcome: Outcome


_decode = msgspec.json.Decoder(Entry).decode


@dataclass(frozen=True, slots=True)
class Ledger:
    """A ledger file, for one code.

    Args:
        path: of the file; it need not exist.
        code: that plays the seeds.
    """

    path: Path
    code: CodeKey

    def begin(self) -> None:
        """Prepare the file for new lines: make it, and end a torn last line.

        Raises:
            SettingsError: the file is something else.
            UnavailableError: it cannot be written.
        """
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with self.path.open("a+b") as file:
                file.seek(0)
                if not _is_ledger(file):
                    raise SettingsError(
                        "--ledger", f"{self.path} is no ledger of a search: choose another file"
                    )
                if file.seek(0, os.SEEK_END):
                    file.seek(-1, os.SEEK_END)
                    if file.read(1) != b"\n":
                        file.write(b"\n")
        except OSError as error:
            raise UnavailableError(str(self.path), error.strerror or str(error), REMEDY) from None

    def add(self, outcome: Outcome, took_s: float) -> None:
        """Append a played seed; safe in several processes at once.

        Raises:
            UnavailableError: the file cannot be written.
        """
        day = dt.datetime.now(dt.UTC).date().isoformat()
        entry = Entry(self.code.digest, self.code.commit, day, took_s, outcome)
        try:
            with self.path.open("ab") as file:
                file.write(msgspec.json.encode(entry) + b"\n")
        except OSError as error:
            raise UnavailableError(str(self.path), error.strerror or str(error), REMEDY) from None

    def played(self, profile: str, *, traffic: bool) -> dict[int, Entry]:
        """The seeds of a profile that this code has played, with or without right of way.

        Raises:
            UnavailableError: the file cannot be read.
        """
        return {
            entry.outcome.seed: entry
            for entry in read_ledger(self.path)
            if (entry.code, entry.outcome.profile, entry.outcome.traffic)
            == (self.code.digest, profile, traffic)
        }


def _is_ledger(file: BinaryIO) -> bool:
    """Whether the first lines are torn ones, and the next one is an entry or the file's end."""
    while begin := file.readline(len(HEAD)):
        if begin == HEAD:
            return True
        if not HEAD.startswith(begin.removesuffix(b"\n")):
            return False
    return True


def read_ledger(path: Path) -> Iterator[Entry]:
    """All played seeds, in the order in which they were played; torn lines are left out.

    Raises:
        UnavailableError: the file cannot be read.
    """
    try:
        lines = path.read_bytes().split(b"\n")
    except OSError as error:
        raise UnavailableError(str(path), error.strerror or str(error), REMEDY) from None
    for line in lines:
        try:
            yield _decode(line)
        except msgspec.DecodeError:
            continue

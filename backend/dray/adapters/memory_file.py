"""What one life of a body leaves to the next: a small file, replaced as a whole."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import Generic, TypeVar

import msgspec

from dray.errors import UnavailableError

Kept = TypeVar("Kept", bound=msgspec.Struct)


class MemoryFile(Generic[Kept]):
    """Keeps one value.

    Args:
        path: the file; its folder is made.
        kind: of the value.
        damaged: what is remembered where the file cannot be read.

    Attributes:
        lost: why nothing is remembered though there was a file; empty when that is not so.
    """

    def __init__(self, path: Path, kind: type[Kept], damaged: Kept) -> None:
        self._path, self._kind, self._damaged = path, kind, damaged
        self.lost = ""

    def read(self) -> Kept | None:
        """What was written last; None where there is nothing.

        Raises:
            UnavailableError: it is there and cannot be read.
        """
        try:
            return msgspec.json.decode(self._path.read_bytes(), type=self._kind)
        except FileNotFoundError:
            return None
        except OSError as error:
            raise self._unavailable(error) from None
        except (msgspec.DecodeError, UnicodeDecodeError) as error:
            aside = self._path.with_suffix(".damaged")
            self._keep_aside(aside)
            self.lost = f"{self._path} is damaged ({error}), and is kept as {aside.name}"
            return self._damaged

    def write(self, memory: Kept) -> None:
        """Keep it; it is on the disk at the return.

        Raises:
            UnavailableError: it cannot be written.
        """
        draft = self._path.with_suffix(".draft")
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            with draft.open("wb") as file:
                file.write(msgspec.json.encode(memory))
                file.flush()
                os.fsync(file.fileno())
            draft.replace(self._path)
        except OSError as error:
            raise self._unavailable(error) from None

    def _keep_aside(self, aside: Path) -> None:
        """Whoever is killed before the next `write` finds that it was damaged: a file that is gone would be a first life's."""
        try:
            shutil.copyfile(self._path, aside)
        except OSError as error:
            raise self._unavailable(error) from None
        self.write(self._damaged)

    def _unavailable(self, error: OSError) -> UnavailableError:
        reason = error.strerror or str(error)
        return UnavailableError(
            str(self._path), reason, "see DRAY_JOURNAL_FOLDER, and whether the disk is full"
        )

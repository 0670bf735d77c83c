"""A body's memory for its next life: a small file, replaced as a whole."""

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
        path: the file; its folder is created.
        kind: the value's type.
        damaged: the value that replaces an unreadable file.

    Attributes:
        damaged: that value.
        lost: why nothing is remembered though there was a file; empty otherwise.
    """

    def __init__(self, path: Path, kind: type[Kept], damaged: Kept) -> None:
        self._path, self._kind, self.damaged = path, kind, damaged
        self.lost = ""

    @property
    def exists(self) -> bool:
        """Whether something was written."""
        return self._path.exists()

    def read(self) -> Kept | None:
        """The last written value; None where there is none.

        Raises:
            UnavailableError: the file exists and cannot be read.
        """
        try:
            return msgspec.json.decode(self._path.read_bytes(), type=self._kind)
        except FileNotFoundError:
            return None
        except OSError as error:
            raise self._unavailable(error) from None
        except (msgspec.DecodeError, UnicodeDecodeError) as error:
            aside = self._path.with_suffix(".damaged")
            self._keep_aside(aside, self.damaged)
            self.lost = f"{self._path} is damaged ({error}), and is kept as {aside.name}"
            return self.damaged

    def write(self, memory: Kept) -> None:
        """Store a value; it is on the disk at the return.

        Raises:
            UnavailableError: writing failed.
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

    def outdate(self, instead: Kept, reason: str) -> None:
        """Replace a value that is not true any more; the file is kept aside.

        Args:
            instead: the value from now on.
            reason: why, in words.

        Raises:
            UnavailableError: reading or writing failed.
        """
        if not self.exists:
            self.write(instead)
        elif self.read() != instead:
            aside = self._path.with_suffix(".outdated")
            self._keep_aside(aside, instead)
            self.lost = f"{self._path} is not used, since {reason}, and is kept as {aside.name}"

    def _keep_aside(self, aside: Path, instead: Kept) -> None:
        """Copy the file aside and write another value in its place: a missing file would mean a first life."""
        try:
            shutil.copyfile(self._path, aside)
        except OSError as error:
            raise self._unavailable(error) from None
        self.write(instead)

    def _unavailable(self, error: OSError) -> UnavailableError:
        reason = error.strerror or str(error)
        return UnavailableError(
            str(self._path), reason, "see DRAY_JOURNAL_FOLDER, and whether the disk is full"
        )

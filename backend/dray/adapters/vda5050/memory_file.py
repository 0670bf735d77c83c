"""What one life of a vehicle's master leaves to the next: a small file, replaced as a whole."""

from __future__ import annotations

import os
from pathlib import Path

import msgspec

from dray.adapters.vda5050.events import Memory
from dray.errors import UnavailableError


class MemoryFile:
    """Keeps a `Memory`.

    Args:
        path: the file; its folder is made.

    Attributes:
        lost: why nothing is remembered though there was a file; empty when that is not so.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.lost = ""

    def read(self) -> Memory:
        """What was written last; nothing known where there is nothing.

        Raises:
            UnavailableError: it is there and cannot be read.
        """
        try:
            return msgspec.json.decode(self._path.read_bytes(), type=Memory)
        except FileNotFoundError:
            return Memory()
        except OSError as error:
            raise self._unavailable(error) from None
        except (msgspec.DecodeError, UnicodeDecodeError) as error:
            aside = self._path.with_suffix(".damaged")
            self._path.replace(aside)
            self.lost = f"{self._path} is damaged ({error}), and was moved to {aside.name}"
            return Memory(
                doubt="what was remembered is damaged: see what is on board, and switch it to MANUAL and back"
            )

    def write(self, memory: Memory) -> None:
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

    def _unavailable(self, error: OSError) -> UnavailableError:
        reason = error.strerror or str(error)
        return UnavailableError(
            str(self._path), reason, "see DRAY_JOURNAL_FOLDER, and whether the disk is full"
        )

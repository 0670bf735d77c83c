"""What one life of a body leaves to the next, and what is found where that is damaged."""

from __future__ import annotations

from pathlib import Path

import pytest
from msgspec import Struct

from dray.adapters.memory_file import MemoryFile


class Note(Struct, frozen=True):
    number: int


DAMAGED = Note(-1)


def file(folder: Path) -> MemoryFile[Note]:
    return MemoryFile(folder / "S3.store.json", Note, DAMAGED)


def test_what_was_written_is_read_and_nothing_where_nothing_was(tmp_path: Path) -> None:
    assert file(tmp_path).read() is None
    file(tmp_path).write(Note(7))
    assert file(tmp_path).read() == Note(7)


@pytest.mark.parametrize("text", [b"", b"{", b'{"number": "x"}', b"\xff\xfe"])
def test_a_damaged_file_is_kept_aside_and_no_later_life_takes_itself_for_the_first(
    tmp_path: Path, text: bytes
) -> None:
    path = tmp_path / "S3.store.json"
    path.write_bytes(text)
    first = file(tmp_path)
    assert (first.read(), "is damaged" in first.lost) == (DAMAGED, True)
    assert (tmp_path / "S3.store.damaged").read_bytes() == text
    # It is killed before it writes anything.
    assert file(tmp_path).read() == DAMAGED

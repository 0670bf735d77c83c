"""docs/reading.md as data, and what a running part of Dray really passes."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import FrameType

import dray

ROOT = Path(__file__).parents[2]
CODE = f"{Path(dray.__file__).parent}/"
FRONTEND = ROOT / "frontend/src"

ITEM = re.compile(r"^(\d+)\. `([\w.]+)` \(`([\w./-]+)`\): \S", re.MULTILINE)

Passed = tuple[str, str]
"""A function by its name, and the file that it is in."""


@cache
def sections() -> dict[str, dict[str, list[Passed]]]:
    """By heading and the heading below it, what is passed there, in its order."""
    text = (ROOT / "docs/reading.md").read_text(encoding="utf-8")
    read: dict[str, dict[str, list[Passed]]] = {}
    for section in text.split("\n## ")[1:]:
        heading, _, rest = section.partition("\n")
        parts = read[heading] = {}
        for part in rest.split("\n### ")[1:]:
            items = ITEM.findall(part)
            numbered = re.findall(r"^\d+\. ", part, re.MULTILINE)
            assert [number for number, _, _ in items] == [f"{n}" for n in range(1, len(numbered) + 1)], part
            parts[part.partition("\n")[0]] = [(name, file) for _, name, file in items]
    return read


class Walk:
    """Follows the parts of one section, one after the other, while Dray runs.

    Attributes:
        left: the parts that have not been walked yet, the next one first.
        furthest: how far the next one was walked at best.
    """

    def __init__(self, parts: dict[str, list[Passed]]) -> None:
        self.left = list(parts.items())
        self.furthest = 0

    def step(self, calls: list[Passed]) -> None:
        """Something has passed these."""
        if not self.left:
            return
        _, wanted = self.left[0]
        count = 0
        for call in calls:
            if call == wanted[count]:
                count += 1
                if count == len(wanted):
                    self.left.pop(0)
                    self.furthest = 0
                    return
        self.furthest = max(self.furthest, count)

    def __str__(self) -> str:
        if not self.left:
            return "walked to its end"
        heading, wanted = self.left[0]
        return f"'{heading}' is never walked past {wanted[self.furthest]}"


@contextmanager
def calls() -> Iterator[list[Passed]]:
    """What is called of Dray meanwhile on this thread, in its order."""
    seen: list[Passed] = []

    def note(frame: FrameType, event: str, _: object) -> None:
        code = frame.f_code
        if event == "call" and code.co_filename.startswith(CODE):
            seen.append((code.co_qualname, code.co_filename[len(CODE) :]))

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        yield seen
    finally:
        sys.setprofile(before)

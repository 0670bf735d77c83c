"""One step of a commissioning: what was tried, and what came of it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Step:
    """What came of one step.

    Attributes:
        name: what was tried.
        passed: None when it was left out.
        text: what was seen.
    """

    name: str
    passed: bool | None
    text: str

    @property
    def line(self) -> str:
        mark = {True: "ok", False: "NO", None: "--"}[self.passed]
        return f"{mark:4} {self.name:12} {self.text}"

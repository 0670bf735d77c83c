"""The steps of a commissioning: what was tried, and what came of it."""

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


class Steps:
    """Those of one commissioning so far."""

    def __init__(self) -> None:
        self._steps: list[Step] = []

    def note(self, step: Step) -> Step:
        """One more."""
        self._steps.append(step)
        return step

    @property
    def passed(self) -> bool:
        """Something was tried, and nothing that was has failed."""
        return bool(self._steps) and all(step.passed is not False for step in self._steps)

    @property
    def lines(self) -> tuple[str, ...]:
        """For a report in Markdown."""
        return tuple(f"    {step.line}" for step in self._steps)

"""The steps of a commissioning, with their results."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Step:
    """The result of one step.

    Attributes:
        name: the step's name.
        passed: whether it succeeded; None for a skipped step.
        text: the observation.
    """

    name: str
    passed: bool | None
    text: str

    @property
    def line(self) -> str:
        mark = {True: "ok", False: "NO", None: "--"}[self.passed]
        return f"{mark:4} {self.name:12} {self.text}"


class Steps:
    """The steps of one commissioning so far."""

    def __init__(self) -> None:
        self._steps: list[Step] = []

    def note(self, step: Step) -> Step:
        """Add a step."""
        self._steps.append(step)
        return step

    @property
    def passed(self) -> bool:
        """Whether at least one step was tried, and none failed."""
        return bool(self._steps) and all(step.passed is not False for step in self._steps)

    @property
    def lines(self) -> tuple[str, ...]:
        """The lines of a report in Markdown."""
        return tuple(f"    {step.line}" for step in self._steps)

"""States with a table of transitions: the only place that changes a state."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from typing import Generic, TypeVar

from dray.errors import ProtocolViolation

S = TypeVar("S", bound=StrEnum)

Transitions = Mapping[S, Mapping[S, str]]
"""The allowed next states of each state, with the cause of each."""


class States(Generic[S]):
    """The state of one object.

    Args:
        what: the object's name, for the error.
        transitions: its table.
        first: the initial state.

    Attributes:
        now: its present state.
    """

    __slots__ = ("_transitions", "_what", "now")

    def __init__(self, what: str, transitions: Transitions[S], first: S) -> None:
        self._what = what
        self._transitions = transitions
        self.now = first

    def enter(self, state: S) -> None:
        """Change the state.

        Raises:
            ProtocolViolation: the table does not allow it. The fault is ours.
        """
        if state not in self._transitions[self.now]:
            raise ProtocolViolation(f"{self._what} that is {self.now} cannot become {state}")
        self.now = state


def diagram(transitions: Transitions[S]) -> str:
    """A table as a Mermaid state diagram; it begins with the first state of the table."""
    first = next(iter(transitions))
    lines = ["stateDiagram-v2", f"    [*] --> {first}"]
    for state, row in transitions.items():
        lines += [f"    {state} --> {after}: {why}" for after, why in row.items()]
        if not row:
            lines.append(f"    {state} --> [*]")
    return "\n".join(lines)

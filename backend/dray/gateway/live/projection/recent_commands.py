"""Recent commands of people to vehicles, and their outcomes."""

from __future__ import annotations

from collections.abc import Iterable

from dray.gateway.live.projection.changes import Changes
from dray.gateway.live.reasons import refusal_text
from dray.gateway.live.views import CommandState, CommandView
from dray.messages import CommandAnswered

RECENT_KEPT = 200
"""Commands kept: the last fifty per area, where four areas are busy. The audit log has all."""


class RecentCommands:
    """The commands, the oldest first."""

    def __init__(self) -> None:
        self._commands: dict[str, CommandView] = {}
        self._areas: dict[str, frozenset[str]] = {}
        self.changes = Changes("command")

    def put(self, command: CommandView, areas: Iterable[str]) -> None:
        """Show a command that was just sent.

        Args:
            command: the command.
            areas: the vehicle's areas by its last heartbeat, and those of the person who gave the command.
                People of these areas see the command, wherever the vehicle goes.
        """
        self._commands[command.id] = command
        self._areas[command.id] = frozenset(areas)
        self.changes.mark(command.id)
        if len(self._commands) > RECENT_KEPT:
            oldest = next(iter(self._commands))
            del self._commands[oldest], self._areas[oldest]
            self.changes.drop(oldest)

    def end(self, command: str, state: CommandState, answer: CommandAnswered | None = None) -> bool:
        """Show the outcome of a command; returns whether the command is still kept."""
        known = self._commands.get(command)
        if known is None:
            return False
        known.state = state
        if answer is not None:
            known.reason = "" if answer.reason is None else answer.reason.value
            known.detail, known.text = answer.detail, refusal_text(answer)
        self.changes.mark(command)
        return True

    def areas_of(self, command: str) -> frozenset[str]:
        """The areas of the command's vehicle when it was given."""
        return self._areas.get(command, frozenset())

    def views(self) -> tuple[CommandView, ...]:
        """All of them, oldest first."""
        return tuple(self._commands.values())

    def take_changed(self) -> tuple[CommandView, ...]:
        """Those that have changed since the last call."""
        return tuple(self._commands[command] for command in self.changes.take_changed())

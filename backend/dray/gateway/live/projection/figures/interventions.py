"""Interventions: how often people had to help or command a vehicle."""

from __future__ import annotations

from typing import ClassVar

from dray.gateway.live.projection.figures.sliding_window import Window
from dray.gateway.live.projection.figures.time_use import HOUR_SLOTS
from dray.messages import Event
from dray.messages.fact import CommandObeyed, HelpAsked

SEEN_KEPT = 1_000
"""Facts kept to recognise duplicates: hours of a plant where people intervene a lot."""

COMMAND_S, HELP_S = 0.2, 10.0
"""Minimum seconds between two commands to one vehicle, and between two of its calls for help."""


class Interventions:
    """Counts vehicles' reports of people's interventions.

    Attributes:
        commands: commands that vehicles obeyed since the beginning.
        helps: calls for help by vehicles since the beginning.
    """

    heeded: ClassVar[tuple[type, ...]] = (CommandObeyed, HelpAsked)
    """Kinds of facts that count."""

    def __init__(self) -> None:
        self.commands = self.helps = 0
        self._commands, self._helps = Window(*HOUR_SLOTS), Window(*HOUR_SLOTS)
        self._seen: dict[tuple[str, int, int], None] = {}
        self._last_s: dict[tuple[str, bool], float] = {}
        """Per vehicle and kind (command or not), the time of the last one counted."""

    def fold(self, event: Event) -> bool:
        """Take an event in; False when it is no intervention or a duplicate."""
        fact = event.fact
        obeyed = isinstance(fact, CommandObeyed) and fact.done
        if not (obeyed or isinstance(fact, HelpAsked)) or not self._is_new(event):
            return False
        if not self._is_possible(event, obeyed=obeyed):
            return False
        if obeyed:
            self.commands += 1
            self._commands.add(event.at_s, 1)
        else:
            self.helps += 1
            self._helps.add(event.at_s, 1)
        return True

    def in_hour(self, now_s: float) -> tuple[int, int]:
        """Commands and helps of the last hour of factory time."""
        (commands,), (helps,) = self._commands.sums(now_s, 1), self._helps.sums(now_s, 1)
        return int(commands), int(helps)

    def _is_possible(self, event: Event, *, obeyed: bool) -> bool:
        """Whether enough time has passed since the last one: a vehicle cannot report faster."""
        name = event.agent, obeyed
        last_s = self._last_s.pop(name, None)
        is_possible = last_s is None or abs(event.at_s - last_s) >= (COMMAND_S if obeyed else HELP_S)
        self._last_s[name] = event.at_s if is_possible or last_s is None else last_s
        if len(self._last_s) > SEEN_KEPT:
            del self._last_s[next(iter(self._last_s))]
        return is_possible

    def _is_new(self, event: Event) -> bool:
        name = event.agent, event.incarnation, event.number
        if name in self._seen:
            return False
        self._seen[name] = None
        if len(self._seen) > SEEN_KEPT:
            del self._seen[next(iter(self._seen))]
        return True

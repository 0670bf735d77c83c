"""People's reports to an agent whose body is people: granted ones go to the body, which stores and answers them."""

from __future__ import annotations

from collections.abc import Iterable

from dray.body import Word, WordTaken
from dray.messages import MachineCommand
from dray.protocol.people.granted_commands import Answer, GrantedCommands, key_of
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.life import Life

WORDS_ASKED = 100
"""Maximum unanswered reports at a body, which answers each at once."""


class PassedWords:
    """The reports to one agent.

    Args:
        granted: checks which reports may be passed on.
    """

    def __init__(self, granted: GrantedCommands[MachineCommand], life: Life) -> None:
        self._granted, self._life = granted, life
        self._asked: BoundedMap[str, tuple[str, MachineCommand]] = BoundedMap(WORDS_ASKED)
        """Reports passed to the body, by their keys, with their senders."""
        self._answers: BoundedMap[str, Answer] = BoundedMap(WORDS_ASKED)
        """The body's last answers, by the reports' keys: a copy that comes after its grant's end is no new report."""

    def pass_on(
        self, sender: str, command: MachineCommand, places_m: Iterable[tuple[float, float]], now_s: float
    ) -> None:
        """Pass a person's report on to the body.

        Args:
            sender: the agent to answer.
            command: the report.
            places_m: the places that it is about (x, y) in m: the grant covers at least one.
            now_s: the present time.
        """
        grant = self._granted.permits(sender, command, places_m, now_s, self._answers)
        if grant is None:
            return
        key = key_of(command, grant)
        self._asked[key] = sender, command
        word = Word(
            key=key,
            kind=command.kind,
            item=command.item,
            quantity=command.quantity,
            vehicle=command.vehicle,
            sure=command.sure,
        )
        self._life.instruct(word)

    def on_taken(self, report: WordTaken) -> MachineCommand | None:
        """The body has accepted or refused a report. Returns an accepted one; None for any other."""
        asked = self._asked.pop(report.key, None)
        if asked is None:
            return None
        self._answers[report.key] = report.refused, report.detail
        self._granted.tell(*asked, report.refused, report.detail, again=report.again)
        return asked[1] if report.refused is None and not report.again else None

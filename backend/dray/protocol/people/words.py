"""Words of people to an agent whose body is people: what has a grant is passed on to the body, which remembers it and answers."""

from __future__ import annotations

from collections.abc import Iterable

from dray.body import Word, WordTaken
from dray.messages import MachineCommand
from dray.protocol.people.granted_commands import GrantedCommands
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.life import Life

WORDS_ASKED = 100
"""Words whose answers a body owes at once: it answers each in the same moment."""


class PassedWords:
    """Those of one agent.

    Args:
        granted: whose words may be passed on.
    """

    def __init__(self, granted: GrantedCommands[MachineCommand], life: Life) -> None:
        self._granted, self._life = granted, life
        self._asked: BoundedMap[str, tuple[str, MachineCommand]] = BoundedMap(WORDS_ASKED)
        """Words that the body was told, by their keys, with who has said them."""

    def pass_on(
        self, sender: str, command: MachineCommand, places_m: Iterable[tuple[float, float]], now_s: float
    ) -> None:
        """Tell the body what a person says.

        Args:
            sender: whom to answer.
            command: a word.
            places_m: where it is about (x, y): it is granted for one of them at least.
            now_s: the present time.
        """
        grant = self._granted.permits(sender, command, places_m, now_s)
        if grant is None:
            return
        key = f"{grant.person}/{command.command}"
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

    def on_taken(self, report: WordTaken) -> None:
        """The body has taken a word, or says why not."""
        asked = self._asked.pop(report.key, None)
        if asked is not None:
            self._granted.tell(*asked, report.refused, report.detail, again=report.again)

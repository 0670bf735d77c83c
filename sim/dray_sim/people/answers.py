"""The answers to commands: the person who gave a command waits here for the vehicle's answer."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager

from dray.messages import CommandAnswered

Answer = asyncio.Future[CommandAnswered]


class Answers:
    """The answers that one person waits for."""

    def __init__(self) -> None:
        self._awaited: dict[str, Answer] = {}
        """Futures by command, only those that are awaited now."""

    @contextmanager
    def to(self, command: str) -> Iterator[Answer]:
        """Wait for the answer to a command that is said, and maybe said again, while this lasts.

        Args:
            command: its id.

        Returns:
            Done with the first answer.
        """
        answer: Answer = asyncio.get_running_loop().create_future()
        self._awaited[command] = answer
        try:
            yield answer
        finally:
            del self._awaited[command]

    def take(self, answered: CommandAnswered) -> None:
        """A vehicle has answered. There may be no waiter any more: a repeated command is answered twice."""
        answer = self._awaited.get(answered.command)
        if answer is not None and not answer.done():
            answer.set_result(answered)

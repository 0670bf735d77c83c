"""An actor of the properties' kits that is played from its first moment."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from actors import Actor

from dray.messages import Message
from dray.protocol.runtime.events import Effect, Publish, Send

M = TypeVar("M")


class Played(Actor):
    """An actor that remembers what it has said last, of every type."""

    def __init__(self, *args: object) -> None:
        super().__init__(*args, self._note)  # type: ignore[arg-type]
        self.effects: list[Effect] = []
        """All that it wanted done; clear it at will."""
        self.last: dict[type[Message], Message] = {}
        self.start(0.0)

    def _note(self, effect: Effect) -> None:
        self.effects.append(effect)
        if isinstance(effect, Send | Publish):
            self.last[type(effect.message)] = effect.message

    def newest(self, kind: type[M]) -> M | None:
        message = self.last.get(kind)  # type: ignore[call-overload]
        return message if isinstance(message, kind) else None

    def told(self, sender: str, message: Message) -> Played:
        self.on_message(sender, message, self.now_s)
        return self

    def until(self, condition: Callable[[Played], object]) -> Played:
        """Play on until something is so."""
        for _ in range(2000):
            if condition(self):
                return self
            self.step(max(self.now_s, self.next_s))
        raise AssertionError(f"it never came to that: {condition}")

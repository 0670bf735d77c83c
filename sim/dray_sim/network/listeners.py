"""Listeners: whoever hears all that is said on a network, and takes no part."""

from __future__ import annotations

from typing import Protocol

from dray.messages import Event, Message


class Listener(Protocol):
    """Whoever wants to know all that is said on a network."""

    def on_message(self, at_s: float, sender: str, address: str, message: Message) -> None:
        """Note one utterance; must not say anything itself. What it raises ends the run: a broken invariant.

        Args:
            at_s: virtual seconds.
            sender: an agent's id.
            address: a key, or ``>`` and the id of the one agent it was sent to.
            message: what was said.
        """
        ...


class Listeners:
    """Several listeners in one, asked in the order in which they were added.

    What an agent tells again out of its history, to one that has missed it, is said to that one alone and is no news: who counts what
    happens would count it twice.
    """

    def __init__(self) -> None:
        self._listeners: tuple[Listener, ...] = ()

    def add(self, *listeners: Listener) -> None:
        """Let these hear everything, too, from now on."""
        self._listeners += listeners

    def clear(self) -> None:
        """Nobody hears anything any more."""
        self._listeners = ()

    def on_message(self, at_s: float, sender: str, address: str, message: Message) -> None:
        """See `Listener`."""
        if type(message) is Event and address.startswith(">"):
            return
        for listener in self._listeners:
            listener.on_message(at_s, sender, address, message)

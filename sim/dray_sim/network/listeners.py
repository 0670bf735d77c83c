"""Listeners hear all messages on a network, and take no part."""

from __future__ import annotations

from typing import Protocol

from dray.messages import Event, Message


class Listener(Protocol):
    """Hears all messages on a network."""

    def on_message(self, at_s: float, sender: str, address: str, message: Message) -> None:
        """Note one utterance; must not say anything itself. An exception ends the run: a broken invariant.

        Args:
            at_s: virtual seconds.
            sender: an agent's id.
            address: a key, or ``>`` and the id of the one agent it was sent to.
            message: the message.
        """
        ...


class Listeners:
    """Several listeners in one, asked in the order in which they were added.

    A fact that an agent repeats from its history, for an agent that missed it, is no news: listeners that count
    events would count it twice.
    """

    def __init__(self) -> None:
        self._listeners: tuple[Listener, ...] = ()

    def add(self, *listeners: Listener) -> None:
        """Let these hear everything, too, from now on."""
        self._listeners += listeners

    def clear(self) -> None:
        """Remove all listeners."""
        self._listeners = ()

    def on_message(self, at_s: float, sender: str, address: str, message: Message) -> None:
        """See `Listener`."""
        if type(message) is Event and address.startswith(">"):
            return
        for listener in self._listeners:
            listener.on_message(at_s, sender, address, message)

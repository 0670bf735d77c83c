"""Passing: a place on a bus that passes everything on to another one."""

from __future__ import annotations

from dray.messages import Message
from dray.ports import Session


class PassingSession:
    """The base of sessions that see to something more than saying it (see `dray.ports.Session`).

    Args:
        inner: the place on the bus itself.
    """

    def __init__(self, inner: Session) -> None:
        self.inner = inner

    @property
    def context(self) -> str:
        return self.inner.context

    @context.setter
    def context(self, context: str) -> None:
        self.inner.context = context

    def publish(self, key: str, message: Message) -> None:
        """Say it to all that listen on `key`."""
        self.inner.publish(key, message)

    def send(self, to: str, message: Message) -> None:
        """Say it to one agent alone."""
        self.inner.send(to, message)

    def subscribe(self, key: str) -> None:
        """Hear what is published on `key` from now on."""
        self.inner.subscribe(key)

    def unsubscribe(self, key: str) -> None:
        """Hear it no longer."""
        self.inner.unsubscribe(key)

    def leave(self) -> None:
        """Leave the bus."""
        self.inner.leave()

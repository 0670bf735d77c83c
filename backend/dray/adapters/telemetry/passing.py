"""Passing: a session on a bus that forwards all calls to another one."""

from __future__ import annotations

from dray.messages import Message
from dray.ports import Session


class PassingSession:
    """The base of sessions that add something to a call (see `dray.ports.Session`).

    Args:
        inner: the wrapped session.
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
        """Publish to all subscribers of `key`."""
        self.inner.publish(key, message)

    def send(self, to: str, message: Message) -> None:
        """Send to one agent alone."""
        self.inner.send(to, message)

    def subscribe(self, key: str) -> None:
        """Hear what is published on `key` from now on."""
        self.inner.subscribe(key)

    def unsubscribe(self, key: str) -> None:
        """Stop hearing it."""
        self.inner.unsubscribe(key)

    def leave(self) -> None:
        """Leave the bus."""
        self.inner.leave()

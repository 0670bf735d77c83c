"""The fact log: a bus that writes its agents' facts into the log of their process.

Fields of a fact become fields of the record, so that a structured log can be searched by task and epoch.
"""

from __future__ import annotations

import logging

from dray.adapters.telemetry.passing import PassingSession
from dray.messages import Event, Message
from dray.ports import Bus, Receive, Session

FACTS = "dray.facts"
"""The logger of facts; their level is INFO."""

FIELDS = ("task", "epoch", "role", "goal", "order", "reason")
"""Fields of facts that are useful for searching."""

_log = logging.getLogger(FACTS)


class LoggedSession(PassingSession):
    """One agent's session on the bus (see `dray.ports.Session`)."""

    def publish(self, key: str, message: Message) -> None:
        """Publish to all subscribers of `key`, and log facts."""
        if isinstance(message, Event) and _log.isEnabledFor(logging.INFO):
            fact = message.fact
            kind = type(fact).__name__
            told = {name: getattr(fact, name) for name in FIELDS if hasattr(fact, name)}
            _log.info("%s: %s", message.agent, kind, extra={"agent": message.agent, "fact": kind, **told})
        self.inner.publish(key, message)


class LoggedBus:
    """A bus whose agents' facts are logged (see `dray.ports.Bus`).

    Args:
        bus: the bus itself.
    """

    def __init__(self, bus: Bus) -> None:
        self._bus = bus

    def join(self, agent: str, receive: Receive, life: int = 0) -> Session:
        """See `dray.ports.Bus.join`."""
        return LoggedSession(self._bus.join(agent, receive, life))

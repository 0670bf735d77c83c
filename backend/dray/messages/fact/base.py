"""What all facts have in common, and what any agent tells."""

from __future__ import annotations

from dray.messages.base import Part, Text


class Fact(Part, tag_field="kind", tag=True, frozen=True):
    """One thing that happened, named by its class name in `kind`."""


class MemoryLost(Fact, frozen=True):
    """An agent has begun a life without what it was bound by in earlier ones: its journal was lost or damaged."""

    reason: Text

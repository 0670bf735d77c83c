"""The common part of all facts, and the facts of every agent."""

from __future__ import annotations

from typing import Any, ClassVar

import msgspec

from dray.messages.base import Part, Text
from dray.messages.kinds import NOBODY, TELLERS, Kind


class FactType(msgspec.StructMeta):
    """The type of facts: each class names the kinds of agents that may record it."""

    def __new__(
        cls,
        name: str,
        bases: tuple[type, ...],
        namespace: dict[str, Any],
        *,
        told_by: frozenset[Kind] = NOBODY,
        **config: Any,
    ) -> Any:
        return super().__new__(cls, name, bases, namespace | {"told_by": told_by}, **config)


class Fact(Part, metaclass=FactType, tag_field="kind", tag=True, frozen=True):
    """One thing that happened, named by its class name in `kind`.

    Attributes:
        told_by: the kinds of agents that may record it as their own.
    """

    told_by: ClassVar[frozenset[Kind]]


class MemoryLost(Fact, told_by=TELLERS, frozen=True):
    """An agent was started without the obligations of earlier lives: its journal was lost or damaged."""

    reason: Text

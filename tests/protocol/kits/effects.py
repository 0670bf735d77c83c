"""What an agent wanted done: effects by their kind."""

from __future__ import annotations

from typing import TypeVar

from dray.memory import Memory
from dray.messages import Award, Role
from dray.protocol.runtime.events import (
    Commit,
    Effect,
    Ignore,
    Instruct,
    Publish,
    Record,
    Send,
    Subscribe,
    Unsubscribe,
)

T = TypeVar("T")


def deeds(effects: list[Effect]) -> list[Effect]:
    """Everything but the counting of what changed nothing."""
    return [effect for effect in effects if not isinstance(effect, Ignore)]


def sent(effects: list[Effect], kind: type[T], to: str | None = None) -> list[T]:
    """Messages of one kind that were sent to one agent, or to anybody."""
    return [
        effect.message
        for effect in effects
        if isinstance(effect, Send) and isinstance(effect.message, kind) and to in (None, effect.to)
    ]


def published(effects: list[Effect], kind: type[T]) -> list[T]:
    """Messages of one kind that were published; one that went to several keys counts once."""
    found: list[T] = []
    for effect in effects:
        if isinstance(effect, Publish) and isinstance(effect.message, kind) and effect.message not in found:
            found.append(effect.message)
    return found


def facts(effects: list[Effect], kind: type[T]) -> list[T]:
    """Facts of one kind that were recorded."""
    return [effect.fact for effect in effects if isinstance(effect, Record) and isinstance(effect.fact, kind)]


def instructed(effects: list[Effect], kind: type[T]) -> list[T]:
    """Instructions of one kind that the body was given."""
    return [
        effect.instruction
        for effect in effects
        if isinstance(effect, Instruct) and isinstance(effect.instruction, kind)
    ]


def remember(memory: Memory, effects: list[Effect]) -> Memory:
    """What a journal holds after these effects."""
    notes = dict(memory)
    for effect in effects:
        if isinstance(effect, Commit) and effect.note is None:
            notes.pop(effect.name, None)
        elif isinstance(effect, Commit) and effect.note is not None:
            notes[effect.name] = effect.note
    return notes


def committed(effects: list[Effect]) -> Memory:
    """What was written down by these effects, and is not forgotten again; empty when nothing was."""
    return remember({}, effects)


def listening(effects: list[Effect]) -> set[str]:
    """The keys that were subscribed and not unsubscribed again."""
    keys: set[str] = set()
    for effect in effects:
        if isinstance(effect, Subscribe):
            keys.add(effect.key)
        elif isinstance(effect, Unsubscribe):
            keys.discard(effect.key)
    return keys


def award_number(effects: list[Effect], to: str, task: str = "T1", role: Role = Role.PRIMARY) -> int:
    """The number of the newest award of a task to one agent, which its answer carries; 1 when none was."""
    numbers = [
        given.number for given in sent(effects, Award, to=to) if (given.task, given.role) == (task, role)
    ]
    return numbers[-1] if numbers else 1

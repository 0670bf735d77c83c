"""Whatever may be said: every message type with every value that the codec lets through.

Nothing here names a message. The strategies are built from the types themselves, so that a new message
or a new field is covered by itself. What is drawn is type-correct and often absurd: the largest number,
a time before the plant was built, a task of somebody else. To hurt an agent a message must also come close
to the truth, so ids are mostly drawn from those that mean something, by the name of their field.
"""

from __future__ import annotations

import enum
import functools
import types
import typing
from collections.abc import Mapping
from typing import Any

import msgspec
from hypothesis import reject
from hypothesis import strategies as st

from dray.messages import AnyMessage, Message
from dray.messages.product import Address, MediaType, Sha256

MESSAGE_TYPES: tuple[type[Message], ...] = typing.get_args(AnyMessage)

Names = Mapping[str, tuple[str, ...]]
"""Ids that mean something, by the name of a field; under the empty name for all other fields."""

ODD_IDS = ("x", "ATV999", "-", "0", "nobody", "\U0001f69a", "a" * 128)

COUNTS = (0, 1, 1, 1, 2, 3, 40, 2**31, 2**53)
"""An epoch, number or quantity is mostly a small one."""

MAGNITUDES = (0.0, 1.0, -1.0, 0.5, 60.0, 3600.0, 1e-9)


NO_IDS = {
    typing.get_args(kind)[1].pattern: value
    for kind, value in (
        (Address, "https://plm.example/p1.nc"),
        (MediaType, "application/pdf"),
        (Sha256, "ab" * 32),
    )
}
"""By pattern, something of it."""


def made(kind: type[msgspec.Struct], values: dict[str, Any]) -> msgspec.Struct:
    """A value of a type; one in which fields do not fit one another is not drawn."""
    try:
        return kind(**values)
    except ValueError:
        reject()


class Utterances:
    """Strategies for messages in which some ids mean something.

    Args:
        names: those ids.
    """

    def __init__(self, names: Names) -> None:
        self._names = names
        self.message = functools.cache(self._message)

    def any(self) -> st.SearchStrategy[Message]:
        """Any message of any type."""
        return st.one_of([self.message(kind) for kind in MESSAGE_TYPES])

    def sender(self) -> st.SearchStrategy[str]:
        """Who says it: mostly somebody who is known."""
        return self._id("", optional=False)

    def _message(self, kind: type[Message]) -> st.SearchStrategy[Message]:
        return self._struct(kind)

    def _struct(self, kind: type[msgspec.Struct]) -> st.SearchStrategy[Any]:
        required: dict[str, st.SearchStrategy[Any]] = {}
        optional: dict[str, st.SearchStrategy[Any]] = {}
        for field in msgspec.structs.fields(kind):
            into = required if field.required else optional
            into[field.name] = self._value(field.type, field.name)
        return st.fixed_dictionaries(required, optional=optional).map(functools.partial(made, kind))

    def _value(self, hint: Any, name: str) -> st.SearchStrategy[Any]:
        origin, args = typing.get_origin(hint), typing.get_args(hint)
        if origin is typing.Annotated:
            return self._bounded(args[0], args[1], name)
        if origin in (typing.Union, types.UnionType):
            return st.one_of([self._value(arg, name) for arg in args])
        if origin is tuple and args[-1] is not Ellipsis:
            return st.tuples(*[self._value(arg, name) for arg in args])
        if origin is tuple:
            return st.lists(self._value(args[0], name), max_size=3).map(tuple)
        if origin is typing.Literal:
            return st.sampled_from(args)
        if hint is type(None):
            return st.none()
        if hint is msgspec.UnsetType:
            return st.just(msgspec.UNSET)
        if hint is bool:
            return st.booleans()
        if issubclass(hint, enum.Enum):
            return st.sampled_from(hint)
        return self._struct(hint)

    def _bounded(self, hint: Any, meta: msgspec.Meta, name: str) -> st.SearchStrategy[Any]:
        if hint is int:
            low, high = int(meta.ge or 0), int(meta.le or 0)
            return st.sampled_from([each for each in COUNTS if low <= each <= high]) | st.integers(low, high)
        if hint is float:
            low_f, high_f = float(meta.ge or 0.0), float(meta.le or 0.0)
            likely = [low_f, high_f, *(each for each in MAGNITUDES if low_f <= each <= high_f)]
            return st.sampled_from(likely) | st.floats(low_f, high_f)
        if hint is str and meta.pattern in NO_IDS:
            return st.just(NO_IDS[meta.pattern])
        if hint is str and meta.pattern:
            return self._id(name, optional="{0," in meta.pattern)
        if hint is str:
            return st.text(
                st.characters(exclude_categories=["Cs"]), min_size=meta.min_length or 0, max_size=8
            )
        if hint is bytes:
            return st.binary(min_size=meta.min_length or 0, max_size=meta.max_length)
        items = self._value(typing.get_args(hint)[0], name)
        return st.lists(items, min_size=meta.min_length or 0, max_size=3).map(tuple)

    def _id(self, name: str, *, optional: bool) -> st.SearchStrategy[str]:
        pool = [each for each in self._names.get(name, self._names[""]) if each or optional]
        odd = (*ODD_IDS, *self._names[""], *(("",) if optional else ()))
        likely = st.sampled_from(pool)
        return st.one_of(likely, likely, likely, likely, st.sampled_from(odd))

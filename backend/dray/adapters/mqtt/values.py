"""Values in messages: JSON, and the path to a value in it. Pure."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import msgspec

from dray.adapters.signals.signal import Quality, Sample, Value

LARGEST_BYTES = 65_536
"""Maximum size of a message; no sensor sends more."""


def sample_of(data: bytes, path: str, *, text: bool = False) -> Sample:
    """The value of one signal in a message.

    Args:
        data: the message: JSON, or a plain word where there is no path.
        path: to the value in it, as `count.good` or `channels.0.value`; empty for the whole message.
        text: whether the value is always a text: null, or an empty message without a path, is an empty one.
    """
    if text and not path and not data.strip():
        return Sample("")
    if len(data) > LARGEST_BYTES:
        return _nothing(f"a message of {len(data):,} bytes is none of a sensor")
    try:
        value = msgspec.json.decode(data)
    except RecursionError:
        return _nothing("its message is no JSON: it is nested too deeply")
    except msgspec.DecodeError as error:
        word = data.decode("utf-8", "replace").strip()
        is_word = not path and word.isprintable() and word[:1] not in ("", "{", "[", '"')
        return Sample(word) if is_word else _nothing(f"its message is no JSON: {error}")
    for chunk in _chunks(path):
        try:
            value = value[int(chunk)] if isinstance(value, list) else value[chunk]
        except (LookupError, TypeError, ValueError):
            return _nothing(f"its message has nothing at {path!r}")
    if text and value is None:
        return Sample("")
    if isinstance(value, bool | int | float | str):
        return Sample(value)
    return _nothing("it is empty" if value is None else "it is no single value")


def message_of(values: Iterable[tuple[str, Value]]) -> bytes:
    """A message with these values, each at its path."""
    whole: Any = {}
    for path, value in values:
        chunks = _chunks(path)
        if not chunks:
            return msgspec.json.encode(value)
        there = whole
        for chunk in chunks[:-1]:
            there = there.setdefault(chunk, {})
        there[chunks[-1]] = value
    return msgspec.json.encode(whole)


def _chunks(path: str) -> list[str]:
    return [chunk for chunk in path.removeprefix("$").split(".") if chunk]


def _nothing(reason: str) -> Sample:
    return Sample("", Quality.BAD, reason)

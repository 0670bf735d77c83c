"""Tolerant decoding of a vehicle's bytes into `messages`: odd parts are counted and skipped, and nothing raises.

The fast path decodes well-formed messages. Others (NaN, a number as text, a list with one bad entry) are repaired field by
field: otherwise a vehicle with one odd field would be mute.
"""

from __future__ import annotations

import json
from collections import Counter
from math import isfinite
from types import UnionType
from typing import Any, TypeVar, Union, get_args, get_origin

import msgspec

from dray.adapters.vda5050.wire.messages import Said
from dray.messages.base import encodable

S = TypeVar("S", bound=Said)

LARGEST_BYTES = 2**20
"""Maximum size; a state of some hundred nodes and actions has 50 kB."""

LISTED_MAX = 1000
"""Maximum entries of one list that are read: no order of ours has a tenth of it."""

NOT_JSON, NO_OBJECT, TOO_LARGE, ODD_FIELD = "not JSON", "no object", "too large", "an odd field"
"""The counted faults."""


def read(kind: type[S], data: bytes, odd: Counter[str]) -> S | None:
    """A message, or None when nothing of it can be used.

    Args:
        kind: its type.
        data: the received bytes.
        odd: the counter of faults.
    """
    if len(data) > LARGEST_BYTES:
        odd[TOO_LARGE] += 1
        return None
    try:
        return msgspec.json.decode(data, type=kind)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        pass
    try:
        said = json.loads(data)  # It accepts NaN and Infinity, as many vehicles send them.
    except (ValueError, RecursionError):
        odd[NOT_JSON] += 1
        return None
    if not isinstance(said, dict):
        odd[NO_OBJECT] += 1
        return None
    return _mend(kind, said, odd)


def _mend(kind: type[S], said: dict[str, Any], odd: Counter[str]) -> S:
    fields = {}
    for field in msgspec.structs.fields(kind):
        value = said.get(field.encode_name)
        if value is not None:
            fields[field.name] = _fit(field.type, value, odd)
    return kind(**fields)


def _fit(wanted: Any, value: Any, odd: Counter[str]) -> Any:
    """A value converted to this type; None where that is impossible."""
    if get_origin(wanted) in (UnionType, Union):
        wanted = next(part for part in get_args(wanted) if part is not type(None))
    if get_origin(wanted) is tuple:
        if not isinstance(value, list):
            odd[ODD_FIELD] += 1
            return None
        entries = (_fit(get_args(wanted)[0], entry, odd) for entry in value[:LISTED_MAX])
        return tuple(entry for entry in entries if entry is not None)
    if issubclass(wanted, Said):
        if isinstance(value, dict):
            return _mend(wanted, value, odd)
        odd[ODD_FIELD] += 1
        return None
    if isinstance(value, str):
        value = encodable(value)  # A lone surrogate cannot be converted.
    try:
        fitted = msgspec.convert(value, wanted, strict=False)
    except (msgspec.ValidationError, OverflowError):
        odd[ODD_FIELD] += 1
        return None
    if isinstance(fitted, float) and not isfinite(fitted):
        odd[ODD_FIELD] += 1
        return None
    return fitted

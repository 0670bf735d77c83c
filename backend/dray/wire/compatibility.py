"""Changes of the wire that break communication with agents of the last version.

Both versions must read each other, since agents are replaced one at a time. So a field that both know must be the same,
and a field that only one knows must be optional.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from dray.wire.schemas import Schema

_WORDS = frozenset({"title", "description", "default"})
"""Schema entries for people, which no reader checks."""


def breaks(old: dict[str, Schema], new: dict[str, Schema]) -> list[str]:
    """The reasons why agents of the two versions cannot read each other; empty when there are none.

    Args:
        old: all schemas of the last version by name, as `dray.wire.schemas.parts` gives them.
        new: all schemas of this version.
    """
    return [fault for name, schema in old.items() for fault in _part_breaks(name, schema, new.get(name))]


def _part_breaks(name: str, old: Schema, new: Schema | None) -> Iterator[str]:
    if new is None:
        yield f"{name} is gone"
    elif "properties" not in old or "properties" not in new:
        if _meaning(old) != _meaning(new):
            yield f"{name} is another"
    else:
        yield from _field_breaks(name, old, new)


def _field_breaks(name: str, old: Schema, new: Schema) -> Iterator[str]:
    before, now = old["properties"], new["properties"]
    required_before, required_now = set(old.get("required", ())), set(new.get("required", ()))
    for field in sorted({*before, *now}):
        place = f"{name}.{field}"
        if field not in now:
            if field in required_before:
                yield f"{place} is gone, and the last version needs it"
        elif field not in before:
            if field in required_now:
                yield f"{place} is new, and the last version does not say it: give it a default"
        elif not _agree(before[field], now[field]):
            yield f"{place} is another"
        elif field in required_now - required_before:
            yield f"{place} is needed now, and the last version may leave it out"
        elif field in required_before - required_now:
            yield f"{place} may be left out now, and the last version needs it"


def _agree(old: Schema, new: Schema) -> bool:
    """Whether a field means the same; the new version may add variants of a type."""
    if "discriminator" in old and "discriminator" in new:
        choices = [{choice["$ref"] for choice in schema["anyOf"]} for schema in (old, new)]
        return choices[0] <= choices[1]
    return bool(_meaning(old) == _meaning(new))


def _meaning(schema: Any) -> Any:
    if isinstance(schema, dict):
        return {word: _meaning(value) for word, value in schema.items() if word not in _WORDS}
    if isinstance(schema, list):
        return [_meaning(value) for value in schema]
    return schema

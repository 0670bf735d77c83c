"""States as a vehicle may say them: by the official schema of its version, and beyond it (other types, huge, absent, no JSON)."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

from hypothesis import strategies as st
from official_schemas import folder

ABSENT = object()

NAMES = (
    "",
    "west",
    "middle",
    "east",
    "north",
    "corner",
    "ATV1-1-1",
    "ATV1-1-2",
    "ATV1-1-1-a",
    "hall",
    "pick",
    "nowhere",
)
"""What text is compared with: nodes, orders, actions, maps."""

HUGE = 10**30

JUNK = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-HUGE, HUGE),
    st.floats(),
    st.sampled_from([*NAMES, "x" * 5000, "\ud800", "\u202e"]),
    st.recursive(
        st.none() | st.integers(-9, 9) | st.sampled_from(NAMES),
        lambda inner: (
            st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(NAMES), inner, max_size=3)
        ),
        max_leaves=6,
    ),
    st.just([{}] * 1500),
)

TOO_LARGE, LARGE_BYTES = b"too large", 2_000_000
"""A mark of a message of so many bytes: whole it would make what Hypothesis says of a failure unreadable."""

RAW = st.sampled_from(
    [b"", b"{", b"[]", b"null", b"\xff\xfe", b"[" * 3000, b'{"headerId":1}', b"{}", TOO_LARGE]
)


@cache
def fields(version: str) -> dict[tuple[str, ...], st.SearchStrategy[Any]]:
    """By the path of each field of a state, what the official schema of a version allows there; without the schema nothing is known."""
    place = folder()
    if place is None:
        return dict.fromkeys(PATHS, JUNK)
    schema = json.loads((place / f"{version}.0" / "state.schema").read_text())
    found: dict[tuple[str, ...], st.SearchStrategy[Any]] = {}
    _walk(schema, schema, (), found)
    return found


PATHS = tuple(
    tuple(path.split("."))
    for path in (
        *(
            "headerId",
            "timestamp",
            "orderId",
            "orderUpdateId",
            "lastNodeId",
            "lastNodeSequenceId",
            "driving",
            "paused",
        ),
        *("operatingMode", "nodeStates", "edgeStates", "actionStates", "errors", "loads", "velocity.vx"),
        *("agvPosition.x", "agvPosition.theta", "batteryState.batteryCharge", "safetyState.eStop"),
        *("mobileRobotPosition.x", "powerSupply.stateOfCharge", "instantActionStates"),
    )
)
"""Fields that are changed where the schemas are not there."""


def _walk(
    schema: dict[str, Any], whole: dict[str, Any], path: tuple[str, ...], found: dict[tuple[str, ...], Any]
) -> None:
    for name, part in _solved(schema, whole).get("properties", {}).items():
        found[*path, name] = _values(part, whole)
        _walk(part, whole, (*path, name), found)


def _solved(schema: dict[str, Any], whole: dict[str, Any]) -> dict[str, Any]:
    """A part of a schema, with what it refers to."""
    at: Any = whole
    if "$ref" not in schema:
        return schema
    for step in schema["$ref"].removeprefix("#/").split("/"):
        at = at[step]
    return dict(at)


def _values(schema: dict[str, Any], whole: dict[str, Any]) -> st.SearchStrategy[Any]:
    schema = _solved(schema, whole)
    if "enum" in schema:
        return st.sampled_from(schema["enum"])
    match schema.get("type"):
        case "boolean":
            return st.booleans()
        case "integer":
            return st.integers(int(schema.get("minimum", -1000)), int(schema.get("maximum", 2**31)))
        case "number":
            return st.floats(schema.get("minimum", -1e4), schema.get("maximum", 1e4))
        case "array":
            return st.lists(_values(schema.get("items", {}), whole), max_size=3)
        case "object":
            parts = {name: _values(part, whole) for name, part in schema.get("properties", {}).items()}
            needed = {name: part for name, part in parts.items() if name in schema.get("required", ())}
            return st.fixed_dictionaries(
                needed, optional={name: part for name, part in parts.items() if name not in needed}
            )
    return st.sampled_from(NAMES)


def odd_states(version: str) -> st.SearchStrategy[list[Any]]:
    """What comes, one after the other: seconds before it, and bytes, or changes by path (`ABSENT`: the field is left out)."""
    known = fields(version)
    within = st.sampled_from(sorted(known)).flatmap(lambda path: st.tuples(st.just(path), known[path]))
    beyond = st.tuples(st.sampled_from(sorted(known)), JUNK | st.just(ABSENT))
    changes = st.lists(within | beyond, min_size=1, max_size=4)
    gaps_s = st.sampled_from([0.0, 0.1, 1.0, 1.0, 4.0, 12.0])
    return st.lists(st.tuples(gaps_s, changes | RAW), min_size=30, max_size=60)


def changed(state: dict[str, Any], changes: Any, number: int) -> bytes:
    """An honest state with some fields changed, and as a rule with the next number."""
    if isinstance(changes, bytes):
        return changes if changes != TOO_LARGE else b" " * LARGE_BYTES
    said = json.loads(json.dumps(state)) | {"headerId": number}
    for path, value in changes:
        part = said
        for name in path[:-1]:
            part = part[name] if isinstance(part.get(name), dict) else part.setdefault(f"{name}.", {})
        if value is ABSENT:
            part.pop(path[-1], None)
        else:
            part[path[-1]] = value
    return json.dumps(said).encode()

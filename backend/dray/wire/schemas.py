"""JSON Schemas (draft 2020-12) of everything on the wire."""

from __future__ import annotations

from typing import Any, get_args

import msgspec

from dray.codec import Context
from dray.messages import WIRE_VERSION, AnyMessage, Message
from dray.messages.base import Id

Schema = dict[str, Any]

MESSAGES: tuple[type[Message], ...] = get_args(AnyMessage)

DRAFT = "https://json-schema.org/draft/2020-12/schema"


def parts(reference: str) -> dict[str, Schema]:
    """The schemas of all messages and of their parts, by name.

    Args:
        reference: the form of references between them, with `{name}`.
    """
    _, found = msgspec.json.schema_components(MESSAGES, ref_template=reference)
    return dict(sorted(found.items()))


def envelope(message: Schema) -> Schema:
    """The schema of a whole message on the wire, with its envelope."""
    (sender, context), _ = msgspec.json.schema_components([Id, Context])
    return {
        "type": "object",
        "properties": {
            "v": {"const": WIRE_VERSION, "description": "The wire version."},
            "from": {**sender, "description": "The id of the agent that says it."},
            "m": message,
            "t": context,
        },
        "required": ["v", "from", "m"],
    }


def message_schema(kind: type[Message]) -> Schema:
    """One message's self-contained schema."""
    inner = msgspec.json.schema(kind)
    definitions = inner.pop("$defs")
    return {
        "$schema": DRAFT,
        "title": kind.__name__,
        **envelope(inner),
        "$defs": definitions,
    }

"""The files of `docs/wire`."""

from __future__ import annotations

import json
from typing import Any

from dray.messages import WIRE_VERSION
from dray.wire import asyncapi
from dray.wire.schemas import MESSAGES, Schema, message_schema, parts

RELEASED = f"released-v{WIRE_VERSION}.json"
"""The file with the parts of all messages as of the last release."""

_REFERENCE = "#/{name}"


def documents() -> dict[str, str]:
    """The current documents, by path in the folder; the same code always gives the same bytes."""
    schemas = {f"schemas/{kind.__name__}.json": _text(message_schema(kind)) for kind in MESSAGES}
    return {"asyncapi.json": _text(asyncapi.document()), **schemas}


def released() -> str:
    """The reference for the next version, once this one is released."""
    return _text(current())


def current() -> dict[str, Schema]:
    """The parts of all messages as the code has them."""
    return parts(_REFERENCE)


def _text(content: Any) -> str:
    return json.dumps(content, indent=2, ensure_ascii=False) + "\n"

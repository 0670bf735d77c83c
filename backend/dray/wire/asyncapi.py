"""The AsyncAPI 3 document of the bus."""

from __future__ import annotations

import re
from typing import Any

from dray.messages import WIRE_VERSION, Message
from dray.wire.channels import CHANNELS, Channel
from dray.wire.schemas import MESSAGES, envelope, parts

ABOUT = """\
What the agents of a Dray plant say to one another, on Zenoh. Generated from the code by `dray wire write`.

A message is UTF-8 JSON. Beside it, as Zenoh's attachment, stands its stamp: a MessagePack array of the sender's
life (its incarnation; 0 of a program that keeps no journal), the number of the message in that life on that key, from
1, and its seal (bytes; empty on a bus without certificates).

With certificates a seal is a MessagePack array: the sender's certificate (DER), unix time, and an ECDSA signature over
the key, the life, the number, the time and the message. What is said on `addressed` is encrypted instead
(AES-256-GCM); its seal holds the certificate, the sender, the time and the nonce. See docs/operating.md."""

_PARAMETERS = {
    "plant": "The plant's id.",
    "agent": "An agent's id.",
    "atv": "A vehicle's id.",
    "machine": "A machine's id.",
    "station": "The id of a storage.",
    "strategist": "The id of a strategist.",
    "operator": "The name of an operator's duty.",
    "caller": "The id of the agent that calls.",
    "cell": "A cell of the grid.",
    "place": "The id of a machine, a storage or a warehouse.",
    "product": "A product's id.",
    "district": "The name of a district: the places around a machine.",
    "dwell_point": "The id of a charger or parking place.",
}


def document() -> dict[str, Any]:
    """The whole document."""
    return {
        "asyncapi": "3.0.0",
        "info": {"title": "Dray", "version": f"{WIRE_VERSION}.0.0", "description": ABOUT},
        "defaultContentType": "application/json",
        "channels": {channel.name: _channel(channel) for channel in CHANNELS},
        "operations": {
            f"{channel.name}.{kind.__name__}": _operation(channel, kind)
            for channel in CHANNELS
            for kind in channel.messages
        },
        "components": {
            "messages": {kind.__name__: _message(kind) for kind in MESSAGES},
            "schemas": parts("#/components/schemas/{name}"),
        },
    }


def _channel(channel: Channel) -> dict[str, Any]:
    return {
        "address": channel.address,
        "description": channel.about,
        "parameters": {
            name: {"description": _PARAMETERS[name]} for name in re.findall(r"{(\w+)}", channel.address)
        },
        "messages": {
            kind.__name__: {"$ref": f"#/components/messages/{kind.__name__}"} for kind in channel.messages
        },
    }


def _operation(channel: Channel, kind: type[Message]) -> dict[str, Any]:
    speakers = " or ".join(sorted(kind.said_by))
    return {
        "action": "send",
        "channel": {"$ref": f"#/channels/{channel.name}"},
        "messages": [{"$ref": f"#/channels/{channel.name}/messages/{kind.__name__}"}],
        "summary": f"Said by {speakers}.",
        "x-speakers": sorted(kind.said_by),
    }


def _message(kind: type[Message]) -> dict[str, Any]:
    about = (kind.__doc__ or "").partition("\n")[0]
    return {
        "name": kind.__name__,
        "summary": about,
        "payload": envelope({"$ref": f"#/components/schemas/{kind.__name__}"}),
    }

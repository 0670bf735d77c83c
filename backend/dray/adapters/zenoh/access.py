"""Zenoh's access control: the messages that a wired process refuses on links with vehicles, from any sender.

A link's certificate identifies the neighbour, not the sender: neighbours relay messages. So a link can be denied only the messages
that its neighbour never needs to relay. As long as any path may bypass any other, there are none. With `DRAY_BUS_APART` wired
processes never reach one another over vehicles. Then nothing of theirs is accepted on a link with a vehicle: neither their
messages, nor their presence, nor their subscriptions to their own letters.

This adds to seals and letters, and replaces neither: it stops at the first link the messages that those only detect. It does
not stop what is said, or a token, on a pattern that matches such keys: the bus refuses those.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from dray.messages.keys import Keys

VEHICLES = "vehicles"
"""The only subject. With several subjects for a link, Zenoh 1.10 accepts a message that one of them is not denied."""


@dataclass(frozen=True, slots=True)
class Apart:
    """The two sorts of processes of a plant.

    Attributes:
        plant: the plant's id.
        vehicles: common names of the vehicles' certificates.
        wired: names of agents that are never reached over vehicles.
    """

    plant: str
    vehicles: tuple[str, ...]
    wired: tuple[str, ...]

    def config(self) -> dict[str, Any]:
        """`access_control` in Zenoh's configuration, for a wired process."""
        keys = Keys(self.plant)
        words = [
            keys.machine_heartbeat("*"),
            keys.station_heartbeat("*"),
            keys.transports("*"),
            keys.goals("*"),
            keys.shut_out,
            keys.closures,
            keys.floor("*"),
            *(keys.events(agent) for agent in self.wired),
        ]
        rules = {
            "words": ("put", words),
            # All patterns of their letters, also those of spares. No wildcard matches the name.
            "ears": ("declare_subscriber", [f"**/@{agent}/**" for agent in self.wired]),
            "tokens": ("liveliness_token", [f"{keys.alive}/{agent}/**" for agent in self.wired]),
        }
        return {
            "enabled": True,
            "default_permission": "allow",
            "rules": [
                {
                    "id": name,
                    "permission": "deny",
                    "flows": ["ingress"],
                    "messages": [message],
                    "key_exprs": denied,
                }
                for name, (message, denied) in rules.items()
            ],
            "subjects": [{"id": VEHICLES, "cert_common_names": list(self.vehicles)}],
            "policies": [{"rules": list(rules), "subjects": [VEHICLES]}],
        }

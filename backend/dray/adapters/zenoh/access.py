"""Zenoh's access control: what a wired process takes from no link with a vehicle, whoever may have said it.

A link's certificate tells who the neighbour is, and not who has spoken: neighbours pass on what others say. So a link can
be denied no more than what its neighbour has no business to pass on. That is nothing as long as any way may be gone
round by any other. Where wired processes never reach one another over vehicles (a plant says so: `DRAY_BUS_APART`),
nothing that is theirs comes in over a link with a vehicle: neither their words, nor that they are there, nor that they
listen to what is said to them alone.

This comes on top of seals and letters, and takes the place of neither: it ends at the first link what the others
only see through.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from dray.messages.keys import Keys

VEHICLES = "vehicles"
"""The only subject. Zenoh 1.10 takes a message that one of several subjects of a link is not denied."""


@dataclass(frozen=True, slots=True)
class Apart:
    """The two sorts of processes of a plant.

    Attributes:
        plant: the plant's id.
        vehicles: common names of the vehicles' certificates.
        wired: names of agents that are reached over no vehicle.
    """

    plant: str
    vehicles: tuple[str, ...]
    wired: tuple[str, ...]

    def config(self) -> dict[str, Any]:
        """`access_control` in Zenoh's words, for a wired process."""
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
            "ears": ("declare_subscriber", [keys.addressed(agent) for agent in self.wired]),
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

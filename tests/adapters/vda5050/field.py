"""What vehicles of the field say otherwise than the simulated one: each state is changed before the driver hears it."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from vda_rig import Rig

Change = Callable[[dict[str, Any]], None]


def reword(rig: Rig, change: Change) -> None:
    """From now on every state passes `change` before the driver hears it."""
    give = rig.give

    def tell(topic: str, data: bytes) -> None:
        if topic == "state":
            said = json.loads(data)
            change(said)
            data = json.dumps(said).encode()
        give(topic, data)

    rig.give = tell  # type: ignore[method-assign]


def say(rig: Rig, for_s: float = 0.2) -> None:
    """The vehicle says how it is, and the driver hears it."""
    rig.vehicle.say_state()
    rig.run(for_s)

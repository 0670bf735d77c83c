"""Whether a vehicle may obey: it asks the grant of a command itself, whoever has passed the command on.

The gateway refuses what a person may not do, too. But it is one peer among others on the bus, and a rule
about who may stop a vehicle must hold for whatever reaches that vehicle.
"""

from __future__ import annotations

from dray.messages import Grant, VehicleCommand, signed_words
from dray.plant import Plant
from dray.protocol.runtime.trust import Trusts


class CommandAuthorisation:
    """Whom one vehicle obeys, and where.

    Args:
        atv: its id.
        plant: where the areas are.
        trusts: whose signatures count.
    """

    def __init__(self, atv: str, plant: Plant, trusts: Trusts) -> None:
        self._atv, self._plant, self._trusts = atv, plant, trusts

    def knows(self, command: VehicleCommand, grant: Grant) -> bool:
        """Whether somebody who is trusted has granted this command, whenever that was."""
        return self._trusts(signed_words(self._atv, command, grant), grant.signature)

    def covers(self, command: VehicleCommand, grant: Grant, x_m: float, y_m: float) -> bool:
        """Whether a grant reaches the place where the vehicle is."""
        if grant.everywhere:
            return True
        here = self._plant.areas_near(x_m, y_m, command.kind.margin_m)
        return not set(here).isdisjoint(grant.areas)

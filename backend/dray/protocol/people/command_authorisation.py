"""Whether a vehicle or a machine may obey: it asks the grant of a command itself, whoever has passed the command on.

The gateway refuses what a person may not do, too. But it is one peer among others on the bus, and a rule
about who may stop a vehicle must hold for whatever reaches that vehicle.
"""

from __future__ import annotations

from dray.messages import CommandKind, Grant, MachineCommand, VehicleCommand, signed_words
from dray.plant import Plant
from dray.protocol.runtime.trust import Trusts


class CommandAuthorisation:
    """Whom one agent obeys, and where.

    Args:
        agent: its id.
        plant: where the areas are.
        trusts: whose signatures count.
    """

    def __init__(self, agent: str, plant: Plant, trusts: Trusts) -> None:
        self._agent, self._plant, self._trusts = agent, plant, trusts

    def knows(self, command: VehicleCommand | MachineCommand, grant: Grant) -> bool:
        """Whether somebody who is trusted has granted this command, whenever that was."""
        return self._trusts(signed_words(self._agent, command, grant), grant.signature)

    def covers(self, command: VehicleCommand | MachineCommand, grant: Grant, x_m: float, y_m: float) -> bool:
        """Whether a grant reaches the place where the agent is."""
        if grant.everywhere:
            return True
        margin_m = command.kind.margin_m if isinstance(command.kind, CommandKind) else 0.0
        here = self._plant.areas_near(x_m, y_m, margin_m)
        return not set(here).isdisjoint(grant.areas)

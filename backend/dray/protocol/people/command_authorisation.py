"""Whether a vehicle or a machine may obey: it checks a command's grant itself, whichever agent has passed it on.

The gateway refuses forbidden commands too. But it is one peer among others on the bus. A rule about who may stop a
vehicle must hold for every message to it.
"""

from __future__ import annotations

from dray.messages import CommandKind, Grant, MachineCommand, VehicleCommand, signed_words
from dray.plant import Plant
from dray.protocol.runtime.trust import Trusts


class CommandAuthorisation:
    """The authorisation of commands to one agent.

    Args:
        agent: its id.
        plant: its areas.
        trusts: the trusted signers.
    """

    def __init__(self, agent: str, plant: Plant, trusts: Trusts) -> None:
        self._agent, self._plant, self._trusts = agent, plant, trusts

    def knows(self, command: VehicleCommand | MachineCommand, grant: Grant) -> bool:
        """Whether a trusted signer has granted this command, at any time."""
        return self._trusts(signed_words(self._agent, command, grant), grant.signature)

    def covers(self, command: VehicleCommand | MachineCommand, grant: Grant, x_m: float, y_m: float) -> bool:
        """Whether a grant covers the agent's place."""
        if grant.everywhere:
            return True
        margin_m = command.kind.margin_m if isinstance(command.kind, CommandKind) else 0.0
        here = self._plant.areas_near(x_m, y_m, margin_m)
        return not set(here).isdisjoint(grant.areas)

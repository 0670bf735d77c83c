"""Decides whether a person's report that a vehicle was carried away is accepted, for all agents that act on it.

It is refused while the vehicle is heard, or may be sending over a bad link. It is also refused once the vehicle was heard after the
report: then it is still there, or back.
"""

from __future__ import annotations

from dray.messages.floor.removal import Removal, removed_words
from dray.plant import Plant
from dray.protocol.liveness.suspicion import IDLE_INTERVAL_S, gone_s
from dray.protocol.runtime.trust import Trusts
from dray.protocol.traffic.neighbours import Neighbours

NOT_TRUSTED = "a removal without a trusted grant"
EXPIRED = "a removal whose grant has expired"
IS_HEARD = "a removal of a vehicle that is heard"
NO_PLACE = "a return of a vehicle to where there is no place"
NOT_THERE = "a removal whose grant does not cover where the vehicle was, or returns to"
TOO_EARLY = "a removal before the vehicle was silent for long enough"

LISTEN_S = gone_s(IDLE_INTERVAL_S)
"""Time of listening within which every living vehicle is heard."""


class RemovalAuthorisation:
    """The check of removals for one agent.

    Args:
        plant: positions of nodes and areas.
        trusts: the people whose signatures count.
        neighbours: when vehicles were heard.
    """

    def __init__(self, plant: Plant, trusts: Trusts, neighbours: Neighbours) -> None:
        self._plant, self._trusts, self._neighbours = plant, trusts, neighbours

    def objection(self, removal: Removal, since_s: float, now_s: float) -> str:
        """Why a removal is refused; empty when it is accepted.

        Args:
            removal: the person's report.
            since_s: since when this agent listens to the vehicle.
            now_s: the present time.
        """
        if not self._trusts(removed_words(removal), removal.grant.signature):
            return NOT_TRUSTED
        if now_s > removal.grant.valid_until_s:
            return EXPIRED
        if removal.node and removal.node not in self._plant.nodes:
            return NO_PLACE
        last = self._neighbours.last(removal.atv)
        if last is None:
            return TOO_EARLY if now_s - since_s <= LISTEN_S else ""
        if last.said > (removal.life, removal.seq) or now_s - last.at_s <= gone_s(last.every_s):
            return IS_HEARD
        return ""

    def covers(self, removal: Removal, nodes: tuple[str, ...]) -> bool:
        """Whether a removal's grant covers one of the vehicle's possible nodes, and the node where it is being put back, if any."""
        grant = removal.grant
        if grant.everywhere:
            return True
        return any(self._reaches(removal, node) for node in nodes) and (
            not removal.node or self._reaches(removal, removal.node)
        )

    def _reaches(self, removal: Removal, node: str) -> bool:
        spot = self._plant.nodes[node]
        return not set(self._plant.areas_at(spot.x_m, spot.y_m)).isdisjoint(removal.grant.areas)

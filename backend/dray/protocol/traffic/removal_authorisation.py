"""Decides whether a person's report that a vehicle was carried away is accepted, for all agents that act on it.

It is refused while the vehicle is heard, or may be sending over a bad link. It is also refused once the vehicle was heard after the
report: then it is still there, or back.

A heartbeat counts as heard after the report when it is later than the one that the report names. But its signer may have been cut off
from the vehicle, and name an old one. So a later heartbeat that came here before the report was made does not count. Each agent
judges that by what it has heard itself, and believes no other agent's word about the vehicle.
"""

from __future__ import annotations

from msgspec import UNSET

from dray.messages.base import CLOCKS_AGREE_S
from dray.messages.floor.removal import Removal, removed_words, reported_words
from dray.plant import Plant
from dray.protocol.liveness.suspicion import IDLE_INTERVAL_S, LATENESS_MAX_S, gone_s
from dray.protocol.runtime.trust import Trusts
from dray.protocol.traffic.neighbours import Neighbours, Seen

NOT_TRUSTED = "a removal without a trusted grant"
EXPIRED = "a removal whose grant has expired"
HEARD_SINCE = "a removal of a vehicle that was heard after it was reported"
IS_HEARD = "a removal of a vehicle that is heard"
NO_PLACE = "a return of a vehicle to where there is no place"
NOT_THERE = "a removal whose grant does not cover where the vehicle was, or returns to"
TOO_EARLY = "a removal before the vehicle was silent for long enough"

LISTEN_S = gone_s(IDLE_INTERVAL_S)
"""Time of listening within which every living vehicle is heard."""

BEFORE_S = CLOCKS_AGREE_S + LATENESS_MAX_S
"""Shortest time from a vehicle's newest word to the report, by which that word certainly came first. The report's time is by another
clock; and if the clock here is behind, the delay of the report counts as well (`_came_before`)."""


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
        if now_s - last.at_s <= gone_s(last.every_s):
            return IS_HEARD
        if last.said > (removal.life, removal.seq) and not self._came_before(last, removal, now_s):
            return HEARD_SINCE
        return ""

    def _came_before(self, last: Seen, removal: Removal, now_s: float) -> bool:
        """Whether the vehicle's newest word came here before the person made the report.

        If this clock is behind the signer's, the report counts as that much earlier: otherwise a word that came after it would seem to
        have come before. If it is ahead, the report's time is earlier than it was by this clock, which is safe.
        """
        reported = removal.reported
        if reported is UNSET:
            return False
        if not self._trusts(reported_words(removal, reported), reported.signature):
            return False
        behind_s = max(reported.signed_s - now_s, 0.0)
        # The signer's clock may have been set back since the report was made: it was not made after it was signed.
        made_s = min(reported.at_s, reported.signed_s) - behind_s
        return last.at_s + BEFORE_S <= made_s

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

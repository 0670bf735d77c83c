"""A vehicle's membership in the reserve of a fleet that is too large for its floor (`dray.plant.spare_places`).

    AT WORK   --stands at a place of the reserve-->  RESERVE
    RESERVE   --takes work, or has stood at one other place for STAYS_S-->  AT WORK

A vehicle often leaves a place of the reserve without work: another one needs room, or it must charge. If that ended
its membership, it would take the next transport on its way, and all would be at work at once on a full floor.

A floor where vehicles wait in the way of others (`SparePlaces.others`) is different: a vehicle that has left its place
may find no other one, and would drive about without work. There it is at work as soon as it leaves.

Membership is not in the journal: after a restart a vehicle is a member if it stands at a place of the reserve.
"""

from __future__ import annotations

from dray.plant import Plant

STAYS_S = 300.0
"""Time at another place after which a vehicle is at work again (s): most ways to a place are shorter, so it has found
one, and one that nobody has asked it to leave."""


class Reserve:
    """One vehicle's membership in the reserve.

    Args:
        plant: the places of the reserve.
    """

    def __init__(self, plant: Plant) -> None:
        self._plant = plant
        self._is_member = False
        self._ends_s = float("inf")
        """End of its membership if it goes on standing where it stands."""

    def has(self, node: str) -> bool:
        """Whether a node is a place of the reserve."""
        return self._plant.spare_places.is_reserve(node)

    def is_member(self, now_s: float) -> bool:
        """Whether the vehicle belongs to the reserve."""
        return self._is_member and now_s < self._ends_s

    def stand(self, node: str, now_s: float) -> None:
        """The vehicle has come to rest at a dwell point or spare place."""
        if self.has(node):
            self._is_member, self._ends_s = True, float("inf")
        elif self._is_member:
            self._ends_s = now_s + STAYS_S if self._has_place_for_all else now_s

    def leave(self, now_s: float) -> None:
        """The vehicle leaves its place without work, and stays a member if all vehicles have a place out of the way."""
        self._is_member, self._ends_s = self.is_member(now_s) and self._has_place_for_all, float("inf")

    @property
    def _has_place_for_all(self) -> bool:
        return not self._plant.spare_places.others

    def take_work(self) -> None:
        """The vehicle has work: its membership ends."""
        self._is_member = False

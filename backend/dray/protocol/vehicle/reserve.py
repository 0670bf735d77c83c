"""A vehicle's membership in the reserve of a fleet that is too large for its floor (`dray.plant.spare_places`).

    AT WORK   --stands at a place of the reserve-->  RESERVE
    RESERVE   --takes work, has stood at one other place for STAYS_S, or finds no place on a floor with too few-->  AT WORK

A vehicle often leaves a place of the reserve without work: another one needs room, or it must charge. If that ended
its membership, it would take the next transport on its way, and all would be at work at once on a full floor.

On a floor where vehicles wait in the way of others (`SparePlaces.others`) a vehicle that has left its place may find no
other one, and would drive about without work. There its membership ends when it finds none. If vehicles without work
do not fill the reserve first there (`SparePlaces.filled`), it ends as soon as the vehicle leaves its place.

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
            self._ends_s = now_s + STAYS_S if self._outlasts_its_place else now_s

    def leave(self, now_s: float) -> None:
        """The vehicle leaves its place without work, and may stay a member."""
        self._is_member, self._ends_s = self.is_member(now_s) and self._outlasts_its_place, float("inf")

    @property
    def _outlasts_its_place(self) -> bool:
        """Whether membership goes on after the vehicle has left its place."""
        spare = self._plant.spare_places
        return bool(spare.filled) or not spare.others

    def lack_place(self) -> None:
        """The vehicle has found no place to wait: its membership ends if the fleet has too few."""
        if self._plant.spare_places.others:
            self._is_member = False

    def take_work(self) -> None:
        """The vehicle has work: its membership ends."""
        self._is_member = False

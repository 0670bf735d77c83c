"""A vehicle's membership in the reserve of a fleet that is too large for its floor (`dray.plant.spare_places`).

    AT WORK   --stands at a place of the reserve-->  RESERVE
    RESERVE   --takes work, or has stood at one other place for STAYS_S-->  AT WORK
    AT WORK   --ends a transport that was slow on the roads-->  RESERVE, for its pause

A vehicle often leaves a place of the reserve without work: another one needs room, or it must charge. If that ended
its membership, it would take the next transport on its way, and all would be at work at once on a full floor.

A floor where vehicles wait in the way of others (`SparePlaces.others`) is different: a vehicle that has left its place
may find no other one, and would drive about without work. There it is at work as soon as it leaves.

The pause bounds how many vehicles are at work where roads are full, as a sender on a full line backs off: each slow
transport doubles it, each other one halves it. It depends on the vehicle's own ways alone, so nobody counts vehicles.

Membership is not in the journal: after a restart a vehicle is a member if it stands at a place of the reserve.
"""

from __future__ import annotations

from dray.plant import Plant

SLOW_FRAC = 0.6
"""Pace below which a transport was slow: the time of its ways on an empty floor, as a part of the time that they took. The
flow on a road is greatest at half of the free pace (Greenshields 1935)."""

PAUSE_S, PAUSE_MAX_S = 120.0, 900.0
"""First and longest pause (s)."""

ABLE_MIN = 4
"""Vehicles that can carry all that a pausing one can: a smaller fleet never pauses."""

STAYS_S = 300.0
"""Time at another place after which a vehicle is at work again (s): most ways to a place are shorter, so it has found
one, and one that nobody has asked it to leave."""


class Reserve:
    """One vehicle's membership in the reserve.

    Args:
        plant: the places of the reserve, and the other vehicles.
        vehicle_type: id of the vehicle's type.
    """

    def __init__(self, plant: Plant, vehicle_type: str) -> None:
        self._plant = plant
        own, kinds = set(plant.vehicle_types[vehicle_type].abilities), plant.vehicle_types
        able = sum(own <= set(kinds[spec.type].abilities) for spec in plant.fleet.values())
        self._may_pause = able >= ABLE_MIN
        self._pause_s = 0.0
        """Length of the newest pause."""
        self._pauses_until_s = float("-inf")
        self._is_member = False
        self._ends_s = float("inf")
        """End of its membership if it goes on standing where it stands."""

    def has(self, node: str) -> bool:
        """Whether a node is a place of the reserve."""
        return self._plant.spare_places.is_reserve(node)

    def is_member(self, now_s: float) -> bool:
        """Whether the vehicle belongs to the reserve."""
        return now_s < self._pauses_until_s or (self._is_member and now_s < self._ends_s)

    def end_work(self, pace_frac: float | None, now_s: float) -> None:
        """A transport is over: pause if it was slow.

        Args:
            pace_frac: the time of its ways on an empty floor, as a part of the time that they took; None if unknown.
            now_s: the present time.
        """
        if pace_frac is None or not self._may_pause:
            return
        if pace_frac < SLOW_FRAC:
            self._pause_s = min(max(2.0 * self._pause_s, PAUSE_S), PAUSE_MAX_S)
        else:
            self._pause_s = self._pause_s / 2.0 if self._pause_s >= 2.0 * PAUSE_S else 0.0
        self._pauses_until_s = now_s + self._pause_s

    def stand(self, node: str, now_s: float) -> None:
        """The vehicle has come to rest at a dwell point or spare place."""
        if self.has(node):
            self._is_member, self._ends_s = True, float("inf")
        elif self._is_member:
            self._ends_s = now_s + STAYS_S if self._has_place_for_all else now_s

    def leave(self, now_s: float) -> None:
        """The vehicle leaves its place without work, and stays a member if all vehicles have a place out of the way."""
        is_member = self._is_member and now_s < self._ends_s
        self._is_member, self._ends_s = is_member and self._has_place_for_all, float("inf")

    @property
    def _has_place_for_all(self) -> bool:
        return not self._plant.spare_places.others

    def take_work(self) -> None:
        """The vehicle has work: its membership ends."""
        self._is_member = False
        self._pauses_until_s = float("-inf")

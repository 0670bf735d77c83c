"""A carrier's moves for its transport: ways between places, picks and drops; `transport_job` decides when."""

from __future__ import annotations

from collections.abc import Iterable

from dray.body import Drop, Pick
from dray.errors import NoWay
from dray.memory import Contract
from dray.messages import THING
from dray.plant import Plant, Routes
from dray.protocol.contract_net.dock import dock_of
from dray.protocol.runtime.life import Life
from dray.protocol.vehicle.drivers.driver import Driver, limited_s

RETRY = "retry"
"""Alarm of a repeated way or manoeuvre, which is no message."""

RETRY_S = 5.0
"""Delay after a failed manoeuvre (s)."""


class JobMoves:
    """The moves of one transport.

    Args:
        contract: the load and its source.
        plant, vehicle_type: for ways and handling times.
        driver: the vehicle's place on the lanes.
        life: the agent's life; alarms are named `RETRY`.
    """

    def __init__(
        self, contract: Contract, plant: Plant, vehicle_type: str, driver: Driver, life: Life
    ) -> None:
        self._work = contract.work
        self._source = contract.source
        self._plant = plant
        self._type = plant.vehicle_types[vehicle_type]
        self._driver = driver
        self._life = life
        self._order = 0
        """The number of the newest pick or drop."""
        self._full: set[str] = set()
        """Stations that did not take the load back; membership tests only."""

    # --- ways ---

    def drive(self, place: str, now_s: float) -> float | None:
        """Set off for a place's dock.

        Returns:
            Expected arrival; None if the vehicle stands there already.

        Raises:
            NoWay: closures leave no way.
        """
        return self._driver.arrives_s if self._driver.go(self._dock(place), now_s) else None

    def stands_at(self, place: str) -> bool:
        """Whether the vehicle has passed no other node since it came to a place's dock."""
        return self._driver.node == self._dock(place)

    def is_shut_out_of(self, place: str) -> bool:
        """Whether known obstacles block every way to a place."""
        obstructed = bool(self._plant.obstructed)
        return obstructed and not self._routes.leads_round(self._driver.next_node, self._dock(place))

    def can_fetch_elsewhere(self) -> bool:
        """Whether obstacles block every way to the source, but not to another source and on to the destination."""
        there = self._dock(self._work.destination)
        return self.is_shut_out_of(self._source) and any(
            not self.is_shut_out_of(other) and self._routes.leads_round(self._dock(other), there)
            for other in self._keepers
            if other != self._source
        )

    def is_shut_in(self, now_s: float) -> bool:
        """Whether others may fetch the load that this vehicle cannot: something is known to lie on every way from here, and on none from the destination."""
        until_s = self._work.vehicle_until_s
        may_others = not self._work.vehicle or (until_s is not None and until_s <= now_s)
        if not may_others or not self.is_shut_out_of(self._source):
            return False
        return self._routes.leads_round(self._dock(self._work.destination), self._dock(self._source))

    @property
    def _keepers(self) -> tuple[str, ...]:
        """Places that may have the load; a contract that was passed on names only one."""
        plant, item = self._plant, self._work.item
        is_kept = self._source in plant.stores and item in plant.materials
        return (*self._work.sources, *(plant.storages_of(item) if is_kept else ()))

    def halt(self, now_s: float) -> None:
        """Stop at the end of the present lane, or outside of closures."""
        self._driver.halt(now_s)

    def try_later(self, now_s: float) -> None:
        """A way or a manoeuvre has failed: try again after `RETRY_S`."""
        self._life.alarm(RETRY, now_s + RETRY_S)

    def try_no_more(self) -> None:
        """Cancel the repetition."""
        self._life.cancel(RETRY)

    # --- durations ---

    def from_source_s(self) -> float:
        """The duration of loading, the way to the destination and unloading (s).

        Raises:
            NoWay: closures leave no way.
        """
        loaded_s = self._routes.duration_s(self._dock(self._source), self._dock(self._work.destination))
        return self._type.load_s + limited_s(loaded_s, self._driver.pace_frac) + self._type.unload_s

    def loading_s(self) -> float:
        """The duration of loading (s)."""
        return self._type.load_s

    def unloading_s(self) -> float:
        """The duration of unloading (s)."""
        return self._type.unload_s

    # --- reports to others ---

    def expect_to_load(self, comes_s: float, *, docked: bool = False) -> None:
        """Publish the arrival time at the source (plant clock), or that the vehicle stands there."""
        self._driver.expect_at(self._source, comes_s, self._type.load_s, docked=docked)

    def expect_to_unload(self, comes_s: float, *, docked: bool = False) -> None:
        """Publish the arrival time at the destination, or that the vehicle stands there."""
        self._driver.expect_at(self._work.destination, comes_s, self._type.unload_s, docked=docked)

    def leave(self, place: str, now_s: float) -> None:
        """Publish that the vehicle is done at a place."""
        self._driver.expect_at(place, now_s, 0.0)

    # --- manoeuvres ---

    def pick(self) -> None:
        """Load at the source."""
        self._order = self._driver.next_order()
        self._driver.act(
            Pick(
                order=self._order,
                station=self._source,
                item=self._work.item,
                quantity=self._work.quantity,
            )
        )

    def drop(self, place: str, goal: str) -> None:
        """Unload at a place.

        Args:
            place: the place where the vehicle stands.
            goal: the load's goal; empty if the load is only set aside.
        """
        self._order = self._driver.next_order()
        self._driver.act(Drop(order=self._order, station=place, goal=goal))

    def is_newest(self, order: int) -> bool:
        """Whether this is the number of the newest pick or drop."""
        return order == self._order

    @property
    def is_gated(self) -> bool:
        """Whether a gate decides about the load instead of the coordinator."""
        return self._work.destination in self._plant.delivery_warehouses

    # --- refuges ---

    def refuge(self) -> str:
        """The nearest storage for a load without a receiver; goods go to the delivery warehouse, things to their storage.

        Full storages may stay full, because this vehicle blocks those that would empty them. Then material goes to
        a source warehouse. A thing from elsewhere goes to the nearest storage. If closures leave no way, the
        vehicle waits for the first.
        """
        is_material = self._work.item in self._plant.materials
        storages = self._plant.storages_of(self._work.item) if is_material else (self._work.destination,)
        if self._work.item == THING:
            fetched = self._source in self._plant.stores
            storages = (self._source,) if fetched else (*self._plant.stores,) or (self._work.destination,)
        here = self._driver.next_node
        for refuges in (storages, self._plant.source_warehouses if is_material else ()):
            try:
                return self._routes.nearest(here, self._not_full(refuges))[0]
            except NoWay:
                continue
        self._full.clear()
        try:
            return self._routes.nearest(here, storages)[0]
        except NoWay:
            return storages[0]

    def has_station(self, place: str) -> bool:
        """Whether an agent owns the dock of a refuge; a delivery warehouse has a gate instead."""
        return place in self._plant.stores

    def note_full(self, place: str) -> None:
        """Note that a place did not take the load."""
        self._full.add(place)

    def _not_full(self, places: Iterable[str]) -> tuple[str, ...]:
        return tuple(place for place in places if place not in self._full)

    @property
    def _routes(self) -> Routes:
        return self._plant.routes(self._type.id)

    def _dock(self, place: str) -> str:
        return dock_of(self._plant, self._work, place)

"""A vehicle's handlers of right-of-way messages and alarms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from dray.messages import (
    FloorReported,
    HoldsAsked,
    Message,
    PlaceConfirmed,
    PlaceGranted,
    YieldAsked,
    YieldRefused,
)
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.runtime.life import Change, Life
from dray.protocol.traffic.driving.place_requests import REQUEST_AGAIN
from dray.protocol.traffic.driving.right_of_way import HELD_UP, LOOK, RESTED, Errand, RightOfWay
from dray.protocol.vehicle.drivers.driver import Driver
from dray.protocol.vehicle.drivers.reserved_driver import LOST, ReservedDriver

Handler = Callable[[str, Any, float], None]

NO_NEWS = "a report about a district that is not its leader's, or not new"


BELIEVED_BY = 2
"""Replicas of reservation tables that must agree: one alone may lie."""


@dataclass(frozen=True, slots=True)
class Arrived(Change):
    """The vehicle has arrived."""


@dataclass(frozen=True, slots=True)
class RoomMade(Change):
    """The vehicle leaves its place for another vehicle."""


@dataclass(frozen=True, slots=True)
class HoldsDenied(Change):
    """The vehicle drives, but was reported as carried away: it does not hold the places that it drives on."""


@dataclass(frozen=True, slots=True)
class Doubled(Change):
    """Another agent uses the vehicle's id."""


@dataclass(frozen=True, slots=True)
class Alone(Change):
    """Others drive with right of way, and the vehicle drives without."""


class AloneAmongOthers:
    """Detects right of way in use by others: replicas ask this vehicle for its holds, or report their districts.

    Args:
        plant: its machines and storages, which may keep reservation tables.
    """

    def __init__(self, plant: Plant, life: Life) -> None:
        self._plant = plant
        self._life = life
        self._asked_by: set[str] = set()

    def fill(self, messages: dict[type[Message], Callable[..., None]]) -> None:
        """Enter the handlers into the vehicle's table, and subscribe to the replicas of reservation tables."""
        messages[HoldsAsked] = messages[YieldAsked] = messages[FloorReported] = self._on_asked
        self._life.subscribe(Keys(self._plant.id).all_floors)

    def _on_asked(self, sender: str, _message: Message, _now_s: float) -> None:
        if sender not in self._plant.machines and sender not in self._plant.stores:
            return
        self._asked_by.add(sender)
        if len(self._asked_by) >= BELIEVED_BY:
            self._life.note(Alone())


class TrafficHandling:
    """Right of way as entries in a vehicle's handler tables.

    Args:
        driver: the driver with right of way.
    """

    def __init__(self, driver: ReservedDriver, life: Life) -> None:
        self._driver = driver
        self._life = life

    def fill(
        self, messages: dict[type[Message], Handler], alarms: dict[str, Callable[[Any, float], None]]
    ) -> None:
        """Enter the handlers into the vehicle's tables."""
        messages[FloorReported] = self._on_floor
        messages[PlaceGranted] = self._told(lambda row, *heard: row.on_granted(*heard))
        messages[PlaceConfirmed] = self._told(lambda row, *heard: row.on_confirmed(*heard))
        messages[YieldAsked] = self._told(lambda row, *heard: row.on_yield_asked(*heard))
        messages[YieldRefused] = self._told(lambda row, *heard: row.on_yield_refused(*heard))
        messages[HoldsAsked] = self._told(lambda row, *heard: row.on_holds_asked(*heard))
        alarms[LOOK] = lambda _about, now_s: self._step(lambda row: row.look(now_s), now_s)
        alarms[LOST] = lambda _about, now_s: self._step(lambda _row: self._driver.find_way(now_s), now_s)
        alarms[HELD_UP] = self._held_up
        alarms[RESTED] = lambda _about, now_s: self._step(lambda row: row.go_on(now_s), now_s)
        alarms[REQUEST_AGAIN] = lambda about, now_s: self._step(
            lambda row: row.repeat_request(about, now_s), now_s
        )

    def _held_up(self, _about: Any, now_s: float) -> None:
        self._step(lambda row: row.reroute(now_s), now_s)
        shut = self._driver.right_of_way.shut_out(now_s)
        if shut is not None:
            self._life.note(shut)

    def _on_floor(self, sender: str, told: FloorReported, now_s: float) -> None:
        """Handle a replica's report of its district: by itself it changes a way only if a vehicle is silent."""
        if not self._driver.surroundings.on_floor(sender, told, now_s):
            self._life.ignore(NO_NEWS)
        elif any(vehicle.silent for vehicle in told.vehicles):
            self._step(lambda row: row.on_silence_told(now_s), now_s)

    def _told(self, take: Callable[..., None]) -> Handler:
        return lambda sender, message, now_s: self._step(lambda row: take(row, sender, message, now_s), now_s)

    def _step(self, take: Callable[[RightOfWay], None], now_s: float) -> None:
        """Let right of way take a step; the vehicle has reacted to the consequences when this returns."""
        row = self._driver.right_of_way
        before, removal = row.errand, row.removal
        take(row)
        if row.is_doubled:
            row.is_doubled = False
            self._note(Doubled(), now_s)
            return
        if row.removal != removal:
            self._driver.begin_anew(now_s)
            if row.is_denied:
                self._note(HoldsDenied(), now_s)
            return
        if row.errand is Errand.REFUGE and before is Errand.OWN:
            self._note(RoomMade(), now_s)
        if self._driver.arrive(now_s):
            self._note(Arrived(), now_s)

    def _note(self, change: Change, now_s: float) -> None:
        self._life.note(change)
        self._life.settle(now_s)


def handle_traffic(
    driver: Driver,
    plant: Plant,
    life: Life,
    messages: dict[type[Message], Handler],
    alarms: dict[str, Callable[[Any, float], None]],
) -> None:
    """Enter right-of-way handlers into a vehicle's tables, with or without right of way."""
    if isinstance(driver, ReservedDriver):
        TrafficHandling(driver, life).fill(messages, alarms)
    else:
        AloneAmongOthers(plant, life).fill(messages)

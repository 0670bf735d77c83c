"""Dray's right of way in the lean world: the pure rooms, with a heap for a clock and chance for a network."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from dray.messages import Message
from dray.messages.floor.traffic import (
    FloorReported,
    HoldsAsked,
    PlaceConfirmed,
    PlaceGranted,
    YieldAsked,
    YieldRefused,
)
from dray.messages.keys import Keys
from dray.protocol.runtime.events import Instruct, Publish, Send, Subscribe, Unsubscribe
from dray.protocol.runtime.life import Life
from dray.protocol.runtime.timers import Timers
from dray.protocol.traffic.driving.place_requests import REQUEST_AGAIN
from dray.protocol.traffic.driving.right_of_way import HELD_UP, IDLE, LOOK, RESTED, WITH_TASK, RightOfWay
from dray.protocol.traffic.neighbours import Neighbours
from dray.protocol.traffic.places import Places
from dray.protocol.traffic.reservations.copies import Kept
from dray.protocol.traffic.reservations.district import TABLE_TICK
from dray.protocol.traffic.reservations.districts import Districts
from dray.protocol.traffic.reservations.impostors import Impostors
from dray.protocol.traffic.surroundings import Surroundings
from dray.protocol.traffic.ways import Ways
from dray_sim.bench.traffic.air import Air
from dray_sim.bench.traffic.carrier import Carrier
from dray_sim.bench.traffic.clock import LeanClock

BEAT_S = 1.0

KEYS = Keys("lean")


class Agent:
    """The common part of a machine and a vehicle: alarms, effects, a place on the air."""

    def __init__(self, name: str, clock: LeanClock, air: Air) -> None:
        self.name = name
        self.clock = clock
        self.air = air
        self.life = Life()
        self.off = False
        self._wake_s = float("inf")
        air.receivers[name] = self.receive

    def receive(self, sender: str, message: Message) -> None:
        raise NotImplementedError

    def sound(self, name: object) -> None:
        raise NotImplementedError

    def instruct(self, effect: Instruct) -> None:
        raise NotImplementedError

    def flush(self) -> None:
        """Carry out the effects, and set the next alarm."""
        while self.life.effects:
            effects = list(self.life.effects)
            self.life.effects.clear()
            for effect in effects:
                if isinstance(effect, Send):
                    self.air.send(self.name, effect.to, effect.message)
                elif isinstance(effect, Instruct):
                    self.instruct(effect)
                elif isinstance(effect, Publish):
                    self.air.publish(self.name, effect.key, effect.message)
                elif isinstance(effect, Subscribe):
                    self.air.subscribe(self.name, effect.key)
                elif isinstance(effect, Unsubscribe):
                    self.air.unsubscribe(self.name, effect.key)
        next_s = self.life.timers.next_s
        if next_s < self._wake_s:
            self._wake_s = next_s
            self.clock.call_at(next_s, self._wake, next_s)

    def _wake(self, when_s: float) -> None:
        if when_s != self._wake_s:
            return
        self._wake_s = float("inf")
        if self.off:
            return
        for name in self.life.timers.due(self.clock.now_s):
            self.sound(name)
        self.flush()


class BoxMachine(Agent):
    """A machine, as far as it keeps reservation tables."""

    def __init__(
        self,
        name: str,
        places: Places,
        atvs: tuple[str, ...],
        kept: Mapping[str, Kept],
        neighbours: Neighbours,
        clock: LeanClock,
        air: Air,
    ) -> None:
        super().__init__(name, clock, air)
        self._make: Callable[[Mapping[str, Kept]], Districts] = lambda kept: Districts(
            name, places, atvs, kept, neighbours, Impostors(self.life), KEYS.floor, self.life
        )
        self.tables = self._make(kept)

    def start(self) -> None:
        self.tables.start(self.clock.now_s)
        self.flush()

    def receive(self, sender: str, message: Message) -> None:
        if not self.off:
            self.tables.on_message(sender, message.district, message, self.clock.now_s)  # type: ignore[attr-defined]
            self.flush()

    def sound(self, name: object) -> None:
        if isinstance(name, tuple) and name[0] == TABLE_TICK:
            self.tables.tick(name[1], self.clock.now_s)

    def die(self) -> None:
        self.off = True

    def revive(self, *, forget: bool = False) -> None:
        """Restart, with the persisted state or without."""
        tables = {} if forget else self.tables.districts
        kept = {name: table.copies.kept for name, table in tables.items() if not table.copies.lost}
        self.off = False
        self.life.timers = Timers()
        self._wake_s = float("inf")
        self.life.effects.clear()
        self.tables = self._make(kept)
        self.tables.start(self.clock.now_s)
        self.flush()


class BoxPilot(Agent):
    """A vehicle with right of way."""

    def __init__(
        self,
        carrier: Carrier,
        places: Places,
        ways: Ways,
        neighbours: Neighbours,
        clock: LeanClock,
        air: Air,
    ) -> None:
        super().__init__(carrier.atv, clock, air)
        self.carrier = carrier
        self._neighbours = neighbours
        self.reroutes = True
        """Whether it looks for another way when it is held up."""
        self._order = 0
        self._places, self._ways = places, ways
        self._life = 1
        self._surroundings = Surroundings(carrier.atv, places, KEYS.floor, self.life)
        self.right_of_way = self._make("")
        self.was_cut = False
        """Whether its way was ended where the lane ended."""
        self._asked = True
        self._wanted = ("", False)

    def _make(self, next_node: str) -> RightOfWay:
        return RightOfWay(
            self.carrier.atv,
            self._life,
            self._places,
            self._ways,
            self._surroundings,
            self.life,
            node=self.carrier.travel.node,
            next_node=next_node,
            kind=self.carrier.kind,
            next_order=self._next_order,
        )

    def _next_order(self) -> int:
        self._order += 1
        return self._order

    def start(self, beat_at_s: float) -> None:
        self.right_of_way.start(self.clock.now_s)
        self.flush()
        self.beat()
        self.clock.call_at(beat_at_s, self._beat)

    def beat(self) -> None:
        """Say how it stands, to the machines."""
        hint = self.right_of_way.hint(self.clock.now_s)
        self.air.hint(self.name, lambda: self._neighbours.on_heartbeat(self.name, hint))

    def _beat(self) -> None:
        if not self.off:
            self.beat()
        self.clock.call_at(self.clock.now_s + BEAT_S, self._beat)

    # --- what the carrier asks -------------------------------------------------------------------

    def go(self, node: str, *, idle: bool) -> None:
        self._sense()
        self._asked, self._wanted = False, (node, idle)
        self.right_of_way.go(node, IDLE if idle else WITH_TASK, self.clock.now_s)
        self._done()

    def dock(self) -> None:
        self._sense()
        self.right_of_way.dock(self.clock.now_s)
        self.flush()

    def rest(self) -> None:
        self._sense()
        self.right_of_way.rest(self.clock.now_s)
        self.flush()

    def passed(self, node: str) -> None:
        self._sense()
        self.right_of_way.on_passed(self.clock.now_s)
        self.was_cut = self.was_cut and not self.right_of_way.stands
        self._done()

    # --- what happens ----------------------------------------------------------------------------

    def receive(self, sender: str, message: Message) -> None:
        if self.off:
            return
        now_s = self.clock.now_s
        if isinstance(message, FloorReported):
            self._surroundings.on_floor(sender, message, now_s)
            if not any(vehicle.silent for vehicle in message.vehicles):
                return
        self._sense()
        row = self.right_of_way
        if isinstance(message, PlaceGranted):
            row.on_granted(sender, message, now_s)
        elif isinstance(message, PlaceConfirmed):
            row.on_confirmed(sender, message, now_s)
        elif isinstance(message, YieldAsked):
            row.on_yield_asked(sender, message, now_s)
        elif isinstance(message, YieldRefused):
            row.on_yield_refused(sender, message, now_s)
        elif isinstance(message, HoldsAsked):
            row.on_holds_asked(sender, message, now_s)
        elif isinstance(message, FloorReported):
            row.on_silence_told(now_s)
        self._done()

    def sound(self, name: object) -> None:
        self._sense()
        now_s = self.clock.now_s
        row = self.right_of_way
        if name == LOOK:
            row.look(now_s)
        elif name == HELD_UP:
            if self.reroutes:
                row.reroute(now_s)
        elif name == RESTED:
            row.go_on(now_s)
        elif isinstance(name, tuple) and name[0] == REQUEST_AGAIN:
            row.repeat_request(name[1], now_s)
        self._done()

    def instruct(self, effect: Instruct) -> None:
        self.carrier.instruct(effect.instruction)

    def die(self) -> None:
        """The vehicle is switched off where it is."""
        self.off = True
        self.carrier.die()

    def revive(self) -> None:
        """Switch it on again, with its memory."""
        self.off = False
        self._wake_s = float("inf")
        self.carrier.revive()
        self.life.alarm(LOOK, self.clock.now_s)
        self.flush()

    def restart(self) -> None:
        """Restart its software, which then knows only what the body senses."""
        now_s = self.clock.now_s
        travel = self.carrier.travel
        here, ahead = travel.node, travel.next_node(now_s)
        docked = self.right_of_way.docked
        travel.cut(now_s)
        self.carrier.watch()
        self._life += 1
        self.was_cut = True
        self.life.timers = Timers()
        self._wake_s = float("inf")
        self.life.effects.clear()
        self.right_of_way = self._make(ahead if ahead != here else "")
        self._sense()
        self.right_of_way.start(now_s)
        if docked:
            self.right_of_way.dock(now_s)
        elif self._wanted[0]:
            self.go(self._wanted[0], idle=self._wanted[1])
        self.life.alarm(LOOK, now_s)
        self._done()

    def _sense(self) -> None:
        self.right_of_way.sense(*self.carrier.sense())

    def _done(self) -> None:
        self.flush()
        self.carrier.mark()
        if not self._asked and self.right_of_way.has_arrived:
            self._asked = True
            self.carrier.arrive()

"""The default plant behind VDA 5050, with one vehicle that says an odd word: the others' work goes on, and people hear what is wrong."""

from __future__ import annotations

import asyncio
import json
import math
from collections import Counter
from collections.abc import Callable
from functools import cache
from random import Random
from typing import Any

import pytest
from msgspec.structs import replace
from variants import in_campaigns

from dray.adapters.vda5050.profile import load_profile
from dray.body import Drive, Hold
from dray.messages import AtvHeartbeat, Event, Message
from dray.messages.fact import TaskClosed
from dray.plant import default_plant
from dray_sim.checks.floor.held_places import HeldPlaces
from dray_sim.checks.floor.overlaps import Overlaps
from dray_sim.checks.invariants import Invariants
from dray_sim.clock.loop import JUMP, clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.listeners import Listeners
from dray_sim.people import demand
from dray_sim.people.order_client import OrderClient
from dray_sim.vda5050.fleet import DELAY_S, MemoryFleet
from dray_sim.vda5050.vehicle import Vda5050Vehicle

SPAN_S = 3600.0
ODD = "ATV1"
FROM_S = 300.0
"""From then on it is odd as soon as it drives with a load or for one."""
TOLD_S = 60.0
"""By when its problem has a name, unless it may take longer than that (`Odd.told_s`)."""
PROFILE = load_profile("dray-sim")
V3 = replace(PROFILE, version="3.0")
NOTHING: dict[str, Any] = {}

State = dict[str, Any]


class Odd:
    """What one vehicle does and says otherwise.

    Args:
        say: changes each state of it; the seconds since it is odd are the second value.
        do: happens to the vehicle once, when it begins.
        told_s: by when people hear of a problem with a name; None where it works on all the same, or what it does is known otherwise.
    """

    def __init__(
        self,
        say: Callable[[State, float], None] = lambda _state, _for_s: None,
        do: Callable[[Vda5050Vehicle], None] = lambda _: None,
        told_s: float | None = None,
    ) -> None:
        self.say, self.do, self.told_s = say, do, told_s


def adds(**said: Any) -> Callable[[State, float], None]:
    return lambda state, _: state.update(said)


def lamp(state: State, _: float) -> None:
    where = "instantActionStates" if "instantActionStates" in state else "actionStates"
    state[where].append({"actionId": "hmi-1", "actionType": "beacon", "actionStatus": "RUNNING"})


def stay(status: str, *kinds: str) -> Callable[[State, float], None]:
    def say(state: State, _: float) -> None:
        for action in (*state["actionStates"], *state.get("instantActionStates", ())):
            if action.get("actionType") in kinds:
                action["actionStatus"] = status

    return say


def flicker(**said: Any) -> Callable[[State, float], None]:
    return lambda state, for_s: state.update(said if int(for_s) % 2 else NOTHING)


def battery(charge: float | None) -> Callable[[State, float], None]:
    def say(state: State, _: float) -> None:
        for name in ("batteryState", "powerSupply"):
            if name in state:
                for field in ("batteryCharge", "stateOfCharge"):
                    if field in state[name]:
                        state[name][field] = charge

    return say


def stands(vehicle: Vda5050Vehicle) -> None:
    """It stops, as at its own button or before a pallet, and does not go on."""
    vehicle._body.instruct(Hold())
    vehicle._body.instruct = lambda _: None  # type: ignore[method-assign]


def reaches_no_node(vehicle: Vda5050Vehicle) -> None:
    """It gives its order up, and keeps the error until it takes another one."""
    if vehicle.order is not None:
        vehicle.order.give_up()
    vehicle._body.instruct(Drive(order=0, nodes=(vehicle._body.sense().next_node,), released=1))
    vehicle._way = []
    vehicle.condition.errors.append(("NODE_UNREACHABLE", "CRITICAL", "cannot reach the node", {}))
    accept = vehicle._accept

    def and_forget(order: Any) -> None:
        vehicle.condition.errors = [e for e in vehicle.condition.errors if e[0] != "NODE_UNREACHABLE"]
        accept(order)

    vehicle._accept = and_forget  # type: ignore[method-assign]
    vehicle.say_state()


def refuses(vehicle: Vda5050Vehicle) -> None:
    """Every order, for a parameter of it."""
    hear = vehicle.on_message

    def on_message(topic: str, data: bytes) -> None:
        if topic == "order":
            vehicle.condition.errors = [
                ("UNSUPPORTED_PARAMETER", "CRITICAL", "not supported", {"parameter": "maximumSpeed"})
            ]
            vehicle.say_state()
        else:
            hear(topic, data)

    vehicle.on_message = on_message  # type: ignore[method-assign]


ODDITIES: dict[str, Odd] = {
    "a lamp that stays on": Odd(lamp),
    "pauses that stay WAITING": Odd(stay("WAITING", "startPause", "stopPause")),
    "pauses that stay RUNNING": Odd(stay("RUNNING", "startPause", "stopPause", "stateRequest")),
    "a cancel that stays RUNNING": Odd(stay("RUNNING", "cancelOrder")),
    "a pick that stays RUNNING": Odd(stay("RUNNING", "pick"), told_s=PROFILE.acting_s + TOLD_S),
    "driving at speed 0": Odd(adds(driving=True)),
    "a stale last node": Odd(adds(lastNodeSequenceId=0)),
    "paused while it drives": Odd(adds(paused=True)),
    "a node that it cannot reach": Odd(do=reaches_no_node, told_s=TOLD_S),
    "a parameter that it refuses": Odd(do=refuses, told_s=TOLD_S),
    "its pause button": Odd(adds(paused=True, driving=False), stands, told_s=TOLD_S),
    "an obstacle": Odd(
        adds(safetyState={"eStop": "NONE", "fieldViolation": True}, driving=False, paused=False),
        stands,
        told_s=TOLD_S,
    ),
    "it stands in silence": Odd(adds(paused=False), stands, told_s=TOLD_S),
    "it says that it drives, and stands": Odd(adds(driving=True, paused=False), stands, told_s=TOLD_S),
    "an emergency stop that flickers": Odd(flicker(safetyState={"eStop": "AUTOACK"}), told_s=TOLD_S),
    "a fatal error that flickers": Odd(
        flicker(errors=[{"errorType": "motor", "errorLevel": "FATAL"}]), told_s=TOLD_S
    ),
    "a critical error that stays": Odd(
        adds(errors=[{"errorType": "tooHot", "errorLevel": "CRITICAL"}]), told_s=TOLD_S
    ),
    "an order error that stays": Odd(adds(errors=[{"errorType": "orderError", "errorLevel": "WARNING"}])),
    "instant actions that are full": Odd(
        adds(errors=[{"errorType": "INSTANT_ACTION_STATES_FULL", "errorLevel": "WARNING"}])
    ),
    "zone actions that are full": Odd(
        adds(errors=[{"errorType": "ZONE_ACTION_STATES_FULL", "errorLevel": "WARNING"}])
    ),
    "a warning that stays": Odd(adds(errors=[{"errorType": "x" * 1500, "errorLevel": "WARNING"}])),
    "a battery that counts to 1": Odd(battery(0.85)),
    "a battery of -1": Odd(battery(-1)),
    "a battery of 255": Odd(battery(255)),
    "a battery that is no number": Odd(battery(math.nan)),
    "no word on its battery": Odd(battery(None)),
}


class Played:
    """A run of the plant.

    Attributes:
        outcomes: how transports ended, with how often.
        problems: what was wrong with the odd vehicle, by the second after which it was said first.
    """

    def __init__(self, odd: Odd, version: str) -> None:
        self.odd = odd
        self.outcomes: Counter[str] = Counter()
        self.problems: dict[str, float] = {}
        self._since_s = math.inf
        plant = default_plant()
        self._clock = clock()
        profile = PROFILE if version == "2" else V3
        self._fleet = MemoryFleet(plant, self._clock, lambda _: profile, carry=self._carry)
        listeners = Listeners()
        self._factory = SimFactory(
            plant, self._clock, seed=1, listener=listeners, traffic=True, embody=self._fleet.embody
        )
        self.overlaps = Overlaps(self._factory.vehicles, strict=False)
        self.invariants = Invariants(self._factory, HeldPlaces(self._factory))
        listeners.add(self, self.overlaps, self.invariants)
        self._orders = list(demand.orders(plant, Random(1), load=1.0, until_s=SPAN_S))

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        if type(message) is Event and type(message.fact) is TaskClosed:
            self.outcomes[message.fact.outcome] += 1
        elif type(message) is AtvHeartbeat and sender == ODD:
            if self._since_s == math.inf and at_s >= FROM_S and self._fleet.vehicles[ODD]._way:
                self._since_s = at_s
                self.odd.do(self._fleet.vehicles[ODD])
            if message.problem:
                self.problems.setdefault(message.problem, at_s - self._since_s)

    def _carry(self, atv: str, data: bytes, hand: Callable[[bytes], None]) -> None:
        since_s = self._clock.now_s() - self._since_s
        if atv == ODD and since_s >= 0 and b'"nodeStates"' in data:
            said = json.loads(data)
            self.odd.say(said, since_s)
            data = json.dumps(said).encode()
        self._clock.call_at(self._clock.now_s() + DELAY_S, lambda: hand(data))

    @property
    def is_odd(self) -> bool:
        """Whether it has come to that."""
        return self._since_s < math.inf

    async def play(self) -> Played:
        running = asyncio.create_task(self._factory.run())
        customers = asyncio.create_task(
            OrderClient(self._factory.bus, self._factory.clock).place(self._orders)
        )
        await asyncio.sleep(SPAN_S)
        assert not running.done(), running
        self.invariants.check_end(self._clock.now_s())
        for task in (running, customers):
            task.cancel()
        await asyncio.gather(running, customers, return_exceptions=True)
        return self


async def played(odd: Odd, version: str) -> Played:
    return await Played(odd, version).play()


@cache
def without(version: str) -> int:
    """Transports that a fleet delivers in which nobody is odd."""
    return run(played(Odd(), version), JUMP).outcomes["delivered"]


@pytest.mark.parametrize("version", ["2", "3"])
@pytest.mark.parametrize("what", in_campaigns(ODDITIES))
def test_work_goes_on_and_what_hinders_it_has_a_name(what: str, version: str) -> None:
    odd = ODDITIES[what]
    one = run(played(odd, version), JUMP)
    assert one.is_odd, "it has driven"
    assert (one.overlaps.count, one.invariants.broken) == (0, None)
    assert one.outcomes["delivered"] >= 0.9 * without(version)
    if odd.told_s is None:
        assert not one.problems
    else:
        assert min(one.problems.values()) <= odd.told_s

"""What a factory tells of one order on its way, step by step, for the tests of the customer's page."""

from __future__ import annotations

from collections.abc import Iterable
from datetime import UTC, datetime
from typing import Any

from gateway_kit import PRODUCT, House
from heartbeats import events, machine_heartbeat
from wall_clock import NOW_S

from dray.messages import Event, MaterialWait, Phase, Reason, Role, Transport
from dray.messages.fact import (
    AnyFact,
    GoalContracted,
    GoalLost,
    GoalWaits,
    GoodsDelivered,
    MachineFailure,
    OrderAccepted,
    PhaseEntered,
    PieceMade,
    TaskOpened,
)
from dray.messages.heartbeat import GoalBrief, MachineStatus

GERMAN = {"Accept-Language": "de"}

MACHINE, OTHER_MACHINE, VEHICLE = "M4", "M5", "ATV2"

GOAL = "strategist.1-7"

WAY_OUT = "M4.1-3"

PACE_S = 10.0


class Story:
    """One order of some pieces of one product, told by the agents as a test wishes.

    Args:
        house: the gateway.
        order: the answer to `POST /api/orders`.
        quantity: pieces of it.
    """

    def __init__(self, house: House, order: dict[str, Any], quantity: int = 40) -> None:
        self.house, self.order, self.quantity = house, order, quantity
        self.token = order["tracking_url"].rpartition("/")[2]
        self._numbers: dict[str, int] = {}
        self._beats: dict[str, int] = {}

    @classmethod
    async def begin(cls, house: House, quantity: int = 40, **fields: Any) -> Story:
        """Place the order."""
        items = [{"product": PRODUCT, "quantity": quantity}]
        return cls(house, await house.place(**{"items": items, **fields}), quantity)

    @property
    def path(self) -> str:
        return f"/track/{self.token}"

    async def state(self) -> dict[str, Any]:
        """What the API tells."""
        return dict(await self.house.get(f"/api{self.path}"))

    async def page(self, **headers: str) -> str:
        """The page."""
        answer = await self.house.client.get(self.path, headers=headers)
        assert answer.status_code == 200, answer.text
        return answer.text

    def now(self, plant_s: float) -> None:
        """Let it be that late."""
        self.house.wall.now_s = NOW_S + plant_s

    async def planned(self, goal: str = GOAL, machine: str = MACHINE, finish_s: float = 600.0) -> None:
        """A machine takes all of it."""
        fact = GoalContracted(goal, self.order["id"], 0, PRODUCT, self.quantity, machine, finish_s)
        await self.tell("strategist", 100.0, OrderAccepted(order=self.order["id"], goals=(goal,)), fact)
        self.beat(machine, 100.0, goal=goal)

    async def making(
        self,
        made: int,
        status: MachineStatus = MachineStatus.PRODUCING,
        goal: str = GOAL,
        machine: str = MACHINE,
    ) -> float:
        """It has made so many, one every `PACE_S`; it is the time of the last one now, which is returned."""
        for number in range(1, made + 1):
            await self.tell(machine, 110.0 + PACE_S * number, PieceMade(goal, PRODUCT, number))
        last_s = 110.0 + PACE_S * made
        self.now(last_s)
        self.beat(machine, last_s, status, goal, made)
        return last_s

    def beat(
        self,
        machine: str,
        at_s: float,
        status: MachineStatus = MachineStatus.PRODUCING,
        goal: str = GOAL,
        made: int = 0,
        waits: tuple[MaterialWait, ...] = (),
    ) -> None:
        """The machine's heartbeat, in which it is at this goal, and what it waits for."""
        self._beats[machine] = self._beats.get(machine, 0) + 1
        brief = GoalBrief(goal, PRODUCT, self.quantity, made, 0)
        self.house.bus.say(
            machine_heartbeat(
                machine, self._beats[machine], at_s=at_s, status=status, goals=(brief,), waits=waits
            )
        )

    async def leaving(self, at_s: float) -> None:
        """A vehicle drives off with goods."""
        work = Transport(PRODUCT, 4, (MACHINE,), "delivery", "tote", goal=GOAL)
        await self.tell(
            MACHINE, at_s, TaskOpened(WAY_OUT, 1, Role.PRIMARY, 1, work, 20.0, at_s + 300, at_s + 5)
        )
        await self.tell(VEHICLE, at_s, PhaseEntered(WAY_OUT, 1, Phase.CARRYING, MACHINE))

    async def arrived(self, delivered: int, at_s: float) -> None:
        """So many have arrived."""
        fact = GoodsDelivered(GOAL, self.order["id"], 0, PRODUCT, delivered, delivered)
        await self.tell(MACHINE, at_s, fact)
        self.now(at_s)

    async def lost(self, at_s: float) -> None:
        """The machine fails with it."""
        await self.tell("strategist", at_s, GoalLost(GOAL, MACHINE, 0, "strategist.1-8"))

    async def waiting(self, at_s: float) -> None:
        """Nobody can make it."""
        fact = GoalWaits(
            GOAL,
            self.order["id"],
            (MachineFailure(MACHINE, Reason.BROKEN), MachineFailure(OTHER_MACHINE, Reason.SILENT)),
        )
        await self.tell("strategist", at_s, fact)

    async def tell(self, agent: str, at_s: float, *facts: AnyFact) -> None:
        """An agent's next facts, at this time."""
        first = self._numbers.get(agent, 0) + 1
        self._numbers[agent] = first + len(facts) - 1
        told: Iterable[Event] = [
            Event(agent=event.agent, incarnation=1, number=event.number, at_s=at_s, fact=event.fact)
            for event in events(agent, *facts, first=first)
        ]
        await self.house.say(told)


def assert_private(headers: Any) -> None:
    assert headers["cache-control"] == "private, no-store"
    assert headers["x-robots-tag"] == "noindex, nofollow"
    assert headers["referrer-policy"] == "no-referrer"
    assert "default-src 'self'" in headers["content-security-policy"]
    assert "unsafe" not in headers["content-security-policy"]


def iso(wall_s: float) -> str:
    return datetime.fromtimestamp(wall_s, UTC).isoformat(timespec="seconds").replace("+00:00", "Z")

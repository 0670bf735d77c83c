"""A factory whose invariants are watched while a test says what its agents would not, for tests."""

from __future__ import annotations

from makings import making
from msgspec.structs import replace

from dray.body import Admit
from dray.messages import (
    Event,
    Message,
    Role,
    Transport,
)
from dray.messages.fact import Fact, GoodsDelivered, TaskOpened
from dray.plant import load_plant
from dray_sim.checks.invariants import Invariants
from dray_sim.clock.loop import VirtualClock
from dray_sim.factory.sim_factory import SimFactory

WORK = Transport(item="shaft", quantity=40, sources=("S3",), destination="M8", ability="tote")

OPENED = TaskOpened(
    task="M8-1",
    epoch=1,
    role=Role.PRIMARY,
    round=1,
    work=WORK,
    radius_m=25.0,
    deadline_s=100.0,
    bids_until_s=1.0,
)


class Watched:
    """A factory that does not run, its invariants, and what is said to them."""

    def __init__(self) -> None:
        self.factory = SimFactory(load_plant("single-track"), VirtualClock(), seed=1)
        self.checks = Invariants(self.factory)
        self._at_s = 0.0
        self._counted: dict[str, int] = {}

    def say(self, sender: str, said: Fact | Message, address: str = "*") -> None:
        self._at_s += 1.0
        message = said
        if isinstance(said, Fact):
            message = Event(agent=sender, incarnation=1, number=1, at_s=self._at_s, fact=said)
        assert isinstance(message, Message)
        self.checks.on_message(self._at_s, sender, address, message)

    def put_up(self, goal: str, quantity: int) -> None:
        """The strategist asks who makes pumps for order O1."""
        work = making("pump-p3", quantity, "O1")
        self.say("strategist", replace(OPENED, task=goal, work=work))

    def bring(self, goal: str, pieces: int) -> None:
        """Pumps of a goal get in at the gate, and the strategist counts them."""
        gate = self.factory.gate
        gate.instruct(Admit(goal=goal, quantity=1000))
        assert gate.enter(goal, pieces) == ""
        self.count(goal, pieces)

    def count(self, goal: str, pieces: int) -> None:
        total = self._counted[goal] = self._counted.get(goal, 0) + pieces
        fact = GoodsDelivered(
            goal=goal, order="O1", item=0, product="pump-p3", quantity=pieces, delivered=total
        )
        self.say("strategist", fact)

    @property
    def broken(self) -> int:
        """The number of the broken invariant; 0 while all hold."""
        return self.checks.broken.number if self.checks.broken is not None else 0

"""Whatever fails, an ordered quantity gets in at the gate exactly once (invariant 4, paper, case 1).

The strategist is the real one. Machines are wild: they send any pieces of any goal that they ever had,
at any time, name it or not, and are silent for as long as chance wants. The gate keeps its word, and its
reports come late. The strategist is killed at any moment and goes on from what it had written down. Asked
at any moment, it says of the order that it is fulfilled when it is, and not before.
"""

from __future__ import annotations

from defaults import PLANT
from effects import facts, instructed, remember, sent
from examples import examples
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule
from rigs import StrategistRig
from spoken import accepted, goal_bid, mhb

from dray.body import Admit, GoodsArrived
from dray.memory import Memory
from dray.messages import Award, GoalBrief, OrderItem, OrderReleased, OrderTaken, Production, TaskAnnounced
from dray.messages.fact import OrderFulfilled
from dray.protocol.liveness.suspicion import GOAL_SILENCE_S
from dray.protocol.runtime.events import Effect, Publish

PRODUCT = "pump-p3"
MACHINES = PLANT.machines_for(PRODUCT)[:3]
ORDERED = 60

machines = st.sampled_from(MACHINES)


class GoalsOutlive(RuleBasedStateMachine):
    """One order, three machines, one gate."""

    def __init__(self) -> None:
        super().__init__()
        self.rig = StrategistRig()
        self.admitted: dict[str, int] = {}
        self.arrived: dict[str, int] = {}
        self.reports: list[GoodsArrived] = []
        self.work: dict[str, tuple[int, int]] = {}
        """By goal: its epoch and quantity, as it was announced last."""
        self.taken: dict[str, list[str]] = {machine: [] for machine in MACHINES}
        self.awards: dict[str, dict[str, Award]] = {machine: {} for machine in MACHINES}
        """By machine and goal: the award that it has heard last."""
        self.memory: Memory = {}
        self.fulfilled = 0
        self.beats = 0
        self.lives = 1

    # --- the world ---

    def note(self, effects: list[Effect]) -> None:
        """Carry out what the strategist wants done."""
        for admit in instructed(effects, Admit):
            self.admitted[admit.goal] = admit.quantity
            self.report(admit.goal)
        for effect in effects:
            message = effect.message if isinstance(effect, Publish) else None
            if isinstance(message, TaskAnnounced) and isinstance(message.work, Production):
                self.work[message.task] = (message.epoch, message.work.quantity)
        for machine in MACHINES:
            for award in sent(effects, Award, to=machine):
                self.awards[machine][award.task] = award
        self.memory = remember(self.memory, effects)
        self.fulfilled += len(facts(effects, OrderFulfilled))
        self.rig.all.clear()

    def report(self, goal: str) -> None:
        arrived = self.arrived.setdefault(goal, 0)
        self.reports.append(GoodsArrived(goal=goal, arrived=arrived, admitted=self.admitted[goal]))

    def enter(self, goal: str, pieces: int) -> None:
        if pieces and self.arrived.get(goal, 0) + pieces <= self.admitted.get(goal, 0):
            self.arrived[goal] = self.arrived.get(goal, 0) + pieces
            self.report(goal)

    def beat(self, machine: str, *goals: str) -> None:
        self.beats += 1
        briefs = [
            GoalBrief(goal=goal, product=PRODUCT, quantity=self.work[goal][1], made=0, delivered=0)
            for goal in goals
        ]
        self.note(self.rig.on_message(machine, mhb(machine, *briefs, seq=self.beats, at_s=self.rig.now_s)))

    def bid_for_all(self, machine: str) -> None:
        for goal, (epoch, _) in list(self.work.items()):
            self.note(self.rig.on_message(machine, goal_bid(goal, 100.0, epoch=epoch)))

    # --- what may happen ---

    @initialize()
    def order(self) -> None:
        self.note(self.rig.start())
        self.ask()

    @rule()
    def ask(self) -> None:
        """The gateway sends the order, for the first time or once more."""
        items = (OrderItem(product=PRODUCT, quantity=ORDERED),)
        effects = self.rig.on_message("gateway", OrderReleased(order="O1", items=items, due_s=7200.0))
        [taken] = sent(effects, OrderTaken)
        self.note(effects)
        assert taken.fulfilled == bool(self.fulfilled)

    @rule(machine=machines)
    def take_what_is_put_up(self, machine: str) -> None:
        for _ in range(6):
            self.bid_for_all(machine)
            self.let_time_pass(1.0)
            self.accept_all(machine)

    @rule(machine=machines)
    def accept_all(self, machine: str) -> None:
        for goal, award in self.awards[machine].items():
            answer = accepted(goal, epoch=award.epoch, number=award.number)
            self.note(self.rig.on_message(machine, answer))
            if goal not in self.taken[machine]:
                self.taken[machine].append(goal)

    @rule(machine=machines, named=st.booleans())
    def beat_once(self, machine: str, named: bool) -> None:
        self.beat(machine, *(self.taken[machine] if named else ()))

    @rule(machine=machines, which=st.integers(0, 9), pieces=st.integers(1, 24))
    def send_goods(self, machine: str, which: int, pieces: int) -> None:
        if self.taken[machine]:
            self.enter(self.taken[machine][which % len(self.taken[machine])], pieces)

    @rule(machine=machines)
    def fall_silent(self, machine: str) -> None:
        for _ in range(4):
            self.let_time_pass(GOAL_SILENCE_S / 3)
            for other in MACHINES:
                if other != machine:
                    self.beat(other, *self.taken[other])

    @rule(seconds=st.sampled_from([0.5, 2.0, GOAL_SILENCE_S + 1.0]))
    def let_time_pass(self, seconds: float) -> None:
        self.note(self.rig.run(self.rig.now_s + seconds))

    @rule(count=st.integers(1, 4))
    def tell(self, count: int) -> None:
        """The gate's next reports reach the strategist."""
        for report in self.reports[:count]:
            self.note(self.rig.report(report))
        del self.reports[:count]

    @rule()
    def kill_the_strategist(self) -> None:
        self.lives += 1
        again = StrategistRig(memory=self.memory, incarnation=self.lives)
        again.arrived, again.now_s = dict(self.arrived), self.rig.now_s
        self.rig = again
        self.reports.clear()  # Nobody was there to hear them; the new life senses what is in.
        self.note(again.start())

    # --- what must hold ---

    @invariant()
    def no_piece_is_in_twice(self) -> None:
        total = sum(self.arrived.values())
        assert total <= ORDERED
        assert self.fulfilled <= 1
        if self.fulfilled:
            assert total == ORDERED

    def teardown(self) -> None:
        """All is well again: then the order is fulfilled within a bounded time."""
        for _ in range(120):
            if self.fulfilled:
                break
            self.tell(len(self.reports))
            self.let_time_pass(0.5)
            for machine in MACHINES:
                self.bid_for_all(machine)
                self.accept_all(machine)
                self.beat(machine, *self.taken[machine])
                for goal in self.taken[machine]:
                    self.enter(goal, max(0, self.admitted.get(goal, 0) - self.arrived.get(goal, 0)))
        if self.work:
            assert self.fulfilled == 1
            self.no_piece_is_in_twice()


TestGoalsOutlive = GoalsOutlive.TestCase
TestGoalsOutlive.settings = settings(max_examples=examples(400), stateful_step_count=40, deadline=None)

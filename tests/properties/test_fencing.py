"""One carrier per epoch, whoever believes to be it: supervision and takeover, from both sides.

`Coordinating` is machine M7 among vehicles that are played by an adversary: they bid, accept, decline, beat,
fall silent, take over, dock and hand over as they like, in any order and with any epoch. Whatever they do, the
machine speaks to one carrier per epoch and opens its dock to nobody else.

`Watching` is a secondary of a scripted coordinator. It takes over when its naive twin says that the primary has
failed, not before, once, with the next epoch; and it says so until it is answered.
"""

from __future__ import annotations

import hypothesis.strategies as st
from actors import Actor
from bodies import PlainVehicle, PlainWorkcell
from credulous import believing
from defaults import PLANT
from examples import examples
from hypothesis import settings
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule
from spoken import accepted, award, bid, declined, production, rhb

from dray.body import CloseDock, OpenDock
from dray.messages import (
    Accepted,
    Award,
    Confirmed,
    Docked,
    DockOpened,
    Handover,
    HandoverAccepted,
    Message,
    Reason,
    Release,
    Resigned,
    Role,
    Superseded,
    TakenOver,
)
from dray.messages.fact import TaskClosed, TaskOpened, TookOver
from dray.messages.keys import STRATEGIST
from dray.protocol.machine.machine import Machine
from dray.protocol.runtime.events import Effect, Instruct, Record, Send
from dray.protocol.runtime.retransmission import ASK_AGAIN_S
from dray.protocol.vehicle.atv import Atv

ATVS = ("ATV1", "ATV2", "ATV3")
TASKS = ("M7-1", "M7-2")
EPOCHS = st.integers(0, 6)
SPANS_S = st.sampled_from([0.1, 1.0, 1.0, 3.0, 8.0, 20.0])


class Coordinating(RuleBasedStateMachine):
    """A machine that asks for material, and whoever answers."""

    @initialize()
    def begins(self) -> None:
        self.now_s = 0.0
        self.carriers: dict[tuple[str, int], str] = {}
        """By task and epoch: the one vehicle that was spoken to as its carrier."""
        self.epochs: dict[str, int] = {}
        """By task: the highest epoch that was announced or confirmed."""
        self.handed_over: dict[str, str] = {}
        """By task: who has brought the load."""
        self.closed: set[str] = set()
        self.dock: dict[str, str] = {}
        """Vehicles to which the dock is open, and for which task."""
        self.docking = ("", "")
        self.hired: dict[tuple[str, int], str] = {}
        """By task and epoch: who has accepted last, and may believe to be bound."""
        self.awards: dict[tuple[str, str, Role], Award] = {}
        self.seq = 0
        self.actor = Actor(
            lambda life: believing(Machine("M7", PLANT, incarnation=life)),
            PlainWorkcell("M7", PLANT),
            self.see,
        )
        self.actor.start(0.0)
        goal = Award(task="G1", epoch=1, role=Role.PRIMARY, work=production(), deadline_s=3600.0)
        self.told(STRATEGIST, goal)
        self.told(STRATEGIST, Confirmed(task="G1", epoch=1))

    @rule(span_s=SPANS_S)
    def time_passes(self, span_s: float) -> None:
        self.now_s += span_s
        self.actor.run(self.now_s)

    @rule(atv=st.sampled_from(ATVS), task=st.sampled_from(TASKS), role=st.sampled_from(Role), epoch=EPOCHS)
    def bids(self, atv: str, task: str, role: Role, epoch: int) -> None:
        self.told(atv, bid(50.0, task=task, epoch=epoch, role=role))

    @rule(atv=st.sampled_from(ATVS), task=st.sampled_from(TASKS))
    def bids_well(self, atv: str, task: str) -> None:
        self.told(atv, bid(50.0, task=task, epoch=self.epochs.get(task, 1)))
        self.time_passes(1.5)

    @rule(
        atv=st.sampled_from(ATVS), task=st.sampled_from(TASKS), role=st.sampled_from(Role), yes=st.booleans()
    )
    def answers(self, atv: str, task: str, role: Role, yes: bool) -> None:
        """An award, perhaps an old one."""
        given = self.awards.get((atv, task, role))
        if given is None:
            return
        if yes and role is Role.PRIMARY:
            self.hired[task, given.epoch] = atv
        say = accepted if yes else declined
        self.told(atv, say(task, epoch=given.epoch, role=role, number=given.number))

    @rule(atv=st.sampled_from(ATVS), task=st.sampled_from(TASKS), watches=st.booleans())
    def is_hired(self, atv: str, task: str, watches: bool) -> None:
        """It bids, is asked, and accepts; perhaps another one watches."""
        self.bids_well(atv, task)
        self.answers(atv, task, Role.PRIMARY, yes=True)
        if watches:
            for other in ATVS:
                self.told(other, bid(50.0, task=task, epoch=self.epochs.get(task, 1), role=Role.SECONDARY))
                self.time_passes(0.1)
                self.answers(other, task, Role.SECONDARY, yes=True)

    @rule(atv=st.sampled_from(ATVS), task=st.sampled_from((*TASKS, "")), beats=st.sampled_from([1, 1, 9]))
    def beats(self, atv: str, task: str, beats: int) -> None:
        for _ in range(beats):
            self.seq += 1
            self.told(atv, rhb(atv, self.seq, self.now_s, task=task, coordinator="M7"))
            if beats > 1:
                self.time_passes(1.0)

    @rule(atv=st.sampled_from(ATVS), task=st.sampled_from(TASKS), epoch=EPOCHS, primary=st.sampled_from(ATVS))
    def takes_over(self, atv: str, task: str, epoch: int, primary: str) -> None:
        if self.carriers.get((task, epoch), atv) == atv:
            self.told(atv, TakenOver(task=task, epoch=epoch, primary=primary))

    @rule(atv=st.sampled_from(ATVS), task=st.sampled_from(TASKS))
    def takes_over_well(self, atv: str, task: str) -> None:
        """From the present carrier, if there is one."""
        epoch = self.epochs.get(task, 0)
        primary = self.carriers.get((task, epoch)) or self.hired.get((task, epoch), "")
        if primary not in ("", atv):
            self.told(atv, TakenOver(task=task, epoch=epoch + 1, primary=primary))

    @rule(atv=st.sampled_from(ATVS), task=st.sampled_from(TASKS), epoch=EPOCHS)
    def docks(self, atv: str, task: str, epoch: int) -> None:
        self.docking = (atv, task)
        self.told(atv, Docked(task=task, epoch=epoch, station="M7"))

    @rule(task=st.sampled_from(TASKS), hands_over=st.booleans())
    def present_carrier_docks(self, task: str, hands_over: bool) -> None:
        epoch = self.epochs.get(task, 1)
        carrier = self.hired.get((task, epoch))
        if carrier is None:
            return
        self.docks(carrier, task, epoch)
        if hands_over:
            self.hands_over(carrier, task, epoch)

    @rule(atv=st.sampled_from(ATVS), task=st.sampled_from(TASKS), epoch=EPOCHS)
    def hands_over(self, atv: str, task: str, epoch: int) -> None:
        self.told(atv, Handover(task=task, epoch=epoch, quantity=24))

    @rule(atv=st.sampled_from(ATVS), task=st.sampled_from(TASKS), role=st.sampled_from(Role), epoch=EPOCHS)
    def resigns(self, atv: str, task: str, role: Role, epoch: int) -> None:
        self.told(atv, Resigned(task=task, epoch=epoch, role=role, reason=Reason.PROBLEM))

    @rule(down_s=st.sampled_from([0.0, 2.0, 30.0]))
    def crashes_and_starts(self, down_s: float) -> None:
        self.actor.crash()
        self.time_passes(down_s)
        self.actor.start(self.now_s)

    @invariant()
    def the_dock_is_open_to_present_carriers_only(self) -> None:
        for atv, task in self.dock.items():
            present = self.carriers.get((task, self.epochs.get(task, 0)))
            assert task not in self.closed, f"the dock is open to {atv} for {task}, which has ended"
            assert present == atv, f"the dock is open to {atv}, and {present or 'nobody'} carries {task}"

    def told(self, sender: str, message: Message) -> None:
        self.actor.on_message(sender, message, self.now_s)

    def see(self, effect: Effect) -> None:
        if isinstance(effect, Send):
            self.see_sent(effect.to, effect.message)
        elif isinstance(effect, Instruct):
            if isinstance(effect.instruction, OpenDock):
                assert effect.instruction.vehicle == self.docking[0]
                self.dock[effect.instruction.vehicle] = self.docking[1]
            elif isinstance(effect.instruction, CloseDock):
                self.dock.pop(effect.instruction.vehicle, None)
        elif isinstance(effect, Record):
            if isinstance(effect.fact, TaskClosed):
                assert effect.fact.task not in self.closed, f"{effect.fact.task} was closed twice"
                self.closed.add(effect.fact.task)
            elif isinstance(effect.fact, TaskOpened):
                assert effect.fact.task not in self.closed
                self.rises(effect.fact.task, effect.fact.epoch)

    def see_sent(self, to: str, message: Message) -> None:
        if isinstance(message, Award):
            self.awards[to, message.task, message.role] = message
        elif isinstance(message, HandoverAccepted):
            carrier = self.handed_over.setdefault(message.task, to)
            assert carrier == to, f"{message.task} was handed over by {carrier} and by {to}"
        elif isinstance(message, DockOpened | Confirmed):
            self.rises(message.task, message.epoch)
            carrier = self.carriers.setdefault((message.task, message.epoch), to)
            assert carrier == to, f"{message} to {to}, and {carrier} carries"

    def rises(self, task: str, epoch: int) -> None:
        assert epoch >= self.epochs.get(task, 0), f"the epoch of {task} has fallen to {epoch}"
        self.epochs[task] = epoch


class Watching(RuleBasedStateMachine):
    """A vehicle that is secondary of M8-1."""

    @initialize(seed=st.integers(0, 3))
    def begins(self, seed: int) -> None:
        self.now_s = 0.0
        self.epoch = 1
        self.seq = 0
        self.took_over: list[TookOver] = []
        self.claims = 0
        self.watches = True
        self.answered = False
        self.body = PlainVehicle("ATV1", PLANT, ("p3", "s3", "m8", "p1")[seed], lambda *_: "")
        self.actor = Actor(_light, self.body, self.see)
        self.actor.start(0.0)
        self.told("M8", award(role=Role.SECONDARY, primary="ATV2"))
        self.heard_s = self.now_s
        self.beats()

    @rule(span_s=st.sampled_from([0.2, 1.0, 3.0, 3.4]))
    def time_passes(self, span_s: float) -> None:
        claims = self.claims
        self.now_s += span_s
        self.actor.run(self.now_s)
        claiming = self.took_over and not self.answered and self.now_s - self.took_over_s > span_s
        if claiming and span_s > ASK_AGAIN_S:
            assert self.claims > claims, "it does not say again that it has taken over"

    @precondition(lambda self: not self.took_over)
    @rule()
    def beats(self) -> None:
        """The primary lives."""
        self.seq += 1
        self.heard_s = self.now_s
        self.told("ATV2", rhb("ATV2", self.seq, self.now_s, task="M8-1"))

    @precondition(lambda self: not self.took_over)
    @rule(beats=st.integers(2, 20))
    def beats_for_a_while(self, beats: int) -> None:
        for _ in range(beats):
            self.time_passes(1.0)
            if not self.took_over:
                self.beats()

    @precondition(lambda self: not self.took_over and self.watches)
    @rule(who=st.sampled_from(["M8", "M7"]))
    def is_released(self, who: str) -> None:
        self.watches = self.watches and who != "M8"
        self.told(who, Release(task="M8-1", epoch=1, role=Role.SECONDARY, reason=Reason.TASK_ENDED, number=1))

    @precondition(lambda self: self.took_over and not self.answered)
    @rule(kind=st.sampled_from(["confirmed", "released", "superseded"]))
    def is_answered(self, kind: str) -> None:
        self.answered = True
        answers: dict[str, Message] = {
            "confirmed": Confirmed(task="M8-1", epoch=2),
            "released": Release(task="M8-1", epoch=2, role=Role.PRIMARY, reason=Reason.IS_HEARD),
            "superseded": Superseded(task="M8-1", epoch=3),
        }
        self.told("M8", answers[kind])

    @rule()
    def hears_an_old_answer(self) -> None:
        self.told("M8", Confirmed(task="M8-1", epoch=1))
        self.told("M7", Confirmed(task="M8-1", epoch=2))

    @invariant()
    def it_takes_over_in_time_once_and_with_the_next_epoch(self) -> None:
        if not self.watches:
            assert not self.took_over
        elif not self.took_over:
            assert self.now_s - self.heard_s <= SILENCE_S, "a silent primary is not replaced"
        else:
            [took] = self.took_over
            assert took.epoch == 2
            assert took.silent_s >= SILENCE_S - 1e-9, "a primary that was heard is replaced"

    def told(self, sender: str, message: Message) -> None:
        self.actor.on_message(sender, message, self.now_s)

    def see(self, effect: Effect) -> None:
        if isinstance(effect, Record) and isinstance(effect.fact, TookOver):
            self.took_over.append(effect.fact)
            self.took_over_s = self.actor.now_s
        elif isinstance(effect, Send):
            if isinstance(effect.message, TakenOver):
                assert not self.answered, "it says again what was answered"
                self.claims += 1
            elif isinstance(effect.message, Accepted):
                assert effect.message.role is Role.SECONDARY


SILENCE_S = 3.5
"""The bound on a link that loses nothing (`dray.protocol.liveness.suspicion`)."""


def _light(life: int) -> Atv:
    return Atv("ATV1", PLANT, vehicle_type="light", incarnation=life)


TestCoordinating = Coordinating.TestCase
TestCoordinating.settings = settings(max_examples=examples(120), stateful_step_count=30)
TestWatching = Watching.TestCase
TestWatching.settings = settings(max_examples=examples(60), stateful_step_count=20)


def test_a_dock_that_an_earlier_life_has_opened_is_shut_by_the_next_one() -> None:
    hall = Coordinating()
    hall.begins()
    hall.is_hired("ATV1", "M7-1", watches=False)
    hall.present_carrier_docks("M7-1", hands_over=False)
    assert hall.dock == {"ATV1": "M7-1"}
    hall.crashes_and_starts(0.0)
    hall.hands_over("ATV1", "M7-1", 1)
    assert hall.closed == {"M7-1"}
    assert hall.dock == {}

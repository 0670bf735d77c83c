"""The search: what a seed stands for, what is asked of a trial, and how many are played."""

from __future__ import annotations

import asyncio
import multiprocessing
import os
import subprocess
import sys
from contextlib import suppress
from random import Random

import msgspec
import pytest

from dray.adapters.signing import SigningKey, TrustedKeys
from dray.body import Hold, Unhold
from dray.errors import UnavailableError
from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    Brief,
    CancellationTaken,
    CommandAnswered,
    CommandKind,
    Event,
    Message,
    OrderCancelled,
    OrderItem,
    OrderReleased,
    OrderRevoked,
    OrderTaken,
    Phase,
    Pose,
    Production,
    Release,
    RevocationTaken,
    Role,
    TaskAnnounced,
    Transport,
    VehicleCommand,
    signed_words,
)
from dray.messages.fact import (
    AtvStatusChanged,
    AwardAnswered,
    AwardGiven,
    CarrierChanged,
    ContractEnded,
    ContractTaken,
    Fact,
    GoalLost,
    OrderFulfilled,
    PhaseEntered,
    PieceMade,
    TaskClosed,
    TaskOpened,
)
from dray.plant import default_plant
from dray.plant.check import faults as plant_faults
from dray.protocol.leaving import LEAVES
from dray.protocol.strategist import Strategist
from dray_sim.broken import InvariantBroken
from dray_sim.demand import Order
from dray_sim.explore.blame import LATER_S, Blame
from dray_sim.explore.bonds import HEED_S, Bonds
from dray_sim.explore.calm import Calm
from dray_sim.explore.outcome import Outcome
from dray_sim.explore.passerby import Passerby
from dray_sim.explore.patience import HELP_S, NOTICE_S, Patience
from dray_sim.explore.play import play, try_seed
from dray_sim.explore.regret import Regret
from dray_sim.explore.revision import Revised, Revision
from dray_sim.explore.search import search
from dray_sim.explore.story import Story
from dray_sim.explore.trial import FAULTS_UNTIL_S, PROFILES, draw
from dray_sim.factory import SimFactory
from dray_sim.faults import Crashed, LinkTrouble, PoweredOff, RadioCut, SentAway, WlanCut
from dray_sim.habits import Habits
from dray_sim.loop import JUMP, VirtualClock, clock, run
from dray_sim.network import SimNetwork

PLANT = default_plant()
WORK = Transport(item="shaft", quantity=40, sources=("S3",), destination="M8", ability="tote")
TASK = "M8-1"

PRINT_TRACES = """
from dray_sim.explore.play import play
from dray_sim.explore.trial import draw
print(*(play(draw(seed, profile), listen=True).trace for seed, profile in ((4, "all"), (1, "links"))))
"""


def event(agent: str, fact: Fact) -> Event:
    return Event(agent=agent, incarnation=1, number=1, at_s=0.0, fact=fact)


def opened(task: str = TASK, work: Transport | Production = WORK) -> TaskOpened:
    return TaskOpened(
        task=task,
        epoch=1,
        role=Role.PRIMARY,
        round=1,
        work=work,
        radius_m=25.0,
        deadline_s=100.0,
        bids_until_s=1.0,
    )


def closed(task: str = TASK) -> TaskClosed:
    return TaskClosed(task=task, epoch=1, outcome="delivered", carrier="ATV2")


def heartbeat(atv: str, task: str = "") -> AtvHeartbeat:
    brief = Brief(task=task, epoch=1, role=Role.PRIMARY, coordinator="M8") if task else None
    return AtvHeartbeat(
        atv=atv,
        incarnation=1,
        seq=1,
        at_s=0.0,
        status=AtvStatus.IDLE,
        pose=Pose(x_m=0.0, y_m=0.0, heading_rad=0.0),
        node="a1",
        speed_mps=0.0,
        battery_frac=1.0,
        task=brief,
    )


# --- trials ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("profile", PROFILES)
def test_a_seed_stands_for_one_trial(profile: str) -> None:
    first, again, other = draw(7, profile), draw(7, profile), draw(8, profile)
    assert first == again
    assert first.plant != other.plant
    assert str(first) == str(again)
    assert first.timetable() == again.timetable()


def test_trials_have_plants_without_faults() -> None:
    for seed in range(20):
        assert list(plant_faults(draw(seed).plant.file)) == []


def test_trials_last_twenty_minutes_and_end_in_calm() -> None:
    for seed in range(20):
        trial = draw(seed)
        assert trial.duration_s >= 1200.0
        assert trial.faults_until_s < trial.duration_s
        assert all(timed.until_s is not None for timed in trial.schedule)
        assert all((timed.until_s or 0.0) <= trial.faults_until_s for timed in trial.schedule)
        assert all(order.at_s <= trial.faults_until_s for order in trial.orders)


def test_trials_are_of_all_sorts() -> None:
    trials = [draw(seed) for seed in range(60)]
    assert {len(trial.plant.fleet) for trial in trials} == {1, 2, 3, 4, 5, 6}
    assert {trial.habits is None for trial in trials} == {True, False}
    assert {trial.passerby for trial in trials} == {True, False}
    assert {trial.codec for trial in trials} == {True, False}
    assert {len(trial.cancelled) > 0 for trial in trials} == {True, False}
    assert {len(trial.revised) > 0 for trial in trials} == {True, False}
    times = [revised.times_s for trial in trials for revised in trial.revised]
    assert {len(each) for each in times} == {1, 2, 3}
    flat = [[moment for pair in each for moment in pair] for each in times]
    assert all(each == sorted(each) and each[-1] <= FAULTS_UNTIL_S for each in flat)
    assert len({type(timed.fault) for trial in trials for timed in trial.schedule}) >= 10


# --- playing -----------------------------------------------------------------------------------------


def test_a_trial_is_played_the_same_in_every_process() -> None:
    printed = {
        subprocess.run(
            [sys.executable, "-c", PRINT_TRACES],
            env={**os.environ, "PYTHONHASHSEED": hash_seed},
            capture_output=True,
            text=True,
            check=True,
        ).stdout.strip()
        for hash_seed in ("0", "4711")
    }
    here = [play(draw(seed, profile), listen=True).trace for seed, profile in ((4, "all"), (1, "links"))]
    assert printed == {" ".join(here)}


def test_listening_changes_nothing() -> None:
    quiet, heard = play(draw(3)), play(draw(3), listen=True)
    assert msgspec.structs.replace(heard, trace="") == quiet
    assert len(heard.trace) == 32


def test_an_error_in_a_run_is_an_outcome(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> list[object]:
        raise ZeroDivisionError("never mind")

    monkeypatch.setattr(Strategist, "handle", fail)
    outcome = try_seed(1)
    assert outcome.broken.startswith("invariant 8 is broken: ended by ZeroDivisionError('never mind')")
    assert "test_explore.py" in outcome.broken


def test_an_outcome_passes_as_data() -> None:
    outcome = play(draw(2))
    assert msgspec.json.decode(msgspec.json.encode(outcome), type=Outcome) == outcome
    assert outcome.replay == "dray sim explore --seed 2"
    assert play(draw(0, "calm")).replay == "dray sim explore --seed 0 --profile calm"


def test_a_violation_is_told_with_what_came_before_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def patience_of_a_child(_self: Patience, _item: str, _done: int) -> float:
        return 1.0

    monkeypatch.setattr(Patience, "task_s", patience_of_a_child)
    outcome = next(found for found in map(try_seed, range(50)) if found.broken)
    assert "did not end in" in outcome.broken
    assert outcome.story
    assert outcome.trace
    task = outcome.broken.split(": ")[1].split()[0]
    assert any(task in line for line in outcome.story)


# --- many trials -------------------------------------------------------------------------------------


def test_processes_change_nothing_but_the_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dray_sim.explore.search.CHUNK", 2)
    seeds: list[int] = []
    one = search(0, 5, profile="calm")
    two = search(0, 5, profile="calm", jobs=2, progress=lambda outcome: seeds.append(outcome.seed))
    assert seeds == list(range(5))
    assert one.trials == two.trials == 5
    assert (one.virtual_s, one.messages, one.transports) == (two.virtual_s, two.messages, two.transports)
    assert not one.interrupted
    assert one.rate > 0


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_search_that_is_stopped_tells_what_it_has_seen(jobs: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dray_sim.explore.search.CHUNK", 2)

    def stop(outcome: Outcome) -> None:
        if outcome.seed == 1:
            raise KeyboardInterrupt

    summary = search(0, 10_000, profile="calm", jobs=jobs, progress=stop)
    assert summary.interrupted
    assert summary.trials == 2
    assert (summary.first, summary.last) == (0, 10_000)


def test_a_process_that_is_killed_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dray_sim.explore.search.CHUNK", 2)

    def kill(_outcome: Outcome) -> None:
        for child in multiprocessing.active_children():
            child.kill()

    with pytest.raises(UnavailableError, match=r"one of its processes was killed; .* fewer --jobs"):
        search(0, 10_000, profile="calm", jobs=2, progress=kill)


def test_violations_are_kept_for_reading(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Patience, "task_s", lambda *_: 1.0)
    summary = search(0, 4)
    assert summary.broken == len(summary.violations) > 0
    assert [found.seed for found in summary.violations] == sorted(found.seed for found in summary.violations)


# --- the calm ----------------------------------------------------------------------------------------


class Watched:
    """A calm with a clock of its own."""

    def __init__(self, habits: Habits | None = None) -> None:
        self.patience = Patience(PLANT, habits)
        self.calm = Calm(self.patience)
        self.now_s = 0.0

    def say(self, sender: str, said: Fact | Message) -> None:
        message = event(sender, said) if isinstance(said, Fact) else said
        assert isinstance(message, Message)
        self.calm.hear(self.now_s, sender, "*", message)

    def wait(self, seconds: float) -> None:
        """Let time pass; M1 makes pieces of something else all the while."""
        until_s = self.now_s + seconds
        while self.now_s < until_s:
            self.now_s = min(self.now_s + 5.0, until_s)
            self.say("M1", heartbeat("ATV8"))


def test_before_the_calm_nothing_is_asked() -> None:
    watched = Watched()
    watched.say("M8", opened())
    watched.wait(10_000.0)
    assert not watched.calm.over.is_set()


def test_a_task_that_nobody_serves_is_noticed() -> None:
    watched = Watched()
    watched.say("M8", opened())
    watched.wait(100.0)
    watched.calm.begin(watched.now_s)
    bound_s = watched.patience.task_s("shaft", 0)
    watched.wait(bound_s - 10.0)
    with pytest.raises(InvariantBroken, match="M8-1 did not end"):
        watched.wait(20.0)


def test_a_task_waits_longer_while_others_are_served() -> None:
    watched = Watched()
    watched.calm.begin(0.0)
    watched.say("M8", opened())
    for number in range(8):
        watched.wait(watched.patience.transport_s / 4)
        watched.say("M2", opened(f"M2-{number}"))
        watched.say("M2", closed(f"M2-{number}"))
    assert watched.now_s > watched.patience.transport_s
    with pytest.raises(InvariantBroken, match="M8-1 did not end"):
        watched.wait(watched.patience.task_s("shaft", 8))


def test_an_order_for_which_nothing_happens_is_noticed() -> None:
    watched = Watched()
    watched.say("desk", OrderReleased(order="D1", items=(), due_s=0.0))
    watched.calm.begin(0.0)
    watched.wait(watched.patience.stall_s - 10.0)
    watched.say("M1", PieceMade(goal="D1-1", product="pump-p3", made=1))
    watched.wait(watched.patience.stall_s - 10.0)
    with pytest.raises(InvariantBroken, match=r"nothing came forward .* D1"):
        watched.wait(20.0)


def test_the_calm_is_over_when_everything_has_ended() -> None:
    watched = Watched()
    watched.say("desk", OrderReleased(order="D1", items=(), due_s=0.0))
    watched.say("M8", opened())
    watched.say("strategist", opened("D1-1", Production(product="pump-p3", quantity=1, order="D1", item=0)))
    watched.calm.begin(0.0)
    watched.wait(10.0)
    assert not watched.calm.over.is_set()
    watched.say("M8", closed())
    watched.wait(10.0)
    assert not watched.calm.over.is_set()
    watched.say("strategist", OrderFulfilled(order="D1"))
    watched.wait(10.0)
    assert watched.calm.over.is_set()


def test_an_order_that_is_cancelled_needs_nothing_any_more() -> None:
    watched = Watched()
    released = OrderReleased(order="D1", items=(), due_s=0.0)
    watched.say("desk", released)
    watched.calm.begin(0.0)
    watched.say("strategist", CancellationTaken(order="D1"))
    watched.say("desk", released)
    watched.wait(10.0)
    assert watched.calm.over.is_set()


def test_an_order_that_is_taken_back_needs_nothing_until_it_is_released_again() -> None:
    watched = Watched()
    released = OrderReleased(order="D1", items=(), due_s=0.0)
    watched.say("desk", released)
    watched.calm.begin(0.0)
    watched.say("strategist", RevocationTaken("D1", 1, (3,)))
    watched.say("desk", released)
    watched.wait(10.0)
    assert watched.calm.over.is_set()
    watched.say("revision", msgspec.structs.replace(released, release=2))
    watched.say("strategist", RevocationTaken("D1", 1, (3,)))
    watched.wait(10.0)
    assert not watched.calm.over.is_set()
    watched.say("strategist", OrderFulfilled(order="D1"))
    watched.wait(10.0)
    assert watched.calm.over.is_set()


def test_a_vehicle_that_works_on_for_nobody_is_noticed() -> None:
    watched = Watched()
    watched.calm.begin(0.0)
    watched.say("M8", opened())
    watched.say("M8", closed())
    watched.say("ATV2", heartbeat("ATV2", TASK))
    watched.wait(100.0)
    assert not watched.calm.over.is_set()
    with pytest.raises(InvariantBroken, match="ATV2 still works for M8-1"):
        watched.wait(watched.patience.settle_s + watched.patience.transport_s)


def test_a_vehicle_that_ends_its_work_is_free() -> None:
    watched = Watched()
    watched.calm.begin(0.0)
    watched.say("M8", opened())
    watched.say("M8", closed())
    watched.say("ATV2", heartbeat("ATV2", TASK))
    watched.say("ATV2", heartbeat("ATV2"))
    watched.wait(10.0)
    assert watched.calm.over.is_set()


def test_people_make_everything_slower() -> None:
    alone, helped = Patience(PLANT, None), Patience(PLANT, Habits())
    assert alone.settle_s == NOTICE_S + HELP_S
    assert helped.settle_s > alone.settle_s
    assert helped.transport_s == alone.transport_s
    assert helped.stall_s - alone.stall_s == pytest.approx(helped.settle_s - alone.settle_s)


def test_a_task_for_few_vehicles_may_wait_longer() -> None:
    patience = Patience(PLANT, None)
    kinds = [PLANT.vehicle_types[spec.type] for spec in PLANT.fleet.values()]
    assert any("pallet" not in kind.abilities for kind in kinds)
    assert patience.task_s("housing", 0) == patience.task_s("shaft", 0)
    assert patience.task_s("housing", 5) > patience.task_s("shaft", 5)


# --- who is to blame ---------------------------------------------------------------------------------

LOST = CarrierChanged(task=TASK, epoch=2, replaced="ATV3", carrier="ATV1", reason="silent")


def test_a_contract_that_is_lost_for_nothing_is_noticed() -> None:
    with pytest.raises(InvariantBroken, match=r"invariant 6 .* ATV3 lost M8-1"):
        Blame().hear(10.0, "M8", "*", event("M8", LOST))


@pytest.mark.parametrize("agent", ["ATV3", "M8", "ATV1"])
def test_a_fault_in_one_of_those_concerned_is_a_reason(agent: str) -> None:
    blame = Blame()
    blame.begin("F1", Crashed(agent), 10.0)
    blame.hear(1000.0, "M8", "*", event("M8", LOST))
    blame.end("F1", 1000.0)
    blame.hear(1000.0 + LATER_S - 1.0, "M8", "*", event("M8", LOST))
    with pytest.raises(InvariantBroken):
        blame.hear(1000.0 + LATER_S, "M8", "*", event("M8", LOST))


def test_a_fault_in_somebody_else_is_none() -> None:
    blame = Blame()
    blame.begin("F1", PoweredOff("ATV5"), 10.0)
    with pytest.raises(InvariantBroken):
        blame.hear(20.0, "M8", "*", event("M8", LOST))


def test_a_stopped_vehicle_may_lose_its_contract() -> None:
    blame = Blame()
    blame.hear(0.0, "ATV3", "*", event("ATV3", AtvStatusChanged(status=AtvStatus.STOPPED)))
    blame.hear(1000.0, "M8", "*", event("M8", LOST))
    blame.hear(1000.0, "ATV3", "*", event("ATV3", AtvStatusChanged(status=AtvStatus.WORKING)))
    blame.hear(1001.0, "M8", "*", event("M8", LOST))


GIVEN_BACK = CarrierChanged(task=TASK, epoch=2, replaced="ATV3", carrier="", reason=LEAVES)


def test_a_vehicle_that_was_asked_to_leave_may_give_its_task_back_and_need_not_be_missed() -> None:
    blame = Blame()
    blame.begin("F1", SentAway("ATV3"), 10.0)
    blame.hear(20.0, "M8", "*", event("M8", GIVEN_BACK))
    with pytest.raises(InvariantBroken, match=r"ATV3 lost M8-1 \(silent\)"):
        blame.hear(20.0, "M8", "*", event("M8", LOST))


def test_whoever_was_not_asked_to_leave_does_not() -> None:
    blame = Blame()
    blame.begin("F1", Crashed("ATV3"), 10.0)
    with pytest.raises(InvariantBroken, match="ATV3 lost M8-1"):
        blame.hear(20.0, "M8", "*", event("M8", GIVEN_BACK))


def test_a_machine_that_is_away_answers_nobody() -> None:
    blame = Blame()
    blame.begin("F1", SentAway("M8"), 10.0)
    blame.hear(60.0, "M8", "*", event("M8", LOST))


def test_a_goal_that_is_lost_for_nothing_is_noticed() -> None:
    lost = GoalLost(goal="D1-1", machine="M8", arrived=0, successor="D1-2")
    blame = Blame()
    blame.begin("F1", Crashed("M8"), 0.0)
    blame.hear(1.0, "strategist", "*", event("strategist", lost))
    with pytest.raises(InvariantBroken, match="M8 lost D1-1"):
        Blame().hear(1.0, "strategist", "*", event("strategist", lost))


def test_what_may_have_lost_a_message() -> None:
    blame = Blame()
    blame.begin("F1", LinkTrouble(sender="ATV1", loss_frac=0.3), 10.0)
    blame.begin("F2", LinkTrouble(sender="M8", latency_s=2.0, jitter_s=1.0), 10.0)
    blame.begin("F3", RadioCut("ATV1"), 10.0)
    assert blame.may_have_lost("ATV1", "M8", 20.0)
    assert not blame.may_have_lost("M8", "ATV1", 20.0)
    assert blame.delay_s(20.0) == 3.0
    blame.end("F1", 30.0)
    assert blame.may_have_lost("ATV1", "M8", 20.0)
    assert not blame.may_have_lost("ATV1", "M8", 31.0)
    blame.begin("F4", WlanCut("M8"), 40.0)
    assert blame.may_have_lost("ATV1", "M8", 41.0)
    assert not blame.may_have_lost("ATV1", "M7", 41.0)


# --- bonds -------------------------------------------------------------------------------------------

TAKEN = ContractTaken(task=TASK, epoch=1, role=Role.PRIMARY, coordinator="M8")
SILENT = AwardAnswered(task=TASK, epoch=1, role=Role.PRIMARY, bidder="ATV2", answer="silent")


class Bound:
    """ATV2 has taken a task of M8, which heard nothing of it and gave up."""

    def __init__(self) -> None:
        self.factory = SimFactory(PLANT, VirtualClock(), seed=1)
        self.blame = Blame()
        self.bonds = Bonds(self.factory, self.blame)
        for agent, fact in (("M8", opened()), ("ATV2", TAKEN), ("M8", SILENT)):
            self.say(0.0, agent, fact)

    def say(self, at_s: float, agent: str, fact: Fact) -> None:
        self.bonds.hear(at_s, agent, "*", event(agent, fact))

    def wait(self) -> None:
        for second in range(1, int(HEED_S) + 10):
            self.say(float(second), "M1", PieceMade(goal="G", product="pump-p3", made=1))


def test_whoever_holds_on_to_an_award_that_was_given_up_is_noticed() -> None:
    with pytest.raises(InvariantBroken, match=r"invariant 3 .* ATV2 believes to carry M8-1"):
        Bound().wait()


def test_whoever_lets_go_is_free() -> None:
    bound = Bound()
    ended = ContractEnded(task=TASK, epoch=1, role=Role.PRIMARY, reason="released")
    bound.say(1.0, "ATV2", ended)
    bound.wait()


def test_whoever_was_asked_again_may_keep_it() -> None:
    bound = Bound()
    given = AwardGiven(task=TASK, epoch=1, role=Role.PRIMARY, bidder="ATV2", rank=1)
    bound.say(1.0, "M8", given)
    bound.wait()


def test_a_release_may_have_been_lost() -> None:
    bound = Bound()
    bound.blame.begin("F1", LinkTrouble(receiver="ATV2", loss_frac=0.1), 0.5)
    bound.wait()


def test_a_pick_that_is_held_half_way_ends_when_the_vehicle_goes_on() -> None:
    bound = Bound()
    bound.say(0.0, "ATV2", PhaseEntered(task=TASK, epoch=1, phase=Phase.LOADING))
    vehicle = bound.factory.vehicles["ATV2"]
    vehicle.instruct(Hold())
    bound.wait()
    vehicle.instruct(Unhold())
    bound.wait()
    with pytest.raises(InvariantBroken, match=r"invariant 3 .* ATV2 believes to carry M8-1"):
        bound.say(2.0 * HEED_S + 20.0, "M1", PieceMade(goal="G", product="pump-p3", made=1))


def test_the_dead_are_bound_by_nothing() -> None:
    bound = Bound()
    bound.factory.crash("ATV2")
    bound.wait()


# --- people ------------------------------------------------------------------------------------------


def test_a_passerby_presses_all_buttons_and_puts_everything_right() -> None:
    said: list[VehicleCommand] = []
    key = SigningKey(bytes(32))
    trusted = TrustedKeys(key.public)

    def grant_of(command: VehicleCommand) -> str:
        grant = command.grant
        if grant is None:
            return "none"
        if not trusted(signed_words("ATV1", command, grant), grant.signature):
            return "forged"
        return "everywhere" if grant.everywhere else "an area"

    async def pass_by() -> None:
        network = SimNetwork(clock(), Random(1))

        def answer(sender: str, message: Message) -> None:
            assert isinstance(message, VehicleCommand)
            said.append(message)
            # Every other answer is lost.
            if len(said) % 2:
                atv.send(sender, CommandAnswered(command=message.command, done=True))

        atv = network.join("ATV1", answer)
        passerby = Passerby(
            network,
            clock(),
            key,
            fleet=("ATV1",),
            areas=("AREA1", "AREA2"),
            random=Random(1),
            grants=Random(1),
        )
        with suppress(TimeoutError):
            await asyncio.wait_for(passerby.meddle(), 3600.0)
        assert {command.kind for command in said} == set(CommandKind)
        assert len({command.command for command in said}) == len(said)
        assert {grant_of(command) for command in said} == {"none", "forged", "everywhere", "an area"}
        said.clear()
        await passerby.put_right()

    run(pass_by(), JUMP)
    assert {grant_of(command) for command in said} == {"everywhere"}
    once = list(dict.fromkeys((command.command, command.kind, command.speed_frac) for command in said))
    assert [kind for _, kind, _ in once] == [
        CommandKind.SET_SPEED,
        CommandKind.ACKNOWLEDGE,
        CommandKind.RESUME,
    ]
    assert once[0][2] == 1.0


def test_a_cancellation_is_said_until_it_is_heard() -> None:
    heard: list[str] = []

    async def regret() -> None:
        network = SimNetwork(clock(), Random(1))

        def answer(sender: str, message: Message) -> None:
            assert isinstance(message, OrderCancelled)
            heard.append(message.order)
            if heard.count(message.order) == 3:
                strategist.send(sender, CancellationTaken(order=message.order))

        strategist = network.join("strategist", answer)
        await Regret(network, clock()).cancel(((10.0, "D1"), (12.0, "D2")))

    run(regret(), JUMP)
    assert sorted(heard) == ["D1"] * 3 + ["D2"] * 3


def test_an_order_is_published_again_with_what_the_strategist_says_is_outstanding() -> None:
    said: list[Message] = []

    async def revise() -> None:
        network = SimNetwork(clock(), Random(1))

        def answer(sender: str, message: Message) -> None:
            said.append(message)
            # Every other answer is lost.
            if said.count(message) < 2:
                return
            if isinstance(message, OrderRevoked):
                strategist.send(sender, RevocationTaken("D1", message.release, (5 - message.release, 0)))
            elif isinstance(message, OrderReleased):
                strategist.send(sender, OrderTaken(order="D1", release=message.release))

        strategist = network.join("strategist", answer)
        items = (OrderItem("P1", 6), OrderItem("P2", 1))
        order = Order(id="D1", at_s=0.0, items=items, due_s=900.0)
        await Revision(network, clock()).revise((Revised(order, ((10.0, 50.0), (60.0, 70.0))),))
        assert clock().now_s() >= 70.0

    run(revise(), JUMP)
    assert list(dict.fromkeys(said)) == [
        OrderRevoked("D1", 1),
        OrderReleased("D1", (OrderItem("P1", 4), OrderItem("P2", 0)), 900.0, release=2),
        OrderRevoked("D1", 2),
        OrderReleased("D1", (OrderItem("P1", 3), OrderItem("P2", 0)), 900.0, release=3),
    ]


def test_an_order_that_was_fulfilled_when_it_is_taken_back_is_not_published_again() -> None:
    said: list[Message] = []

    async def revise() -> None:
        network = SimNetwork(clock(), Random(1))

        def answer(sender: str, message: Message) -> None:
            said.append(message)
            strategist.send(sender, RevocationTaken("D1", 1, (0,)))

        strategist = network.join("strategist", answer)
        order = Order(id="D1", at_s=0.0, items=(OrderItem("P1", 6),), due_s=900.0)
        await Revision(network, clock()).revise((Revised(order, ((10.0, 20.0), (30.0, 40.0))),))

    run(revise(), JUMP)
    assert said == [OrderRevoked("D1", 1)]


# --- stories -----------------------------------------------------------------------------------------


def test_a_story_goes_back_to_what_the_violation_names() -> None:
    story = Story()
    story.hear(1.0, "M8", ">ATV2", Release(task=TASK, epoch=1, role=Role.PRIMARY, reason="no answer"))
    story.note(2.0, "--- F1 begins: crashed (agent='ATV2')")
    for second in range(100):
        story.hear(10.0 + second, "M2", "*", event("M2", closed(f"M2-{second}")))
        story.hear(10.0 + second, "M2", "*", heartbeat("ATV2"))
    lines = story.tell("invariant 1 is broken at 200.000 s: M8-1 did not end")
    assert lines[0] == "    1.000 s  M8 to ATV2: Release task=M8-1 epoch=1 role=primary reason=no answer"
    assert lines[1] == "    2.000 s  --- F1 begins: crashed (agent='ATV2')"
    assert lines[-1].startswith("  109.000 s  M2 notes TaskClosed task=M2-99")
    assert "M2-10 " not in "".join(lines)
    assert not any("Heartbeat" in line for line in lines)


def test_a_story_tells_an_announcement_once() -> None:
    story = Story()
    announced = TaskAnnounced(
        task=TASK, epoch=1, role=Role.PRIMARY, coordinator="M8", work=WORK, deadline_s=100.0
    )
    for cell in ("1-1", "1-2", "2-1"):
        story.hear(1.0, "M8", f"plant/task/{cell}", announced)
    (line,) = story.tell("nothing")
    assert "40 x shaft to M8" in line

"""One run, played in virtual time with all invariants watched."""

from __future__ import annotations

import asyncio
from collections import Counter
from contextlib import suppress
from functools import partial
from random import Random
from typing import Protocol

from dray.adapters.system_clock import SLEW_FRAC
from dray.errors import DrayError
from dray.messages import AtvHeartbeat, Event, Message
from dray.messages.fact import TaskClosed, TookOver
from dray.messages.kinds import Kind
from dray.protocol.liveness.suspicion import IDLE_INTERVAL_S, gone_s
from dray_sim.bodies.vehicle.condition import BATTERY_EMPTY
from dray_sim.checks.bounds import Bounds
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.fault_attribution import FaultAttribution
from dray_sim.checks.floor.closed_lanes import ClosedLanes
from dray_sim.checks.floor.held_places import HeldPlaces
from dray_sim.checks.floor.obstacles import MindsObstacles
from dray_sim.checks.floor.overlaps import Overlaps
from dray_sim.checks.invariants import Invariants
from dray_sim.checks.liveness import LivenessCheck
from dray_sim.checks.parts import ReportedOnce
from dray_sim.checks.people.called import NoCallIsLost, OneTakerEach
from dray_sim.checks.people.handed_over import HandedOver
from dray_sim.checks.stale_contracts import StaleContracts
from dray_sim.checks.standing import Standing
from dray_sim.checks.waiting import NobodyWaitsInVain
from dray_sim.clock.loop import JUMP, clock
from dray_sim.clock.loop import run as run_loop
from dray_sim.controllers.wired import WiredBodies
from dray_sim.explore.bodies import (
    ASIDE_S,
    LOOKS_S,
    RESTS_S,
    check_counts,
    play_cuts,
    play_damages,
    see_to_doubts,
    uncounted,
)
from dray_sim.explore.outcome import Outcome
from dray_sim.explore.run import Run, draw
from dray_sim.explore.story import Story
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.faults import Fault, Faults, LaneBlocked, LoadDropped, describe, kind_of
from dray_sim.faults import play as let_happen
from dray_sim.insiders import BEHAVIOURS
from dray_sim.insiders.joining import INSIDER, bring_in, owner_in
from dray_sim.network.listeners import Listeners
from dray_sim.people.carriers import Carriers
from dray_sim.people.crew import hire
from dray_sim.people.floor_manager import FloorManager
from dray_sim.people.floor_office import KEPT_WITHIN_S, FloorOffice
from dray_sim.people.load_looker import LoadLooker
from dray_sim.people.operators import Operator
from dray_sim.people.order_client import OrderClient
from dray_sim.people.random.canceller import Canceller
from dray_sim.people.random.machine_meddler import MachineMeddler
from dray_sim.people.random.random_answers import NAME as AT_RANDOM
from dray_sim.people.random.random_answers import RandomAnswers
from dray_sim.people.random.random_operator import RandomOperator
from dray_sim.people.random.revoker import Revoker
from dray_sim.people.technicians import Skill, Technician, employ
from dray_sim.people.transport_caller import TransportCaller
from dray_sim.run.trace import Trace

QUICK = Skill(
    walk_s=(5.0, 30.0), other_s=(10.0, 90.0), estimate=(0.4, 1.5), promises_frac=0.7, longest_s=60.0
)
"""Runs are short, and so are repairs; some promise more than they keep."""


def try_seed(seed: int, profile: str = "all", *, traffic: bool = False) -> Outcome:
    """Play the run of a seed; one that breaks is played again to tell how it came to that.

    It never raises an error of the run: the search looks for exactly these.
    """
    run = draw(seed, profile, traffic=traffic)
    outcome = play(run)
    return play(run, listen=True) if outcome.broken else outcome


def play(run: Run, *, listen: bool = False) -> Outcome:
    """Play one run.

    Args:
        run: to be played.
        listen: keep messages for a story, and take the trace; both take a fifth more time.
    """
    game = _Game(run, listen=listen)
    try:
        run_loop(game.play(), JUMP)
    except Exception as error:  # noqa: BLE001 (the search looks for any end of a run)
        game.broken = game.broken or _in_words(error)
    return game.outcome()


class _Tally:
    """Counts the situations that a run has exercised."""

    def __init__(self) -> None:
        self.messages = self.transports = self.takeovers = 0

    def on_message(self, _at_s: float, _sender: str, _address: str, message: Message) -> None:
        self.messages += 1
        if type(message) is Event:
            fact = message.fact
            if type(fact) is TaskClosed:
                self.transports += fact.outcome == "delivered"
            elif type(fact) is TookOver:
                self.takeovers += 1


class _Diary(Faults):
    """The faults of a run, written down as they begin and end."""

    def __init__(self, world: SimFactory, attribution: FaultAttribution, story: Story | None) -> None:
        super().__init__(world)
        self.begun: Counter[str] = Counter()
        self._factory = world
        self._attribution = attribution
        self._story = story

    def begin(self, fault: Fault) -> str:
        name = super().begin(fault)
        self.begun[kind_of(fault)] += 1
        self._attribution.begin(name, fault, self._factory.clock.now_s())
        self.note(f"--- {name} begins: {describe(fault)}")
        return name

    def end(self, name: str) -> None:
        super().end(name)
        self._attribution.end(name, self._factory.clock.now_s())
        self.note(f"--- {name} ends")

    def note(self, what: str) -> None:
        """Write a line."""
        if self._story is not None:
            self._story.note(self._factory.clock.now_s(), what)


class _Powered:
    """Invariant 12: in a run without faults no vehicle runs flat. Chargers suffice there; see `small_plant`."""

    hears = (AtvHeartbeat,)

    def on_message(self, at_s: float, _sender: str, _address: str, message: Message) -> None:
        """See `dray_sim.network.listeners.Listener`.

        Raises:
            InvariantBroken: a vehicle says that its battery is empty.
        """
        if type(message) is AtvHeartbeat and message.problem == BATTERY_EMPTY:
            seen = f"{message.atv} has run flat at {message.node} though nothing had gone wrong"
            raise InvariantBroken(12, at_s, seen)


class _Meddler(Protocol):
    """A person who acts at random."""

    async def meddle(self) -> None:
        """Act until cancelled."""

    async def put_right(self) -> None:
        """Undo it; returns when everything works as before."""


class _Game:
    """A run while it is played."""

    def __init__(self, run: Run, *, listen: bool) -> None:
        self.broken = ""
        self._run = run
        self._story = Story() if listen else None
        self._trace = Trace() if listen else None
        self._tally = _Tally()
        self._ended_s = 0.0
        self._restarts = 0
        self._bodies: WiredBodies | None = None
        self._faults: Counter[str] = Counter()

    @property
    def _doubled(self) -> str:
        """The vehicle whose key somebody has; empty for none."""
        insider = self._run.insider
        return owner_in(self._run.plant) if insider and BEHAVIOURS[insider].has_key else ""

    def _factory(self, listeners: Listeners) -> SimFactory:
        run, now = self._run, clock()
        bodies = self._bodies = WiredBodies(run.plant, now, aside_s=ASIDE_S) if run.wired else None
        factory = SimFactory(
            run.plant,
            now,
            seed=run.seed,
            stock_frac=run.stock_frac,
            codec=run.codec,
            listener=listeners,
            traffic=run.traffic,
            strategists=run.strategists,
            bodies=bodies,
        )
        if bodies is not None:
            factory.arrived = bodies.arrived
            bodies.runs = factory.running
        return factory

    async def play(self) -> None:
        """Run it to its end."""
        run, listeners = self._run, Listeners()
        factory = self._factory(listeners)
        # A thief of another agent's name must change nothing for its owner.
        liar = INSIDER if run.insider and not BEHAVIOURS[run.insider].is_thief else ""
        attribution, liveness = (
            FaultAttribution(run.plant.fleet, factory.strategists),
            LivenessCheck(Bounds(run.plant, run.habits), liar),
        )
        checks = Invariants(
            factory,
            attribution,
            StaleContracts(factory, attribution),
            Standing(attribution),
            NobodyWaitsInVain(attribution, tuple(run.plant.stores)),
            liveness,
            HandedOver(attribution),
        )
        checks.add(ReportedOnce(factory, liar))
        for unsound in filter(None, (liar, self._doubled)):
            attribution.distrust(unsound)
        people: tuple[Operator, ...] = ()
        technicians: tuple[Technician, ...] = ()
        office = None
        if run.traffic:
            office = FloorOffice(factory.bus, factory.clock, factory.keys, factory.authority)
        if run.habits is not None:
            people = hire(factory, seed=run.seed, habits=run.habits, office=office)
            technicians = employ(factory, seed=run.seed, skill=QUICK)
        crew: tuple[Operator | Technician, ...] = (*people, *technicians)
        checks.add(OneTakerEach(person.duty for person in crew))
        checks.add(NoCallIsLost(lambda agent: agent == liar))
        if run.closings:
            attribution.restrict(max(each.until_s for each in run.closings))
            checks.add(ClosedLanes(factory))
        if run.cuts or run.damages:
            attribution.restrict(run.bodies_until_s)
        in_the_way = any(isinstance(timed.fault, LaneBlocked | LoadDropped) for timed in run.schedule)
        if in_the_way or factory.plant.doors:
            checks.add(MindsObstacles(factory))
        faults = _Diary(factory, attribution, self._story)
        self._faults = faults.begun
        let_happen(run.schedule, faults)
        if not run.has_faults:
            checks.add(_Powered())
        if run.traffic:
            checks.add(HeldPlaces(factory))
            checks.add(Overlaps(factory.vehicles))
        looker = LoadLooker(
            factory.bus, factory.clock, factory.authority, partial(uncounted, factory, self._bodies)
        )
        listeners.add(
            looker,
            *(listener for listener in (self._story, self._trace) if listener is not None),
            self._tally,
            checks,
        )
        life = asyncio.create_task(self._live(factory, faults, office, crew, looker))
        broken = asyncio.create_task(checks.wait_broken())
        end = asyncio.create_task(self._await_end(factory, liveness, looker))
        try:
            await asyncio.wait(
                {life, broken, end}, timeout=self._run.longest_s, return_when=asyncio.FIRST_COMPLETED
            )
            checks.check_end(factory.clock.now_s())
            self.broken = self._verdict(checks, life, end)
        finally:
            self._ended_s = factory.clock.now_s()
            self._restarts = sum(journal.incarnation - 1 for journal in factory.journals.values())
            for task in (life, broken, end):
                task.cancel()
            await asyncio.gather(life, broken, end, return_exceptions=True)

    def outcome(self) -> Outcome:
        return Outcome(
            seed=self._run.seed,
            profile=self._run.profile,
            traffic=self._run.traffic,
            broken=self.broken,
            duration_s=self._ended_s,
            transports=self._tally.transports,
            takeovers=self._tally.takeovers,
            restarts=self._restarts,
            messages=self._tally.messages,
            faults=dict(sorted(self._faults.items())),
            trace=self._trace.hexdigest() if self._trace is not None else "",
            story=self._story.tell(self.broken) if self._story is not None and self.broken else (),
        )

    async def _live(
        self,
        factory: SimFactory,
        faults: _Diary,
        office: FloorOffice | None,
        crew: tuple[Operator | Technician, ...],
        looker: LoadLooker,
    ) -> None:
        run = self._run
        async with asyncio.TaskGroup() as group:
            group.create_task(factory.run())
            group.create_task(looker.run())
            self._ask_for_work(factory, group)
            if run.closings:
                manager = FloorManager(factory.bus, factory.clock, factory.keys, factory.authority)
                group.create_task(manager.close(run.closings))
            if office is not None:
                group.create_task(office.run())
                carriers = Carriers(factory, faults, office)
                group.create_task(carriers.carry(run.carryings))
                if run.carryings:
                    careless = Random(f"{run.seed} careless")
                    group.create_task(carriers.say_carelessly(careless, run.faults_until_s))
            for person in crew:
                group.create_task(person.run())
            if run.random_answers:
                group.create_task(self._answer_at_random(factory))
            if run.random_operator:
                group.create_task(self._press_at_random(factory))
                group.create_task(self._meddle_with_machines(factory))
            if run.insider:
                group.create_task(self._lie(factory, office))
            if self._bodies is not None:
                group.create_task(play_cuts(run.cuts, factory, self._bodies, faults.note))
                group.create_task(play_damages(run.damages, factory, self._bodies, faults, faults.note))
                group.create_task(see_to_doubts(self._bodies))

    def _ask_for_work(self, factory: SimFactory, group: asyncio.TaskGroup) -> None:
        """Customers order, and think again; people have something brought."""
        run, bus, now, whom = self._run, factory.bus, factory.clock, factory.strategists
        group.create_task(OrderClient(bus, now, whom).place(run.orders))
        if run.cancelled:
            group.create_task(Canceller(bus, now, whom).cancel(run.cancelled))
        if run.revocations:
            group.create_task(Revoker(bus, now, whom, run.cancelled).revoke(run.revocations))
        if run.calls:
            group.create_task(TransportCaller(bus, now).call(run.calls))

    async def _lie(self, factory: SimFactory, office: FloorOffice | None) -> None:
        """Let an insider lie to the end: in the quiet phase, too, all open work must end.

        An insider that claims floor is sent away before: people have seen which vehicle holds it, and a person's word
        frees it. They say it anew from time to time, because a machine that has heard the insider since refuses the
        first word for good. One with a vehicle's key is sent away, too: the vehicle would stand.
        """
        behaviour = BEHAVIOURS[self._run.insider]
        lies = bring_in(factory, behaviour).run()
        if office is None or not (behaviour.claims_floor or behaviour.has_key):
            await lies
            return
        with suppress(TimeoutError):
            await asyncio.wait_for(lies, self._run.faults_until_s - gone_s(IDLE_INTERVAL_S))
        if behaviour.has_key:
            return
        await asyncio.sleep(gone_s(IDLE_INTERVAL_S))
        while True:
            office.carry_away(INSIDER)
            await asyncio.sleep(KEPT_WITHIN_S)

    async def _until_quiet(self, meddler: _Meddler) -> None:
        """Let somebody meddle until the quiet phase, and then put everything right."""
        try:
            await asyncio.wait_for(meddler.meddle(), self._run.faults_until_s)
        except TimeoutError:
            await meddler.put_right()

    async def _press_at_random(self, factory: SimFactory) -> None:
        run = self._run
        random_operator = RandomOperator(
            factory.bus,
            factory.clock,
            factory.authority,
            fleet=tuple(run.plant.fleet),
            areas=tuple(run.plant.areas),
            random=Random(f"{run.seed} passerby"),
            grants=Random(f"{run.seed} passerby's grants"),
        )
        await self._until_quiet(random_operator)

    async def _answer_at_random(self, factory: SimFactory) -> None:
        run = self._run
        random = Random(f"{run.seed} answers at random")
        answers = RandomAnswers(factory.bus, factory.clock, factory.keys, random)
        factory.bus.kinds[AT_RANDOM] = Kind.OPERATOR
        await self._until_quiet(answers)

    async def _meddle_with_machines(self, factory: SimFactory) -> None:
        run = self._run
        meddler = MachineMeddler(
            factory.bus,
            factory.clock,
            factory.authority,
            machines=tuple(run.plant.machines),
            areas=tuple(run.plant.areas),
            random=Random(f"{run.seed} meddler"),
        )
        await self._until_quiet(meddler)

    async def _await_end(self, factory: SimFactory, liveness: LivenessCheck, looker: LoadLooker) -> None:
        """Wait until the faults are over, the quiet phase has passed, and no work is open any more."""
        await asyncio.sleep(self._run.faults_until_s)
        # Times of a clock that was set are wrong until it is steered back.
        await asyncio.sleep(factory.clock_error_s() / SLEW_FRAC)
        liveness.start(factory.clock.now_s())
        await asyncio.sleep(self._run.duration_s - self._run.faults_until_s)
        await liveness.over.wait()
        if self._bodies is not None:
            await asyncio.sleep(RESTS_S)
            while looker.is_asked:  # noqa: ASYNC110 - virtual time passes at once
                await asyncio.sleep(LOOKS_S)
            check_counts(factory, self._bodies, factory.clock.now_s())

    def _verdict(self, checks: Invariants, life: asyncio.Task[None], end: asyncio.Task[None]) -> str:
        if checks.broken is not None:
            return str(checks.broken)
        for task in (life, end):
            if task.done() and (error := task.exception()) is not None:
                return _in_words(error)
        return "" if end.done() else f"the quiet phase has not ended after {self._run.longest_s:.0f} s"


def _in_words(error: BaseException) -> str:
    while isinstance(error, BaseExceptionGroup):
        error = error.exceptions[0]
    where = error.__traceback__
    while where is not None and where.tb_next is not None:
        where = where.tb_next
    place = (
        ""
        if where is None
        else f" ({where.tb_frame.f_code.co_filename.rpartition('/')[2]}:{where.tb_lineno})"
    )
    what = str(error) if isinstance(error, DrayError) else repr(error)
    return f"invariant 8 is broken: ended by {what}{place}"

"""A lean vehicle: a body that moves, and a row of transports. The scheme decides how it gets its way."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from dray.body import Drive, Instruction, ReleaseWay
from dray.errors import ProtocolViolation
from dray.plant import Plant
from dray.plant.model import VehicleType
from dray_sim.bench.traffic.clock import LeanClock
from dray_sim.bench.traffic.jobs import HANDLING_S, Job
from dray_sim.bodies.vehicle.travel import NEVER_S, Travel


class Work(Protocol):
    """A source of transports."""

    def next(self, atv: str, now_s: float) -> Job | None: ...

    def start(self, clock: LeanClock, wake: Callable[[], None]) -> None: ...


class Pilot(Protocol):
    """How a vehicle gets to a node: a scheme of right of way."""

    def go(self, node: str, *, idle: bool) -> None:
        """Drive there; `Carrier.arrive` is called there, at once when it stands there."""

    def dock(self) -> None:
        """Stay while it loads or unloads."""

    def rest(self) -> None:
        """There is nothing to do."""

    def passed(self, node: str) -> None:
        """The next node was reached."""


class Carrier:
    """One vehicle.

    Args:
        atv: its name.
        plant, vehicle_type: its roads and what it can do.
        node: where it stands.
        home: where it goes when there is nothing to do; empty for nowhere.
        work: its transports.
        clock: of the world.

    Attributes:
        travel: where it is.
        pilot: drives it; set by the code that makes the carrier.
        done: transports: (when they were done, how long they took).
        stood_since_s: since when it stands and has somewhere to go; None when it moves, handles or is idle.
        dead: it stands where it is, and does nothing.
    """

    def __init__(
        self,
        atv: str,
        plant: Plant,
        vehicle_type: VehicleType,
        node: str,
        home: str,
        work: Work,
        clock: LeanClock,
    ) -> None:
        self.atv = atv
        self.kind = vehicle_type
        self.travel = Travel(plant, vehicle_type, node, clock.now_s)
        self.pilot: Pilot
        self.done: list[tuple[float, float]] = []
        self.stands: list[tuple[float, float]] = []
        self.stood_since_s: float | None = None
        self.dead = False
        self.handles = False
        self._plant = plant
        self._home = home
        self._work = work
        self._clock = clock
        self._job: Job | None = None
        self._loaded = False
        self._legs: list[str] = []
        self._turn = 0

    # --- the body --------------------------------------------------------------------------------

    def instruct(self, instruction: Instruction) -> None:
        """Drive, or drive on.

        Raises:
            ProtocolViolation: the body cannot.
        """
        now_s = self._clock.now_s
        if isinstance(instruction, Drive):
            why = self.travel.drive(instruction.order, instruction.nodes, instruction.released, now_s)
            if why:
                raise ProtocolViolation(f"{self.atv} at {self.travel.node}: {why}: {instruction}")
        elif isinstance(instruction, ReleaseWay):
            self.travel.release(instruction.order, instruction.released, now_s)
        self.watch()

    def watch(self) -> None:
        """Look for the next node when it is reached."""
        self._turn += 1
        when_s = self.travel.next_at_s
        if when_s < NEVER_S and not self.dead:
            self._clock.call_at(when_s, self._reach, self._turn)
        self.mark()

    def _reach(self, turn: int) -> None:
        if turn != self._turn or self.dead:
            return
        now_s = self._clock.now_s
        self.travel.arrive()
        self.travel.finish(now_s)
        self.watch()
        self.pilot.passed(self.travel.node)

    def sense(self) -> tuple[float, float]:
        """Distance past its last node (m), and speed (m/s)."""
        now_s = self._clock.now_s
        if self.travel.way is None:
            return 0.0, 0.0
        pose = self.travel.pose(now_s)
        node = self._plant.nodes[self.travel.node]
        past_m = ((pose.x_m - node.x_m) ** 2 + (pose.y_m - node.y_m) ** 2) ** 0.5
        return past_m, self.travel.motion(now_s)[1]

    def die(self) -> None:
        """Stop where it is, for good or until `revive`."""
        self.dead = True
        self.travel.stop_dead(self._clock.now_s)
        self._turn += 1

    def revive(self) -> None:
        """Go on."""
        self.dead = False
        self.travel.go_on(self._clock.now_s)
        self.watch()

    def mark(self) -> None:
        """Note whether it stands though it has somewhere to go."""
        now_s = self._clock.now_s
        waits = (
            self._job is not None and not self.handles and not self.dead and self.travel.next_at_s == NEVER_S
        )
        if not waits and self.stood_since_s is not None:
            if now_s - self.stood_since_s > 1.0:
                self.stands.append((self.stood_since_s, now_s))
            self.stood_since_s = None
        elif waits and self.stood_since_s is None:
            self.stood_since_s = now_s

    # --- the work --------------------------------------------------------------------------------

    @property
    def idle(self) -> bool:
        """Whether it has no transport."""
        return self._job is None

    @property
    def leg_goal(self) -> str:
        """The goal of its present leg; empty when it is idle or handles."""
        if self._job is None or self.handles:
            return ""
        return self._job.goal if self._loaded else self._job.source

    def ask_for_work(self) -> None:
        """Begin the next transport, if there is one and it has none."""
        if self._job is not None or self.dead:
            return
        job = self._work.next(self.atv, self._clock.now_s)
        if job is None:
            return
        self._job, self._loaded = job, False
        self.mark()
        self.pilot.go(job.source, idle=False)

    def arrive(self) -> None:
        """It stands at the node that it was sent to."""
        if self._job is None:
            self.pilot.rest()
            return
        if self.handles:
            return
        self.handles = True
        self.mark()
        self.pilot.dock()
        self._clock.call_at(self._clock.now_s + HANDLING_S, self._handled)

    def _handled(self) -> None:
        if self.dead:
            self._clock.call_at(self._clock.now_s + 1.0, self._handled)
            return
        job = self._job
        if job is None:
            return
        self.handles = False
        if not self._loaded:
            self._loaded = True
            self.mark()
            self.pilot.go(job.goal, idle=False)
            return
        now_s = self._clock.now_s
        self.done.append((now_s, now_s - job.since_s))
        self._job = None
        self.mark()
        self.ask_for_work()
        if self._job is None:
            if self._home:
                self.pilot.go(self._home, idle=True)
            else:
                self.pilot.rest()

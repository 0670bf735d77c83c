"""Commissioning: it tries all that the agent will need of a vehicle, and records each step.

The first steps only listen: nothing moves without being asked for. The findings become a profile.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass, field
from math import hypot

import msgspec

from dray.adapters.commissioning_step import Step
from dray.adapters.vda5050.body import VehicleBody
from dray.adapters.vda5050.control.factsheet import differences
from dray.adapters.vda5050.control.view import NEVER_S
from dray.adapters.vda5050.map_fit import described, fitting
from dray.adapters.vda5050.profile import Profile, write_profile
from dray.body import (
    ActionDone,
    ActionFailed,
    Drive,
    Drop,
    Hold,
    Pick,
    Report,
    Unhold,
    VehicleInstruction,
    VehicleState,
    WayDone,
)
from dray.plant import Plant
from dray.plant.model import MapFrame, VehicleType
from dray.ports import Clock

LOOK_S = 0.2

FIRST_STATE_S = 65.0
"""Timeout of the first state: the standard says 30 s; this is twice that, and a little."""

FACTSHEET_S = 10.0
DRIVE_S = 300.0
"""Longest wait for one lane."""

ACT_S = 600.0
STAND_S = 10.0


@dataclass(frozen=True, slots=True)
class Wanted:
    """The extent of a commissioning.

    Attributes:
        drive: the neighbouring node to which the vehicle may move, and back; empty for any; None for no movement.
        station: the station for a pick and a drop; empty for none. The vehicle must stand there, or `drive` must lead there.
        item: the item to pick.
        quantity: the pieces to pick.
    """

    drive: str | None = None
    station: str = ""
    item: str = ""
    quantity: int = 1


@dataclass
class Commissioning:
    """The commissioning of one vehicle.

    Args:
        body: its body, linked now or later.
        plant: its plant.
        kind: its type in the plant file.
        profile: the profile used.
        clock: the plant's.
        wanted: the extent.

    Attributes:
        steps: the results so far.
    """

    body: VehicleBody
    plant: Plant
    kind: VehicleType
    profile: Profile
    clock: Clock
    wanted: Wanted
    steps: list[Step] = field(default_factory=list)
    _heard: list[Report] = field(default_factory=list)
    _order: int = 0

    async def run(self) -> AsyncIterator[Step]:
        """Run all steps; a failed step on which others depend ends them."""
        self.body.attach(self._heard.append)
        for step in (self._listen, self._state, self._factsheet, self._names, self._position, self._ready):
            self.steps.append(await step())
            yield self.steps[-1]
            if self.steps[-1].passed is False and step not in (self._factsheet, self._names):
                return
        moves = (self._drive, self._pause, self._back, self._cancel)
        for step in (*moves, self._pick, self._drop):
            if self.wanted.drive is None and step in moves:
                self.steps.append(
                    Step(step.__name__.strip("_"), None, "left out: give --drive, and it moves")
                )
            elif not self.wanted.station and step in (self._pick, self._drop):
                self.steps.append(Step(step.__name__.strip("_"), None, "left out: give --station and --item"))
            else:
                self.steps.append(await step())
            yield self.steps[-1]
            if self.steps[-1].passed is False and step is self._drive:
                return

    @property
    def passed(self) -> bool:
        """Whether no step has failed."""
        return bool(self.steps) and all(step.passed is not False for step in self.steps)

    def suggested(self) -> Profile:
        """The profile used, with the findings about the vehicle."""
        view = self.body.control.view
        changes: dict[str, object] = {}
        if view.heard_s != NEVER_S and view.state.loads is None:
            changes["load"] = "none"
        if (fit := self._fit()) is not None and not view.names.knows_map(view.map_id):
            changes["map"] = fit
        elif fit is not None:
            others = [frame for frame in self.profile.maps if frame.id != fit.id]
            changes["maps"] = (*others, fit)
        elif view.map_id and not self.profile.map.id and not view.names.frames:
            changes["map"] = msgspec.structs.replace(self.profile.map, id=view.map_id)
        # The vehicle reports a topic that it could not read: the list has another name in 1.1.
        if any(error.names("instantActions") for error in view.state.errors or ()):
            changes["instant_actions"] = "instantActions"
        if self.body.control.view.battery.looks_like_fraction:
            changes["battery_scale"] = "fraction"
        if self.body.control.needs_node_twice:
            changes["action_node_twice"] = True
        return msgspec.structs.replace(self.profile, **changes)

    def report(self) -> str:
        """The whole report, in Markdown."""
        address = self.body.address
        odd = [f"- {count} times {reason}" for reason, count in self.body.control.view.odd.items()]
        return "\n".join(
            [
                f"# {address.manufacturer} {address.serial}, VDA 5050 {self.profile.version}",
                "",
                *(f"    {step.line}" for step in self.steps),
                "",
                "Ignored of what it said:" if odd else "Nothing of what it said was ignored.",
                *odd,
                "",
                "The profile that this suggests, beside the defaults:",
                "",
                *(f"    {line}" for line in write_profile(self.suggested()).splitlines()),
                "",
            ]
        )

    # --- steps that listen -----------------------------------------------------------------------

    async def _listen(self) -> Step:
        begun_s = self.clock.now_s()
        linked = await self._until(lambda: self.body.control.is_linked, FIRST_STATE_S)
        if not linked:
            return Step("connection", False, self.body.control.why_unknown)
        return Step("connection", True, f"the broker answers after {self.clock.now_s() - begun_s:.1f} s")

    async def _state(self) -> Step:
        begun_s, view = self.clock.now_s(), self.body.control.view
        if not await self._until(lambda: view.heard_s != NEVER_S, FIRST_STATE_S):
            return Step(
                "state", False, f"{self.body.control.why_unknown}; see its manufacturer and serial number"
            )
        level = f"battery {100 * view.battery_frac:.0f} %"
        if view.battery.unknown:
            level = f"battery not known: {view.battery.unknown}"
        return Step("state", True, f"the first one after {self.clock.now_s() - begun_s:.1f} s, {level}")

    async def _factsheet(self) -> Step:
        view = self.body.control.view
        if not await self._until(lambda: view.factsheet is not None, FACTSHEET_S) or view.factsheet is None:
            return Step(
                "factsheet", None, "none was told: compare speed and size with the plant file yourself"
            )
        found = differences(view.factsheet, self.kind, self.profile)
        return Step("factsheet", not found, "; ".join(found) or "as the plant file has it")

    async def _names(self) -> Step:
        """Check that the plant has the vehicle's map and last node, and the names in its profile."""
        view = self.body.control.view
        names, said = view.names, view.said_node
        found = [f"its profile names {name}, which the plant does not have" for name in names.strangers]
        known = [name for name in names.frames if name]
        position = view.state.position
        map_id = (position.map_id if position is not None else "") or ""
        if map_id and known and map_id not in known:
            found.append(
                f"it is on map {map_id}; plant file and profile have {', '.join(known)}: write it there"
            )
        node = view.state.last_node_id
        if said and node is None:
            found.append(f"its last node {said} is on several maps, and it does not say on which one it is")
        elif said and node not in self.plant.nodes:
            found.append(
                f"its last node is {said}, and no node of the plant is called so: write it as one of its `originals`, "
                "or in `names` of the profile"
            )
        if found:
            return Step("names", False, "; ".join(found))
        if not said:
            return Step("names", None, "it names no node: compare its ids with the plant file yourself")
        called = f", which it calls {said}" if said != node else ""
        return Step("names", True, f"its last node is {node}{called}{f', on map {map_id}' if map_id else ''}")

    def _fit(self) -> MapFrame | None:
        """The map frame that would put the vehicle at its reported node; None where the present one does."""
        view = self.body.control.view
        spot, position = self.plant.nodes.get(view.state.last_node_id or ""), view.state.position
        frame = view.names.frame(view.map_id)
        if spot is None or position is None or position.x is None or position.y is None or frame is None:
            return None
        frame = msgspec.structs.replace(frame, id=view.map_id)
        return fitting([(position.x, position.y, spot.x_m, spot.y_m)], frame, self._near_m)

    @property
    def _near_m(self) -> float:
        """Maximum distance to its last node; larger where it reports having left it."""
        return self.profile.node_m + (self.body.control.view.driven_m or 0.0)

    def _advice(self) -> str:
        fit, node = self._fit(), self.body.control.view.state.last_node_id
        return f"; with {described(fit)} it would stand at its last node {node}" if fit is not None else ""

    async def _position(self) -> Step:
        if not await self._until(lambda: self.body.control.is_known, FACTSHEET_S):
            return Step("position", False, self.body.control.why_unknown + self._advice())
        state = self._sensed()
        pose = f"({state.pose.x_m:.2f}, {state.pose.y_m:.2f})"
        spot = self.plant.nodes[state.node]
        off_m = hypot(spot.x_m - state.pose.x_m, spot.y_m - state.pose.y_m)
        where = (
            f"at {state.node}"
            if state.next_node == state.node
            else f"between {state.node} and {state.next_node}"
        )
        seen = f"{pose} is {where}, {off_m:.2f} m from {state.node}{self._advice()}"
        return Step("position", True, seen)

    async def _ready(self) -> Step:
        state = self._sensed()
        if state.problem:
            return Step("ready", False, state.problem)
        return Step("ready", True, "AUTOMATIC, localised, nothing keeps it from going on")

    # --- steps that move -------------------------------------------------------------------------

    async def _drive(self) -> Step:
        state = self._sensed()
        self._home = state.node
        goals = self._neighbours(state.node)
        goal = self._goal = self.wanted.drive or (goals[0] if goals else "")
        if state.next_node != state.node or goal not in goals:
            return Step(
                "drive",
                False,
                f"no lane leads from {state.node} to {goal or 'anywhere'}: choose one of {goals}",
            )
        return await self._go("drive", state.node, goal)

    async def _pause(self) -> Step:
        """Pause on the way back, if there is one; the step ends where the vehicle stands."""
        state = self._sensed()
        if self._home not in self._neighbours(state.node):
            return Step("pause", None, f"left out: no lane leads back to {self._home}")
        self._drive_to(state.node, self._home)
        if not await self._until(lambda: self._sensed().speed_mps > 0.1, DRIVE_S):
            return Step("pause", False, "it did not set off")
        begun_s = self.clock.now_s()
        self._instruct(Hold())
        stood = await self._until(lambda: not self.body.control.view.is_moving, STAND_S)
        took_s = self.clock.now_s() - begun_s
        await asyncio.sleep(STAND_S)
        moves = self.body.control.view.is_moving
        self._instruct(Unhold())
        if not stood or moves:
            return Step(
                "pause", False, "it moves although it was told to stand; try a profile with pause: false"
            )
        return Step("pause", True, f"it stands {took_s:.1f} s after it was told so")

    async def _back(self) -> Step:
        if not self._order or self._home == self._sensed().node:
            return Step("back", None, "left out")
        begun_s = self.clock.now_s()
        if await self._until(self._is_over, DRIVE_S) and not self._failure():
            return Step("back", True, f"at {self._home} again after {self.clock.now_s() - begun_s:.1f} s")
        return Step("back", False, self._failure() or f"not at {self._home} after {DRIVE_S:.0f} s")

    async def _cancel(self) -> Step:
        """Cancel on the way out again: the vehicle stands where it is, goes on from there, and comes back."""
        home, goal, control = self._sensed().node, self._goal, self.body.control
        if home != self._home:
            return Step("cancel", None, f"left out: it is not at {self._home} again")
        self._drive_to(home, goal)
        if not await self._until(lambda: self._sensed().speed_mps > 0.1 or self._is_over(), DRIVE_S):
            return Step("cancel", False, "it did not set off")
        begun_s, before = self.clock.now_s(), control.cancelled
        self.body.cancel()
        await self._until(
            lambda: control.cancelled > before or self._is_over() or bool(self._sensed().problem), ACT_S
        )
        if control.cancelled == before:
            reason = (
                "it arrived before it could be cancelled" if self._is_over() else "cancelOrder does not end"
            )
            return Step("cancel", False, self._failure() or self._sensed().problem or reason)
        took_s, pose, spot = self.clock.now_s() - begun_s, self._sensed().pose, self.plant.nodes[goal]
        left_m = hypot(spot.x_m - pose.x_m, spot.y_m - pose.y_m)
        if not await self._until(self._is_over, DRIVE_S) or self._failure():
            return Step(
                "cancel", False, self._failure() or f"it does not go on to {goal} from where it stands"
            )
        back = await self._go("cancel", goal, home)
        if not back.passed:
            return back
        seen = (
            f"cancelled after {took_s:.1f} s, {left_m:.1f} m before {goal}; it went on from there, and back"
        )
        return Step("cancel", True, seen)

    async def _pick(self) -> Step:
        want = self.wanted
        return await self._act(
            "pick", Pick(order=self._next(), station=want.station, item=want.item, quantity=want.quantity)
        )

    async def _drop(self) -> Step:
        return await self._act("drop", Drop(order=self._next(), station=self.wanted.station))

    # --- how it is done --------------------------------------------------------------------------

    async def _go(self, name: str, start: str, goal: str) -> Step:
        begun_s = self.clock.now_s()
        self._drive_to(start, goal)
        if not await self._until(self._is_over, DRIVE_S):
            return Step(name, False, self._overdue(f"not at {goal} after {DRIVE_S:.0f} s"))
        if failure := self._failure():
            return Step(name, False, failure)
        return Step(name, True, f"from {start} to {goal} in {self.clock.now_s() - begun_s:.1f} s")

    async def _act(self, name: str, task: Pick | Drop) -> Step:
        begun_s = self.clock.now_s()
        self._instruct(task)
        if not await self._until(self._is_over, ACT_S):
            return Step(name, False, self._overdue(f"not done after {ACT_S:.0f} s"))
        if failure := self._failure():
            return Step(name, False, failure)
        twice = "; its node had to be listed twice" if self.body.control.needs_node_twice else ""
        return Step(name, True, f"{self.clock.now_s() - begun_s:.1f} s{twice}")

    def _overdue(self, what: str) -> str:
        """The reason why a step has not ended in time: the vehicle's problem, or else what it waits for."""
        waits = self.body.control.waits_for(self.clock.now_s())
        return self._sensed().problem or (f"{what}: {waits}" if waits else what)

    def _neighbours(self, node: str) -> list[str]:
        """The nodes at the ends of a node's lanes; corners of lanes are no destinations."""
        ends = [lane.end for lane in self.plant.roads.leaving[node]]
        bent = [end for start, end in self.plant.corners if start == node]
        return [*(end for end in ends if end not in self._corners), *bent]

    @property
    def _corners(self) -> set[str]:
        return {corner for chain in self.plant.corners.values() for corner in chain}

    def _drive_to(self, start: str, goal: str) -> None:
        nodes = (start, *self.plant.corners.get((start, goal), ()), goal)
        self._instruct(Drive(order=self._next(), nodes=nodes, released=len(nodes)))

    def _instruct(self, instruction: VehicleInstruction) -> None:
        self.body.instruct(instruction)

    def _sensed(self) -> VehicleState:
        return self.body.control.sense()

    def _next(self) -> int:
        self._order += 1
        return self._order

    def _is_over(self) -> bool:
        ends = (WayDone, ActionDone, ActionFailed)
        return any(isinstance(report, ends) and report.order == self._order for report in self._heard)

    def _failure(self) -> str:
        failed = (
            report
            for report in self._heard
            if isinstance(report, ActionFailed) and report.order == self._order
        )
        return next((report.reason for report in failed), "")

    async def _until(self, holds: Callable[[], bool], within_s: float) -> bool:
        """Poll until a condition holds or the time is over (plant clock)."""
        ends_s = self.clock.now_s() + within_s
        while not holds():
            if self.clock.now_s() >= ends_s:
                return False
            await asyncio.sleep(LOOK_S)
        return True

    _home: str = ""
    _goal: str = ""

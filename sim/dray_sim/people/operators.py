"""People on the floor: operators who look after the vehicles of their area (paper, cases 4 and 5).

An operator has a tablet that shows the vehicles' heartbeats, two legs and two hands, and does one thing at a time. An
operator's knowledge comes only from heartbeats and from inspection on the spot. An operator's orders to vehicles are
ordinary commands, which are repeated until they are answered. The speed of people is random, from a generator of each
operator's own.

    call       react -> take -> as for a problem
    problem    react -> promise -> walk -> mend
    shifted    react -> promise -> walk -> STOP -> mend -> slow down -> ACKNOWLEDGE -> RESUME
    no WLAN    once it has delivered, or calls: react -> take -> walk -> plug in
    silence    react -> walk -> carry the load away -> push it to a charger -> switch it on
    goods      their machine calls: react -> take -> as for silence

After an interruption, as by a vehicle that falls silent, an operator remembers own stops and ends them when the
vehicle is heard again. A vehicle obeys an operator in the operator's own area only. So work on a vehicle that has
driven into another area is left to the colleague there.
"""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from random import Random

from dray.adapters.security.signing import SigningKey
from dray.body import ShownCall
from dray.messages import AtvStatus, CallAnswer, CommandKind, Link
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.plant.people import people_of
from dray.ports import Bus, Clock
from dray.protocol.vehicle.people.command_handling import ALONE, DENIED, DOUBLED
from dray_sim.bodies.vehicle.condition import LOAD_SHIFTED
from dray_sim.people.areas import EVERYWHERE, area_at
from dray_sim.people.duty import CALLED, OWN, Duty, PersonOnDuty
from dray_sim.people.floor_office import FloorOffice
from dray_sim.people.habits import Habits, Range
from dray_sim.people.hands import Hands
from dray_sim.people.loads import Loads
from dray_sim.people.tablet import LastHeard, Tablet

LATEST_S = 10.0
"""Longest transit time of a heartbeat."""

LOOK_S = 5.0
"""Interval between two glances at the tablet."""


class Operator:
    """One person, who is responsible for one area and joins the bus as `operator-<area>`.

    Invariants: a command is given only after the answer to the one before it. Every stop of an operator is followed
    by an acknowledge and a resume as soon as the vehicle hears it. They come from the same operator, or from the one
    in whose area the vehicle has come to stand.

    Args:
        area: responsible for the vehicles in it; `EVERYWHERE` for all of them.
        plant: where areas are.
        bus: joined while `run` runs.
        clock: the plant's clock.
        authority: grants this person's commands.
        hands: for manual work.
        random: the source of chance of this person's life.
        habits: how this person works.
        office: reports carried vehicles, where they drive with right of way; else no report is needed.
        careless: the source of chance for this person's lapses.

    Attributes:
        name: on the bus.
        duty: the person's state on the bus, and the calls.
        done: how often which duty was done.
        loads: handles the loads of dead vehicles.
        colleagues: all operators of the plant, by area, this one too.
    """

    def __init__(
        self,
        area: str,
        *,
        plant: Plant,
        bus: Bus,
        clock: Clock,
        authority: SigningKey,
        hands: Hands,
        random: Random,
        habits: Habits,
        office: FloorOffice | None = None,
        careless: Random | None = None,
    ) -> None:
        self.name = f"operator-{area}"
        self.done = dict.fromkeys(Duty, 0)
        self.colleagues: Mapping[str, Operator] = {area: self}
        self._area = area
        self._plant = plant
        self._clock = clock
        self._hands = hands
        self._random = random
        self._habits = habits
        self._office = office
        own = None if area == EVERYWHERE else (area,)
        keys, machines = Keys(plant.id), plant.machines
        self._tablet = Tablet(self.name, own, keys=keys, bus=bus, clock=clock, authority=authority)
        self.duty = PersonOnDuty(
            area,
            own,
            keys=keys,
            bus=bus,
            clock=clock,
            looks_after=lambda call: bool(call.goods) or call.caller not in machines,
            hours=people_of(plant, area),
        )
        self._careless = careless or Random(self.name)
        self.loads = Loads(hands, self._tablet, plant, clock, habits, random, self._careless)
        self._heard = self._tablet.heard
        """Last heartbeats of the vehicles."""
        self._stops: dict[str, float] = {}
        """Vehicles that a stop of this person may hold, and since when."""
        self._mesh_s: dict[str, float] = {}
        """Since when vehicles are heard by radio only; infinity after a repair in vain."""
        self._slowed: dict[str, float] = {}
        """Vehicles with a speed limit of this person's, and until when."""

    def look_after_stop(self, atv: str, since_s: float) -> None:
        """Release a vehicle that one's own or a colleague's stop may hold since then."""
        self._stops[atv] = since_s

    def look_after_limit(self, atv: str, until_s: float) -> None:
        """Let a vehicle that is slow by one's own or a colleague's word drive on as before, after then."""
        self._slowed[atv] = until_s

    async def run(self) -> None:
        """Work until cancelled."""
        with self._tablet.on():
            async with asyncio.TaskGroup() as group:
                group.create_task(self.duty.run())
                group.create_task(self._come_and_go())
                group.create_task(self._look())

    async def _come_and_go(self) -> None:
        """Be on duty for some time and then not, some of the times without a word."""
        habits, draw = self._habits, self._careless
        while habits.on_duty_s is not None:
            await asyncio.sleep(draw.uniform(*habits.on_duty_s))
            if self._clock.now_s() >= habits.careless_until_s:
                return
            tells = draw.random() < 0.5
            (self.duty.go if tells else self.duty.lose_tablet)()
            await asyncio.sleep(draw.uniform(*habits.off_duty_s))
            (self.duty.come if tells else self.duty.have_tablet)()
            if not self.duty.is_at_work:
                self.duty.go()

    async def _look(self) -> None:
        """Look at the alarms, and work on one at a time."""
        while True:
            await asyncio.sleep(LOOK_S)
            alarm = self._most_urgent()
            if alarm is None:
                continue
            if self._random.random() < self._habits.present_frac:
                await self._attend(*alarm)
            else:
                await self._spend(self._habits.away_s)

    # --- seeing ----------------------------------------------------------------------------------

    def _most_urgent(self) -> tuple[Duty, str] | None:
        """The next duty and its vehicle; equally urgent ones in the order of names."""
        now_s = self._clock.now_s()
        alarms: list[tuple[Duty, float, str]] = []
        for atv, heard in self._heard.items():
            alarm = self._alarm(atv, heard, now_s)
            if alarm is not None and self._concerns(alarm[0], atv, heard):
                alarms.append((*alarm, atv))
        if not alarms:
            return None
        duty, _, atv = min(alarms)
        return duty, atv

    def _concerns(self, duty: Duty, atv: str, heard: LastHeard) -> bool:
        """Whether this person is responsible: the person asked by a call, otherwise the operator of the vehicle's area."""
        if duty is Duty.RECOVER and self._tablet.goods_left_on(atv) is not None:
            return False  # The person who comes for the goods works on the vehicle, too.
        if not self.duty.is_at_work and duty not in OWN:
            return False
        if duty in CALLED and self._tablet.calls(atv):
            return self.duty.shown(atv) is not None
        return duty in OWN or duty is Duty.FETCH or self._is_here(heard)

    def _alarm(self, atv: str, heard: LastHeard, now_s: float) -> tuple[Duty, float] | None:
        """The need of a vehicle, and its time."""
        heartbeat = heard.heartbeat
        if self._call_for_goods(atv) is not None:
            return Duty.FETCH, heard.at_s
        if now_s - heard.at_s > self._habits.silent_s:
            return Duty.RECOVER, heard.at_s
        since_s = self._stops.get(atv)
        if since_s is not None and _is_later(heard, since_s):
            if heartbeat.status is AtvStatus.STOPPED:
                return Duty.RELEASE, heard.at_s
            del self._stops[atv]
        if heartbeat.problem:
            return Duty.HELP, heartbeat.help.until_s if heartbeat.help is not None else float("inf")
        if self._calls_to_be_let_go(atv):
            return Duty.HELP, float("inf")
        if self._slowed.get(atv, now_s) < now_s:
            return Duty.SPEED_UP, now_s
        if heartbeat.link is Link.WLAN:
            self._mesh_s.pop(atv, None)
        elif self.duty.shown(atv) is not None:
            return Duty.RECONNECT, now_s
        elif self._mesh_s.setdefault(atv, now_s) + self._habits.silent_s < now_s and heartbeat.task is None:
            return Duty.RECONNECT, self._mesh_s[atv]
        return None

    def _calls_to_be_let_go(self, atv: str) -> bool:
        """Whether a vehicle has stopped by itself, and calls this person."""
        shown = self.duty.shown(atv)
        return shown is not None and shown.call.reason in (ALONE, DOUBLED, DENIED)

    def _is_here(self, heard: LastHeard) -> bool:
        return self._whose(heard) == self._area

    def _whose(self, heard: LastHeard) -> str:
        """The area that the vehicle is in."""
        pose = heard.heartbeat.pose
        return area_at(self._plant, pose.x_m, pose.y_m)

    # --- doing -----------------------------------------------------------------------------------

    async def _attend(self, duty: Duty, atv: str) -> None:
        await self._spend(self._habits.react_s)
        comes = True
        if duty is Duty.HELP:
            comes = await self._help(atv)
        elif duty is Duty.RELEASE:
            self._hands.mend(atv)
            await self._release(atv)
        elif duty is Duty.FETCH:
            comes = await self._fetch(atv)
        elif duty is Duty.RECOVER:
            await self._recover(atv)
        elif duty is Duty.RECONNECT:
            comes = await self._reconnect(atv)
        else:
            await self._speed_up(atv)
        self.done[duty] += comes

    async def _help(self, atv: str) -> bool:
        """Mend a vehicle, where it is still needed; False when somebody else comes."""
        walk_s, mend_s = self._draw(self._habits.walk_s), self._draw(self._habits.mend_s)
        promises = self._random.random() < self._habits.promises_frac
        doubled = self._heard[atv].heartbeat.problem == DOUBLED or self._calls_to_be_let_go(atv)
        estimate_s = (walk_s + mend_s) * self._draw(self._habits.estimate)
        if not await self._is_taken(atv, estimate_s):
            return False
        if promises and self._heard[atv].heartbeat.help is not None:
            await self._tablet.say(atv, CommandKind.PROMISE, wait_s=estimate_s)
        await asyncio.sleep(walk_s)
        problem = self._hands.problem(atv)
        # Any other person who has stopped it releases it, too.
        if problem == LOAD_SHIFTED and self._heard[atv].heartbeat.status is not AtvStatus.STOPPED:
            await self._secure(atv, mend_s)
        elif problem:
            await asyncio.sleep(mend_s)
            self._hands.mend(atv)
        elif doubled:
            # The vehicle has stopped by itself, and drives on after a person's work.
            self._stops[atv] = self._clock.now_s()
        if self._hands.problem(atv) and (call := self.duty.shown(atv)) is not None:
            # A colleague with the right to stop it here must come.
            self.duty.reply(call.call.call, CallAnswer.CANNOT)
        return True

    async def _is_taken(self, atv: str, estimate_s: float) -> bool:
        """Answer the call of a vehicle, if it calls; False when somebody else comes, or this person does not."""
        shown = self.duty.shown(atv)
        return await self._takes(shown, estimate_s) if shown is not None else not self._tablet.calls(atv)

    async def _takes(self, shown: ShownCall, estimate_s: float) -> bool:
        """Take a call; False when somebody else comes, or this person does not."""
        if not await self.duty.take(shown.call, estimate_s):
            return False
        habits = self._habits
        may_forget = habits.forgets_frac and self._clock.now_s() < habits.careless_until_s
        if not may_forget or self._careless.random() >= habits.forgets_frac:
            return True
        await asyncio.sleep(estimate_s)
        return False

    async def _secure(self, atv: str, mend_s: float) -> None:
        """Repair a shifted load: nobody reaches into a vehicle that could drive on by itself."""
        # The vehicle may be stopped from here on, with or without an answer.
        self._stops[atv] = self._clock.now_s()
        answer = await self._tablet.say(atv, CommandKind.STOP)
        if answer is None or not answer.done:
            if answer is not None:
                # The vehicle has driven on meanwhile, and its load has slipped once more: a colleague is responsible
                # there.
                del self._stops[atv]
            return
        await asyncio.sleep(mend_s)
        self._hands.mend(atv)
        if self._habits.slow_frac < 1.0:
            await self._tablet.say(atv, CommandKind.SET_SPEED, speed_frac=self._habits.slow_frac)
            self._slowed[atv] = self._clock.now_s() + self._habits.slow_s
        await self._release(atv)

    async def _release(self, atv: str) -> None:
        """End an own stop. Whether it has worked is seen in the heartbeats that follow."""
        for kind in (CommandKind.ACKNOWLEDGE, CommandKind.RESUME):
            answer = await self._tablet.say(atv, kind)
            if answer is None or not answer.done:
                break
        # The vehicle may have come to its stand beyond the border.
        del self._stops[atv]
        self._colleague(atv).look_after_stop(atv, self._clock.now_s())

    async def _fetch(self, atv: str) -> bool:
        """Come for the goods that a vehicle has on board which has failed, and see to the vehicle; False when somebody else comes."""
        shown, habits = self._call_for_goods(atv), self._habits
        latest_s = habits.react_s[1] + habits.walk_s[1] + habits.carry_s[1]
        if shown is None or not await self._takes(shown, latest_s):
            return False
        await self._recover(atv)
        if self.duty.shown(*shown.call.subject) is not None:
            # The vehicle lives and does not move, or this person may not write its goods off.
            self.duty.reply(shown.call.call, CallAnswer.CANNOT)
        return True

    def _call_for_goods(self, atv: str) -> ShownCall | None:
        """The call for goods on board of this vehicle that is shown to this person; None for none."""
        call = self._tablet.goods_left_on(atv)
        return None if call is None else self.duty.shown(*call.subject)

    async def _recover(self, atv: str) -> None:
        """Look for a silent vehicle, clear up after it and bring it back to life."""
        heard = self._heard[atv]
        await self._spend(self._habits.walk_s)
        if self._hands.is_off(atv):
            item, quantity = self._hands.unload(atv)
            if item:
                await self.loads.see_to(atv, heard.heartbeat, item, quantity)
            await self._spend(self._habits.push_s)
            if self._hands.is_off(atv):
                await self._bring_home(atv)
        # A living vehicle has only lost its connection: its WLAN can be repaired, its radio cannot. Once it is heard
        # again, its alarms are seen again.
        if heard.heartbeat.link is Link.MESH:
            self._hands.plug_in(atv)
        if self._heard[atv] is heard:
            del self._heard[atv]

    async def _reconnect(self, atv: str) -> bool:
        """Put a vehicle's WLAN right; False when another person comes.

        Where an access point is down this does not help, and is tried once.
        """
        walk_s = self._draw(self._habits.walk_s)
        if not await self._is_taken(atv, walk_s + LOOK_S):
            return False
        await self.duty.walk_to(atv, walk_s, LOOK_S)
        mended = self._hands.plug_in(atv)
        self._mesh_s[atv] = float("inf")
        if not mended and (call := self.duty.shown(atv)) is not None:
            self.duty.reply(call.call.call, CallAnswer.CANNOT)
        return True

    async def _bring_home(self, atv: str) -> None:
        """Push a vehicle to a charger and switch it on; where others need its place, say so."""
        if self._office is None:
            self._hands.bring_home(atv)
            return
        self._hands.lift(atv)
        self._office.carry_away(atv)
        while True:
            for node in self._hands.nodes_for(atv):
                if await self._office.put_back(atv, node):
                    self._hands.set_down(atv, node)
                    return
            await asyncio.sleep(LOOK_S)

    async def _speed_up(self, atv: str) -> None:
        """Lift an own speed limit, or leave that to the colleague whose area the vehicle has entered."""
        answer = await self._tablet.say(atv, CommandKind.SET_SPEED, speed_frac=1.0)
        if answer is None:
            return
        until_s = self._slowed.pop(atv)
        if not answer.done:
            self._colleague(atv).look_after_limit(atv, until_s)

    def _colleague(self, atv: str) -> Operator:
        """The operator of the area where a vehicle is now."""
        return self.colleagues.get(self._whose(self._heard[atv]), self)

    # --- chance ----------------------------------------------------------------------------------

    def _draw(self, seconds: Range) -> float:
        return self._random.uniform(*seconds)

    async def _spend(self, seconds: Range) -> None:
        await asyncio.sleep(self._draw(seconds))


def _is_later(heard: LastHeard, since_s: float) -> bool:
    """Whether a heartbeat was said after a moment. A vehicle whose clock is ahead says times that have not come yet."""
    said_s = heard.heartbeat.at_s
    return since_s < said_s <= heard.at_s or since_s + LATEST_S < heard.at_s < said_s

"""The vehicle's side of right of way: it drives only into what it holds, and decides itself when to make room.

What it holds ahead it will drive: a base is never taken back, so whoever stands holds the one place where it stands. It asks for
what it needs so early that it need not brake, and gives back what it is clear of. Whoever owns this says where to go (`go`),
carries out its instructions to the body, and tells where the vehicle is (`sense`) whenever it is woken.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum

from dray.messages.traffic import (
    ROUTE_MAX,
    HoldsAsked,
    PlaceGranted,
    Rank,
    YieldAsked,
    YieldRefused,
)
from dray.protocol.runtime.events import Effect, Instruct
from dray.protocol.runtime.timers import Timers, spread_frac
from dray.protocol.traffic.neighbours import Neighbours, Seen
from dray.protocol.traffic.places import Places
from dray.protocol.traffic.prices import Outlook
from dray.protocol.traffic.reserved_way import ReservedWay
from dray.protocol.traffic.ways import Ways
from dray.protocol.traffic.wheels import Wheels
from dray.protocol.traffic.wishes import State, Wishes
from dray.protocol.traffic.yielding import Yielding

LOOK = "look"
HELD_UP = "held up"
RESTED = "rested"

REROUTE_S, REROUTE_MORE_S = 3.0, 2.0
"""Held up for so long, a vehicle looks for another way; the second part follows from its name."""

WITH_TASK, IDLE = 0, 1
"""Classes of rank."""


class Errand(Enum):
    """Why the vehicle drives where it drives."""

    OWN = "own"
    """To where it was told to go."""
    REFUGE = "refuge"
    """Out of somebody's way."""
    REST = "rest"
    """It stands at a refuge for a while."""


class RightOfWay:
    """One vehicle's right of way.

    Args:
        atv: the vehicle.
        life: its incarnation.
        places, ways: of the plant.
        neighbours: what is known of others.
        timers: the agent's alarms; this one's are `LOOK`, `HELD_UP`, `RESTED` and those of `Wishes`.
        out: where effects go.
        node, next_node: where the vehicle stands, or the lane that it is on; its way ends with that lane.
        top_mps, acceleration_mps2: of the vehicle.
        next_order: numbers ways.
    """

    def __init__(
        self,
        atv: str,
        life: int,
        places: Places,
        ways: Ways,
        neighbours: Neighbours,
        timers: Timers,
        out: list[Effect],
        *,
        node: str,
        next_node: str = "",
        top_mps: float,
        acceleration_mps2: float,
        next_order: Callable[[], int],
    ) -> None:
        self.atv = atv
        self.way = ReservedWay(places, node, next_node)
        self.wishes = Wishes(life, places.keepers_of, timers, out)
        self.errand = Errand.OWN
        self.goal = next_node or node
        self.docked = False
        self._places = places
        self._ways = ways
        self._timers = timers
        self._out = out
        self._wheels = Wheels(top_mps, acceleration_mps2, next_order)
        self._rank: Rank = (IDLE, 0.0, atv)
        self._outlook = Outlook(atv, neighbours)
        self._yielding = Yielding(atv, ways, self._outlook, out)
        self._speed_mps = 0.0
        self._held_up_s: float | None = None
        """Since when it stands and waits for its next group."""

    # --- what its owner asks ---------------------------------------------------------------------

    @property
    def stands(self) -> bool:
        """Whether it may not drive anywhere: it stands, or has come to its last place."""
        return self.way.stands

    @property
    def has_arrived(self) -> bool:
        """Whether it stands at its goal, on its own errand."""
        return self.errand is Errand.OWN and self.way.stands and self.way.node == self.goal

    @property
    def own_rank(self) -> Rank:
        """Its rank, without what it has inherited."""
        return self._rank

    def rank(self, now_s: float) -> Rank:
        """Its rank, or the one of whom it makes room for."""
        inherited = self._yielding.of(now_s)
        return self._rank if inherited is None else min(self._rank, inherited.rank)

    @property
    def held_up_since_s(self) -> float | None:
        """Since when it stands and waits for a place; None when it does not."""
        return self._held_up_s

    def hint(self, now_s: float) -> Seen:
        """What others are told with a heartbeat."""
        return Seen(
            at_s=now_s,
            holds=tuple(self.way.held),
            stands=self.way.stands,
            docked=self.docked,
            rank=self.rank(now_s),
            route=(self.way.node, *self.way.ahead)[:ROUTE_MAX],
        )

    # --- what its owner tells --------------------------------------------------------------------

    def start(self, now_s: float) -> None:
        """Tell the book where it stands."""
        self._settle(now_s, anew=True)

    def go(self, goal: str, rank_class: int, now_s: float) -> bool:
        """Begin a leg; False when no way leads there."""
        way = self._ways.way(self.way.base_end, goal, self._outlook.prices(now_s))
        if way is None:
            return False
        self.goal = goal
        self.docked = False
        self._rank = (rank_class, now_s, self.atv)
        self._held_up_s = None
        if self.errand is Errand.OWN:
            self.way.turn_to(way)
        self._settle(now_s)
        return True

    def dock(self, now_s: float) -> None:
        """Stay where it stands until there is another goal: nobody is to ask for room meanwhile."""
        self.docked = True
        self._settle(now_s)

    def rest(self, now_s: float) -> None:
        """There is nothing to do: make room for everybody."""
        self.docked = False
        self._rank = (IDLE, now_s, self.atv)
        self._settle(now_s)

    def sense(self, past_m: float, speed_mps: float) -> None:
        """The vehicle is so far past its last node, at this speed; told before anything else of the same moment."""
        self._speed_mps = speed_mps
        self.way.move(past_m)

    def on_passed(self, now_s: float) -> None:
        """The next node of the base was reached."""
        self.way.pass_next()
        if self.way.stands:
            self._speed_mps = 0.0
            if self.way.node == self.way.goal and self.errand is Errand.REFUGE:
                self._reach_refuge(now_s)
        self._settle(now_s)

    # --- messages --------------------------------------------------------------------------------

    def on_granted(self, granted: PlaceGranted, now_s: float) -> None:
        """A keeper has answered, or grants something."""
        fresh = self.wishes.on_granted(granted, now_s)
        if fresh is None:
            return
        self._outlook.note(granted, now_s)
        unwanted = False
        if fresh:
            asked = {place for group in self.wishes.groups(granted.district) for place in group}
            if self.way.take(place for place in fresh if place in asked):
                self._drive_on(now_s)
            unwanted = any(place not in self.way.held for place in fresh)
            if not unwanted:
                groups = self._groups_in(granted.district, self._groups())
                if not groups:
                    self.wishes.count_as_said(
                        granted.district, self._holds_in(granted.district), (), self._state(now_s)
                    )
        self._settle(now_s, anew_in=granted.district if unwanted else "")

    def on_yield_asked(self, asked: YieldAsked, now_s: float) -> None:
        """Somebody wants to come by."""
        if not self._holds_in(asked.district):
            # The book is wrong about this vehicle: tell it.
            self._settle(now_s, anew_in=asked.district)
            return
        if not self.way.stands or self.docked or asked.atv == self.atv or self.atv in asked.chain:
            return
        if self._yielding.renew(asked, now_s):
            if self.errand is Errand.REFUGE and self._yielding.is_patient(now_s):
                return
        elif asked.rank >= self.rank(now_s):
            return
        own = (self.way.node, *self.way.ahead)
        chain = (asked.atv, *asked.chain)
        way = self._yielding.refuge(self.way.node, self.goal, asked.avoid, chain, asked.rank, now_s)
        # Who has nowhere to go inherits, too: it comes out with the rank of the one who makes room for it.
        self._yielding.inherit(asked, now_s)
        if way is None:
            self._yielding.refuse(asked.atv, own[:ROUTE_MAX], self.way.held, now_s)
            self._settle(now_s)
        else:
            self._leave_for(way, now_s, backtracks=False)

    def on_yield_refused(self, sender: str, refused: YieldRefused, now_s: float) -> None:
        """Whoever is in the way has nowhere to go."""
        if not self.way.stands or self.docked or self._held_up_s is None or self.errand is Errand.REST:
            return
        inherited = self._yielding.of(now_s)
        chain = inherited.chain if inherited is not None else ()
        avoid = refused.avoid + (inherited.avoid if inherited is not None else ())
        rank = self.rank(now_s)
        way = self._yielding.refuge(self.way.node, self.goal, avoid, (sender, *chain), rank, now_s)
        if way is not None:
            self._leave_for(way, now_s, backtracks=inherited is None)
        elif inherited is not None:
            self._yielding.refuse(inherited.pusher, refused.avoid, self.way.held, now_s)

    def on_holds_asked(self, sender: str, asked: HoldsAsked, now_s: float) -> None:
        """Somebody else keeps a book from now on."""
        if self.wishes.on_holds_asked(asked):
            self._settle(now_s, anew_in=asked.district, to=sender if asked.roll_call else "")

    # --- alarms ----------------------------------------------------------------------------------

    def look(self, now_s: float) -> None:
        """The alarm `LOOK` has come: its owner has told before where the vehicle is."""
        self._settle(now_s)

    def repeat_wish(self, district: str, now_s: float) -> None:
        """No answer has come from a district."""
        groups = self._groups()
        self.wishes.repeat(
            district, self._holds_in(district), self._groups_in(district, groups), self._state(now_s), now_s
        )

    def reroute(self, now_s: float) -> None:
        """Held up for a while: is there a better way by now?"""
        if self._held_up_s is None or self.docked:
            return
        if self.errand is Errand.OWN:
            way = self._ways.way(self.way.node, self.goal, self._outlook.prices(now_s))
            if way is not None:
                self.way.turn_to(way)
        elif (
            self.errand is Errand.REFUGE
            and self._yielding.of(now_s) is None
            and not self._yielding.backtracks
        ):
            # Nobody asks any more: go on with one's own.
            self._resume(now_s)
        self._timers.set(HELD_UP, now_s + self._patience_s)
        self._settle(now_s)

    def go_on(self, now_s: float) -> None:
        """Rested at a refuge: go on to where it was going."""
        if self.errand is Errand.REST:
            self._resume(now_s)
            self._settle(now_s)

    # --- making room -----------------------------------------------------------------------------

    def _leave_for(self, way: tuple[str, ...], now_s: float, *, backtracks: bool) -> None:
        self.errand = Errand.REFUGE
        self._yielding.leave(now_s, backtracks=backtracks)
        self.way.turn_to(way)
        self._timers.clear(RESTED)
        self._settle(now_s)

    def _reach_refuge(self, now_s: float) -> None:
        self.errand = Errand.REST
        self._timers.set(RESTED, now_s + self._yielding.reach_refuge())

    def _resume(self, now_s: float) -> None:
        self.errand = Errand.OWN
        self._yielding.stop()
        if self._rank[0] >= IDLE:
            self.goal = self.way.base_end
        way = self._ways.way(self.way.base_end, self.goal, self._outlook.prices(now_s))
        if way is not None:
            self.way.turn_to(way)

    # --- driving ---------------------------------------------------------------------------------

    def _drive_on(self, now_s: float) -> None:
        """The base has grown: let the body drive it."""
        self._note_wait(now_s)
        self._out.append(Instruct(self._wheels.drive(self.way, self._speed_mps)))

    def _note_wait(self, now_s: float) -> None:
        if self._held_up_s is not None:
            waited_s = now_s - self._held_up_s
            if waited_s > 1.0 and self.way.base:
                self._outlook.waited(self._places.place_of(self.way.base[0]), waited_s, now_s)
            self._held_up_s = None
            self._timers.clear(HELD_UP)

    # --- wishes ----------------------------------------------------------------------------------

    def _settle(self, now_s: float, *, anew: bool = False, anew_in: str = "", to: str = "") -> None:
        """Give back what it is clear of, ask for what comes next, and look again in time."""
        self.way.give_back()
        groups = self._groups()
        wanted_in = self._places.district_of[groups[0][0]] if groups else ""
        if self.way.stands and groups and not self.docked:
            if self._held_up_s is None:
                self._held_up_s = now_s
                self._timers.set(HELD_UP, now_s + self._patience_s)
        elif self._held_up_s is not None:
            self._held_up_s = None
            self._timers.clear(HELD_UP)
        state = self._state(now_s)
        districts = dict.fromkeys(self._places.district_of[place] for place in self.way.held)
        told = dict.fromkeys((*districts, wanted_in, *self.wishes.districts, anew_in))
        told.pop("", None)
        for district in told:
            self.wishes.say(
                district,
                self._holds_in(district),
                self._groups_in(district, groups),
                state,
                now_s,
                anew=anew or district == anew_in,
                to=to if district == anew_in else "",
            )
        self._look_again(now_s)

    def _groups(self) -> tuple[tuple[str, ...], ...]:
        """What it wants next."""
        if self.docked or self.errand is Errand.REST:
            return ()
        return tuple(self.way.groups(self._wheels.needs_m(self._speed_mps, self.wishes.round_s)))

    def _holds_in(self, district: str) -> tuple[str, ...]:
        district_of = self._places.district_of
        return tuple(sorted(place for place in self.way.held if district_of[place] == district))

    def _groups_in(self, district: str, groups: tuple[tuple[str, ...], ...]) -> tuple[tuple[str, ...], ...]:
        if groups and self._places.district_of[groups[0][0]] == district:
            return groups
        return ()

    def _state(self, now_s: float) -> State:
        inherited = self._yielding.of(now_s)
        route = (self.way.node, *self.way.ahead)[:ROUTE_MAX]
        if inherited is None:
            return State(self._rank, self.way.stands, self.docked, route, ())
        avoid = tuple(dict.fromkeys((*route, *inherited.avoid)))[: 2 * ROUTE_MAX]
        return State(self.rank(now_s), self.way.stands, self.docked, avoid, inherited.chain)

    def _look_again(self, now_s: float) -> None:
        """Set the alarm for the moment when it may be clear of a place, or needs the next one."""
        when_s = self._wheels.look_in_s(self.way, self._speed_mps, self.wishes.round_s)
        if when_s is None:
            self._timers.clear(LOOK)
        else:
            self._timers.set(LOOK, now_s + when_s)

    @property
    def _patience_s(self) -> float:
        return REROUTE_S + REROUTE_MORE_S * spread_frac(self.atv)

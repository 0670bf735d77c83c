"""The vehicle's side of right of way: it drives only into places that it holds, and decides itself when to make room.

A base is always driven and never taken back, so a standing vehicle holds only the place where it stands. It requests places early
enough not to brake, and gives them back when it is clear of them. The owner of this object sets the goal (`go`) and carries out
its instructions to the body. Whenever it is woken, it first reports the vehicle's position (`sense`).
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from enum import Enum
from itertools import pairwise

from dray.messages.floor.traffic import (
    FIRST_S,
    ROUTE_MAX,
    HoldsAsked,
    PlaceConfirmed,
    PlaceGranted,
    Rank,
    YieldAsked,
    YieldRefused,
)
from dray.plant.model import VehicleType
from dray.plant.restrictions import OPEN, Ends, Restrictions
from dray.protocol.runtime.life import Life
from dray.protocol.runtime.timers import spread_frac
from dray.protocol.traffic.driving.place_requests import PlaceRequests, Sign, State, unsigned
from dray.protocol.traffic.driving.reserved_way import ReservedWay
from dray.protocol.traffic.driving.wait import AGES_BY_S, SHUT_OUT_S, ShutOut, Wait
from dray.protocol.traffic.driving.wheels import Wheels
from dray.protocol.traffic.driving.yielding import Yielding
from dray.protocol.traffic.neighbours import Seen
from dray.protocol.traffic.places import Places
from dray.protocol.traffic.prices import Outlook
from dray.protocol.traffic.surroundings import Surroundings
from dray.protocol.traffic.ways import Ways

LOOK = "look"
HELD_UP = "held up"
RESTED = "rested"

REROUTE_S, REROUTE_MORE_S = 3.0, 2.0
"""Time held up before a vehicle looks for another way; a share of the second part, by its name, is added."""

WITH_TASK, IDLE, RESTING = 0, 1, 2
"""Classes of rank. A resting vehicle makes room for all driving ones. Otherwise one that has rested for long would block vehicles
that begin to look for a place to rest."""


class Errand(Enum):
    """The purpose of the vehicle's present drive."""

    OWN = "own"
    """To its own goal."""
    REFUGE = "refuge"
    """Out of another vehicle's way."""
    REST = "rest"
    """A rest at a refuge."""


class RightOfWay:
    """One vehicle's right of way: its requests for places, and the instructions to its body that follow from the answers.

    Args:
        atv: the vehicle.
        incarnation: number of starts of its agent.
        places, ways: of the plant.
        surroundings: its knowledge of other vehicles.
        node, next_node: where the vehicle stands, or the lane that it is on; its way ends with that lane.
        kind: the vehicle's type.
        next_order: numbers ways.
        restrictions: returns what people have closed or made slow, as far as the vehicle knows.
        obstructed: returns the lanes with an obstacle, likewise.
        sign: signs its requests.

    Attributes:
        wait: for its next places.
        is_denied: it was driving when it learned of its removal, and so drives on places that it does not hold.
        is_doubled: it got an answer to a request it never sent: an impostor may have given its places back.
    """

    is_denied = False
    is_doubled = False

    def __init__(
        self,
        atv: str,
        incarnation: int,
        places: Places,
        ways: Ways,
        surroundings: Surroundings,
        life: Life,
        *,
        node: str,
        next_node: str = "",
        kind: VehicleType,
        next_order: Callable[[], int],
        restrictions: Callable[[], Restrictions] = lambda: OPEN,
        obstructed: Callable[[], frozenset[Ends]] = frozenset,
        sign: Sign = unsigned,
    ) -> None:
        self.atv = atv
        self.way = ReservedWay(places, node, next_node)
        self.requests = PlaceRequests(incarnation, places.replicas_of, life, sign)
        self.wait = Wait()
        self.errand = Errand.OWN
        self.goal = next_node or node
        self.docked = False
        self.stuck = False
        """Whether it cannot move until a person helps: then it requests nothing, and does not make room."""
        self._obeys = True
        """Whether the body was seen to drive its newest way. Until then all places held before are kept."""
        self._rests = True
        """Whether it has no goal of its own, so that any place to stand will do."""
        self._places = places
        self._ways = ways
        self._life = life
        self._wheels = Wheels(kind.max_speed_mps, kind.acceleration_mps2, next_order, restrictions)
        self._rank: Rank = (IDLE, 0.0, atv)
        self._surroundings = surroundings
        self._outlook = Outlook(surroundings, restrictions, obstructed)
        self._yielding = Yielding(atv, ways, self._outlook, life)
        self._speed_mps = 0.0
        self._went_round: frozenset[str] = frozenset()
        """Places of silent vehicles for which it has looked for another way on this leg."""
        self.removal = 0
        """Number of its newest known removal: earlier grants are void."""
        self._asked = set(self.way.held)
        """Places where the body is, or is about to be, that no table has granted yet: it does not drive before."""

    # --- how things stand ------------------------------------------------------------------------

    @property
    def stands(self) -> bool:
        """Whether it has driven its base to the end."""
        return self.way.stands

    @property
    def is_finishing(self) -> bool:
        """Whether the body was told to end its way, and has not reported that yet."""
        return self._wheels.is_finishing

    @property
    def holds(self) -> tuple[str, ...]:
        """The places that it holds by a grant."""
        return tuple(place for place in self.way.held if place not in self._asked)

    @property
    def is_placed(self) -> bool:
        """Whether it holds the places where it is; otherwise it requests them."""
        return not self._asked

    def knows(self, order: int) -> bool:
        """Whether this order is one of the body's newest ways."""
        return self._wheels.knows(order)

    @property
    def own_rank(self) -> Rank:
        """Its rank without inheritance.

        A vehicle that waits for a silent one is less urgent than all with a task: it may wait for ever and must not be in their way.
        A vehicle that requests the place where it stands is the most urgent.
        """
        if self._asked:
            return (WITH_TASK, FIRST_S, self.atv)
        if self.wait.is_for_silent:
            return (max(self._rank[0], IDLE), *self._rank[1:])
        return self._rank

    def rank(self, now_s: float) -> Rank:
        """Its own rank, or the inherited one if that is more urgent."""
        rank = self.own_rank
        inherited = self._yielding.of(now_s)
        return rank if inherited is None else min(rank, inherited.rank)

    @property
    def is_hindered(self) -> bool:
        """Whether it waits for a place or makes room, and so comes no nearer to its goal."""
        return self.wait.is_on or self.errand is not Errand.OWN

    def shut_out(self, now_s: float) -> ShutOut | None:
        """The silent vehicle for which it has waited `SHUT_OUT_S`, with no way round; None when there is none."""
        waited_s, at = self.wait.for_silent_s(now_s), self.wait.at
        if self.errand is not Errand.OWN or not self.is_placed or waited_s < SHUT_OUT_S:
            return None
        if not any(at in group for group in self._groups()):
            return None
        return self.shut_out_by(self.wait.by, (at,), waited_s)

    def shut_out_by(self, by: str, holds: Collection[str], waited_s: float = 0.0) -> ShutOut | None:
        """How a vehicle that holds these places, and does not move, shuts this one out; None when its way does not need them."""
        for place, lane in self.way.lanes_to().items():
            if place in holds:
                return ShutOut(by, tuple(dict.fromkeys((lane, *self._places.entries(place)))), waited_s)
        return None

    @property
    def has_arrived(self) -> bool:
        """Whether it stands at its goal, on its own errand."""
        return self.errand is Errand.OWN and self.way.stands and self.way.node == self.goal

    def hint(self, now_s: float) -> Seen:
        """The traffic fields of its heartbeat."""
        return Seen(
            at_s=now_s,
            holds=self.holds,
            stands=self.way.stands,
            docked=self.docked,
            rank=self.rank(now_s),
            route=(self.way.node, *self.way.ahead)[:ROUTE_MAX],
        )

    # --- calls by its owner ----------------------------------------------------------------------

    def start(self, now_s: float) -> None:
        """Report to the tables where it stands; after a restart, to all of them, as any may know of an earlier life."""
        for district in self._places.replicas_of if self.requests.life > 1 else ():
            self.requests.open(district)
        self._settle(now_s, anew=True)

    def take_control(self, now_s: float, *, drives_beyond: bool) -> None:
        """Make the body drive to the end of the base: it may follow a way of an earlier life, or have lost its way.

        Args:
            now_s: the present time.
            drives_beyond: the body may pass that end before it gets the instruction; all places are held until it is seen to obey.
        """
        self._wheels.forget()
        self._obeys = not drives_beyond
        if not self.way.stands:
            self._life.instruct(self._wheels.drive(self.way, self._speed_mps))
        elif drives_beyond:
            self._life.instruct(self._wheels.finish(self.way))
        if self._obeys:
            self.way.let_go()

    def relocate(
        self,
        node: str,
        next_node: str,
        now_s: float,
        *,
        past_m: float,
        speed_mps: float,
        drives_beyond: bool = False,
    ) -> None:
        """Continue from the body's present position: it has lost its way, or was carried elsewhere.

        Args:
            node: where it stands, or the last node that it has passed.
            next_node: the end of the lane that it is on; `node` when it stands there.
            now_s: the present time.
            past_m: its distance past `node`.
            speed_mps: its speed.
            drives_beyond: see `take_control`.
        """
        own = self.holds
        self.way = self.way.again(node, next_node)
        self._asked = self.way.held.keys() - own
        self.sense(past_m, speed_mps)
        self.take_control(now_s, drives_beyond=drives_beyond or not self.way.stands)
        if self.errand is not Errand.OWN:
            self._resume(now_s)
        else:
            way = self._ways.way(self.way.base_end, self.goal, self._outlook.prices(now_s))
            if way is not None:
                self.way.turn_to(way)
        self._settle(now_s, anew=True)

    def leads_round(self, node: str, now_s: float) -> bool:
        """Whether its way from a node to its goal has no known obstacle."""
        prices = self._outlook.prices(now_s)
        way = self._ways.way(node, self.goal, prices)
        return way is not None and prices.obstructed.isdisjoint(pairwise(way))

    def go(self, goal: str, rank_class: int, now_s: float) -> bool:
        """Begin a leg; False when no way leads there."""
        way = self._ways.way(self.way.base_end, goal, self._outlook.prices(now_s))
        if way is None:
            return False
        self.goal = goal
        self.docked = self._rests = False
        self._rank = (rank_class, now_s, self.atv)
        self.wait.begin_leg()
        self._went_round = frozenset()
        self._yielding.begin_leg()
        if self.errand is Errand.OWN:
            self.way.turn_to(way)
        self._settle(now_s)
        self._finish_there()
        return True

    def dock(self, now_s: float) -> None:
        """Stay where it stands until the next goal, without making room."""
        self.docked = True
        self._settle(now_s)

    def rest(self, now_s: float) -> None:
        """Rest without a goal, and make room for all others."""
        self.docked, self._rests = False, True
        self._rank = (RESTING, now_s, self.atv)
        self._settle(now_s)

    def on_passed(self, now_s: float) -> None:
        """The vehicle has reached the next node of the base."""
        self.way.pass_next()
        if self.way.stands:
            self._speed_mps = 0.0
            if self.way.node == self.way.goal and self.errand is Errand.REFUGE:
                self._reach_refuge(now_s)
        self._settle(now_s)
        self._finish_there()

    def on_reached(self, order: int, index: int, now_s: float) -> None:
        """The body has reached a node of a way that it was given."""
        number = self._wheels.number_of(order, index)
        if number is None:
            return
        while self.way.passed < number and not self.way.stands:
            self.on_passed(now_s)
        self._obeys = True
        if self.way.let_go():
            self._settle(now_s)

    def be_stuck(self, stuck: bool, now_s: float) -> None:
        """Note whether it cannot move until a person helps."""
        if stuck is not self.stuck:
            self.stuck = stuck
            self._settle(now_s)

    def sense(self, past_m: float, speed_mps: float) -> None:
        """Note its distance past the last node and its speed, before any other call at the same moment."""
        self._speed_mps = speed_mps
        self.way.move(past_m)

    def look(self, now_s: float) -> None:
        """The alarm `LOOK` has come; the owner has called `sense` before."""
        self._settle(now_s)

    # --- messages --------------------------------------------------------------------------------

    def on_granted(self, sender: str, granted: PlaceGranted, now_s: float) -> None:
        """Handle a replica's answer or grant."""
        if self.requests.is_anothers(sender, granted):
            self.is_doubled, self._asked = True, set(self.way.held)
            self._settle(now_s, anew=True)
            return
        fresh = self.requests.on_granted(sender, granted, now_s)
        if fresh is None:
            return
        if granted.removal > self.removal:
            self._begin_anew(granted)
            return
        self._outlook.note(granted, now_s)
        if self._asked and granted.removal == self.removal and self.requests.is_answered(granted):
            self._asked.difference_update(fresh)
        groups = self._groups()
        if groups and self._places.district_of[groups[0][0]] == granted.district:
            self.wait.note(granted, now_s)
        unwanted = False
        if not self._obeys:
            self.way.keep(fresh)
        if fresh:
            asked = {place for group in self.requests.groups(granted.district) for place in group}
            if self.is_placed and self.way.take(place for place in fresh if place in asked):
                self._drive_on(now_s)
            unwanted = any(place not in self.way.held for place in fresh)
            if not unwanted:
                groups = self._groups_in(granted.district, self._groups())
                if not groups:
                    self.requests.count_as_said(
                        granted.district, self._holds_in(granted.district), (), self._state(now_s)
                    )
        self._settle(now_s, anew_in=granted.district if unwanted else "")

    def on_confirmed(self, sender: str, confirmed: PlaceConfirmed, now_s: float) -> None:
        """Handle a witness's confirmation."""
        if not self.requests.on_confirmed(sender, confirmed):
            self._life.ignore("a confirmation by an agent that is not the witness")
        self._take_believed(confirmed.district, now_s)

    def repeat_request(self, district: str, now_s: float) -> None:
        """Repeat the request to a district, whose alarm has come."""
        groups = self._groups_in(district, self._groups())
        self.requests.repeat(district, self._holds_in(district), groups, self._state(now_s), now_s)
        self._take_believed(district, now_s)

    def _take_believed(self, district: str, now_s: float) -> bool:
        answer = self.requests.take_believed(district)
        if answer is not None:
            self.on_granted(*answer, now_s)
        return answer is not None

    def on_silence_told(self, now_s: float) -> None:
        """A replica has reported silent vehicles: look for another way, once on each leg for each place of theirs."""
        if self.errand is not Errand.OWN or self.docked or self.way.base_end == self.way.goal:
            return
        met = self.way.lanes_to().keys() & self._surroundings.silent_at(now_s)
        if met <= self._went_round:
            return
        self._went_round |= met
        way = self._ways.way(self.way.base_end, self.goal, self._outlook.prices(now_s))
        if way is not None:
            self.way.turn_to(way)
            self._settle(now_s)

    def on_yield_asked(self, sender: str, asked: YieldAsked, now_s: float) -> None:
        """Make room for a more urgent vehicle, or refuse."""
        if not self.requests.keeps(sender, asked.district):
            self._life.ignore("a request to make room by an agent that does not keep the table")
            return
        if not self._holds_in(asked.district):
            # The table is wrong about this vehicle: correct it.
            self._settle(now_s, asked_in=asked.district)
            return
        if not self._can_yield or asked.waiting == self.atv or self.atv in asked.chain:
            return
        if self._yielding.renew(asked, now_s):
            if self.errand is Errand.REFUGE and self._yielding.is_patient(now_s):
                return
        elif asked.rank >= self.rank(now_s):
            return
        own = (self.way.node, *self.way.ahead)
        chain = (asked.waiting, *asked.chain)
        way = self._refuge(asked.avoid, chain, asked.rank, now_s)
        # A vehicle without a refuge inherits, too: it comes out with the rank of the one that makes room for it.
        self._yielding.inherit(asked, now_s)
        if way is None:
            if not self.way.ahead:
                own = self._want_out(asked, now_s)
            self._yielding.refuse(asked.waiting, own[:ROUTE_MAX], self.way.held, now_s)
            self._settle(now_s)
        else:
            self._leave_for(way, now_s)

    def on_yield_refused(self, sender: str, refused: YieldRefused, now_s: float) -> None:
        """The vehicle in the way has no refuge: make room itself, or pass the refusal on."""
        if not self._can_yield or not self.wait.is_on or self.errand is Errand.REST:
            return
        inherited = self._yielding.of(now_s)
        chain = inherited.chain if inherited is not None else ()
        avoid = refused.avoid + (inherited.avoid if inherited is not None else ())
        rank = self.rank(now_s)
        way = self._refuge(avoid, (sender, *chain), rank, now_s, refused=inherited is None)
        if way is not None:
            self._leave_for(way, now_s, refuser=sender if inherited is None else "")
        elif inherited is not None:
            self._yielding.refuse(inherited.pusher, refused.avoid, self.way.held, now_s)

    def on_holds_asked(self, sender: str, asked: HoldsAsked, now_s: float) -> None:
        """A replica reports its epoch and asks what the vehicle holds."""
        if asked.recovery_poll and not self._obeys:
            # It is not known yet where the body goes; the poll will ask again.
            return
        is_to_tell = self.requests.on_holds_asked(sender, asked, settles=self._obeys)
        if self._take_believed(asked.district, now_s):
            return
        if not is_to_tell:
            return
        if asked.recovery_poll:
            self._tell(asked, sender, now_s)
        else:
            self._settle(now_s, asked_in=asked.district)

    # --- alarms ----------------------------------------------------------------------------------

    def reroute(self, now_s: float) -> None:
        """After a while held up, raise the rank and look for a better way."""
        if not self.wait.is_on or self.docked:
            return
        if self.wait.ages(now_s):
            self._rank = (self._rank[0], self._rank[1] - AGES_BY_S, self.atv)
        if self.errand is Errand.OWN:
            way = self._ways.way(self.way.node, self.goal, self._outlook.prices(now_s))
            if way is not None:
                self.way.turn_to(way)
        elif (
            self.errand is Errand.REFUGE
            and self._yielding.of(now_s) is None
            and not self._yielding.backtracks
        ):
            # No vehicle asks for room any more: continue to its own goal.
            self._resume(now_s)
        self._life.alarm(HELD_UP, now_s + self._patience_s)
        self._settle(now_s)

    def go_on(self, now_s: float) -> None:
        """Continue to its own goal after the rest at a refuge."""
        if self.errand is Errand.REST:
            self._resume(now_s)
            self._settle(now_s)

    # --- making room -----------------------------------------------------------------------------

    @property
    def _can_yield(self) -> bool:
        return self.way.stands and self.is_placed and not self.docked and not self.stuck

    def _begin_anew(self, granted: PlaceGranted) -> None:
        """A person has reported its removal: it holds nothing any more, and requests where it stands."""
        self.removal = granted.removal
        told = {reservation.place for reservation in granted.grants}
        district_of = self._places.district_of
        lost = [place for place in self.holds if district_of[place] == granted.district and place not in told]
        self.is_denied = bool(lost) and not self.way.stands
        self._asked = set(self.way.held)
        for district in self._places.replicas_of:
            self.requests.open(district)

    def _refuge(
        self,
        avoid: tuple[str, ...],
        chain: tuple[str, ...],
        rank: Rank,
        now_s: float,
        *,
        refused: bool = False,
    ) -> tuple[str, ...] | None:
        again, here = self.errand is Errand.REFUGE, self.way.node
        return self._yielding.refuge(here, self.goal, avoid, chain, rank, now_s, again=again, refused=refused)

    def _leave_for(self, way: tuple[str, ...], now_s: float, *, refuser: str = "") -> None:
        self._yielding.leave(way[-1], now_s, refuser=refuser)
        self._turn_to_refuge(way, now_s)
        self._settle(now_s)

    def _want_out(self, asked: YieldAsked, now_s: float) -> tuple[str, ...]:
        """Without a way of its own, want the one to a refuge past the asking vehicle, which may back off; returns its nodes."""
        way = self._refuge(asked.avoid, (), asked.rank, now_s) or (self.way.node,)
        if len(way) > 1:
            self._turn_to_refuge(way, now_s)
        return way

    def _turn_to_refuge(self, way: tuple[str, ...], now_s: float) -> None:
        self.errand = Errand.REFUGE
        self.way.turn_to(way)
        self._life.cancel(RESTED)

    def _reach_refuge(self, now_s: float) -> None:
        self.errand = Errand.REST
        self._life.alarm(RESTED, now_s + self._yielding.reach_refuge())

    def _resume(self, now_s: float) -> None:
        self.errand = Errand.OWN
        self._yielding.stop()
        if self._rests:
            self.goal = self.way.base_end
        way = self._ways.way(self.way.base_end, self.goal, self._outlook.prices(now_s))
        if way is not None:
            self.way.turn_to(way)
        self._finish_there()

    def _finish_there(self) -> None:
        """At its goal, let the body end a way that leads on."""
        if self.has_arrived and self._wheels.has_more(self.way):
            self._life.instruct(self._wheels.finish(self.way))

    # --- driving ---------------------------------------------------------------------------------

    def _drive_on(self, now_s: float) -> None:
        """Let the body drive the base, which has grown."""
        waited_s = self._end_wait(now_s, at_goal=self.way.base_end == self.goal)
        if waited_s > 1.0 and self.way.base:
            self._outlook.waited(self._places.place_of(self.way.base[0]), waited_s, now_s)
        self._life.instruct(self._wheels.drive(self.way, self._speed_mps))

    def _end_wait(self, now_s: float, *, at_goal: bool = False) -> float:
        """End the wait, if it waits; the time (s) that it has waited."""
        if self.wait.is_on:
            self._life.cancel(HELD_UP)
        return self.wait.end_wait(now_s, at_goal=at_goal)

    # --- requests ----------------------------------------------------------------------------------

    def _settle(self, now_s: float, *, anew: bool = False, anew_in: str = "", asked_in: str = "") -> None:
        """Give back cleared places, request the next ones, and set the alarm for the next look.

        Args:
            now_s: the present time.
            anew: send every request, also an unchanged one.
            anew_in: the district where the request is sent in any case; empty for none.
            asked_in: the district whose replica has asked for it; empty for none.
        """
        self.way.give_back()
        self._asked &= self.way.held.keys()
        if self.way.stands and self.is_placed and self.way.take(()):
            # The way leads back over a place that it still holds: no table has to grant it.
            self._drive_on(now_s)
        groups = self._groups()
        wanted_in = self._places.district_of[groups[0][0]] if groups else ""
        if self.way.stands and groups:
            if not self.wait.is_on:
                self.wait.begin_wait(now_s)
                self._life.alarm(HELD_UP, now_s + self._patience_s)
        else:
            self._end_wait(now_s)
        state = self._state(now_s)
        districts = dict.fromkeys(self._places.district_of[place] for place in self.way.held)
        told = dict.fromkeys((*districts, wanted_in, *self.requests.districts, anew_in, asked_in))
        told.pop("", None)
        holds = self._holds_by_district()
        for district in told:
            self.requests.say(
                district,
                holds.get(district, ()),
                self._groups_in(district, groups),
                state,
                now_s,
                anew=anew or district == anew_in,
                asked=district == asked_in,
            )
        self._surroundings.listen(() if self._is_in_no_hurry(now_s) else districts, now_s)
        self._look_again(now_s)

    def _tell(self, asked: HoldsAsked, replica: str, now_s: float) -> None:
        """Answer a recovery poll, with the state in that district only."""
        district, state = asked.district, self._state(now_s)
        groups = self._groups_in(district, self._groups())
        holds = self._holds_in(district)
        self.requests.say(district, holds, groups, state, now_s, anew=True, to=replica, epoch=asked.epoch)

    def _is_in_no_hurry(self, now_s: float) -> bool:
        """Whether it rests at its own place and was not asked for room: then it needs no reports of others."""
        return (
            self._rests
            and self.way.stands
            and self.errand is Errand.OWN
            and not self._asked
            and self._yielding.of(now_s) is None
        )

    def _groups(self) -> tuple[tuple[str, ...], ...]:
        """The groups that it wants next; first the places where it is."""
        if self._asked:
            first = next(place for place in self.way.held if place in self._asked)
            return self._asked_in(self._places.district_of[first])
        if self.docked or self.stuck or self.errand is Errand.REST:
            return ()
        return tuple(self.way.groups(self._wheels.needs_m(self._speed_mps, self.requests.round_s)))

    def _holds_in(self, district: str) -> tuple[str, ...]:
        return self._holds_by_district().get(district, ())

    def _holds_by_district(self) -> dict[str, tuple[str, ...]]:
        district_of = self._places.district_of
        holds: dict[str, list[str]] = {}
        for place in self.way.held:
            if place not in self._asked:
                holds.setdefault(district_of[place], []).append(place)
        return {district: tuple(sorted(places)) for district, places in holds.items()}

    def _asked_in(self, district: str) -> tuple[tuple[str, ...], ...]:
        district_of = self._places.district_of
        asked = tuple(sorted(place for place in self._asked if district_of[place] == district))
        return (asked,) if asked else ()

    def _groups_in(self, district: str, groups: tuple[tuple[str, ...], ...]) -> tuple[tuple[str, ...], ...]:
        if self._asked:
            return self._asked_in(district)
        if groups and self._places.district_of[groups[0][0]] == district:
            return groups
        return ()

    def _state(self, now_s: float) -> State:
        inherited = self._yielding.of(now_s)
        route = (self.way.node, *self.way.ahead)[:ROUTE_MAX]
        if inherited is None:
            return State(
                self.rank(now_s), self.way.stands, self.docked, route, (), self.removal, bool(self._asked)
            )
        avoid = tuple(dict.fromkeys((*route, *inherited.avoid)))[: 2 * ROUTE_MAX]
        return State(
            self.rank(now_s),
            self.way.stands,
            self.docked,
            avoid,
            inherited.chain,
            self.removal,
            bool(self._asked),
        )

    def _look_again(self, now_s: float) -> None:
        """Set the alarm for when it may be clear of a place, or need the next one."""
        when_s = self._wheels.look_in_s(self.way, self._speed_mps, self.requests.round_s)
        if when_s is None:
            self._life.cancel(LOOK)
        else:
            self._life.alarm(LOOK, now_s + when_s)

    @property
    def _patience_s(self) -> float:
        return REROUTE_S + REROUTE_MORE_S * spread_frac(self.atv)

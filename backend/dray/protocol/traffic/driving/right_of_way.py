"""The vehicle's side of right of way: it drives only into what it holds, and decides itself when to make room.

What it holds ahead it will drive: a base is never taken back, so whoever stands holds the one place where it stands. It asks for
what it needs so early that it need not brake, and gives back what it is clear of. Whoever owns this says where to go (`go`),
carries out its instructions to the body, and tells where the vehicle is (`sense`) whenever it is woken.
"""

from __future__ import annotations

from itertools import pairwise

from dray.messages.floor.traffic import (
    ROUTE_MAX,
    Blocked,
    HoldsAsked,
    PlaceConfirmed,
    PlaceGranted,
    Rank,
    YieldAsked,
    YieldRefused,
)
from dray.protocol.runtime.events import Ignore, Instruct
from dray.protocol.traffic.driving.place_requests import (
    AGES_BY_S,
    AGES_EVERY_S,
    HELD_UP,
    RESTING,
    Errand,
    PlaceRequests,
)

RESTED = "rested"


class RightOfWay(PlaceRequests):
    """One vehicle's right of way. Its alarms are those of its requests, and `RESTED`.

    Attributes:
        is_denied: it was driving when it heard that it had been carried away: it drives on what is not its own.
        is_doubled: it has just heard an answer to what it has not said: what it holds may have been given back in its name.
    """

    is_denied = False
    is_doubled = False

    # --- what its owner asks ---------------------------------------------------------------------

    @property
    def has_arrived(self) -> bool:
        """Whether it stands at its goal, on its own errand."""
        return self.errand is Errand.OWN and self.way.stands and self.way.node == self.goal

    # --- what its owner tells --------------------------------------------------------------------

    def start(self, now_s: float) -> None:
        """Tell the books where it stands: those, too, that may know more of an earlier life."""
        for district in self._places.keepers_of if self.wishes.life > 1 else ():
            self.wishes.open(district)
        self._settle(now_s, anew=True)

    def take_control(self, now_s: float, *, drives_beyond: bool) -> None:
        """The body may follow a way that it was given in an earlier life, or has lost its way: let it go to the end of the base.

        Args:
            now_s: when.
            drives_beyond: it may be beyond that end already when it hears of this: what was held before is held until it has
                been seen to obey.
        """
        self._wheels.forget()
        self._obeys = not drives_beyond
        if not self.way.stands:
            self._out.append(Instruct(self._wheels.drive(self.way, self._speed_mps)))
        elif drives_beyond:
            self._out.append(Instruct(self._wheels.finish(self.way)))
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
        """The body has lost its way, or was carried to another place: go on from where it is.

        Args:
            node: where it stands, or the last node that it has passed.
            next_node: the end of the lane that it is on; `node` when it stands there.
            now_s: when.
            past_m: how far it is past `node`.
            speed_mps: how fast.
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
        """Whether nothing is known to lie on the way that it would take to its goal from a node."""
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
        self._held_up_s, self.waited_at_goal_s = None, 0.0
        self._went_round = frozenset()
        self._yielding.begin_leg()
        if self.errand is Errand.OWN:
            self.way.turn_to(way)
        self._settle(now_s)
        self._finish_there()
        return True

    def dock(self, now_s: float) -> None:
        """Stay where it stands until there is another goal: nobody is to ask for room meanwhile."""
        self.docked = True
        self._settle(now_s)

    def rest(self, now_s: float) -> None:
        """There is nothing to do: make room for everybody."""
        self.docked, self._rests = False, True
        self._rank = (RESTING, now_s, self.atv)
        self._settle(now_s)

    def on_passed(self, now_s: float) -> None:
        """The next node of the base was reached."""
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
        """It cannot move until a person has seen to it, or can again."""
        if stuck is not self.stuck:
            self.stuck = stuck
            self._settle(now_s)

    # --- messages --------------------------------------------------------------------------------

    def on_granted(self, sender: str, granted: PlaceGranted, now_s: float) -> None:
        """A keeper has answered, or grants something."""
        if self.wishes.is_anothers(sender, granted):
            self.is_doubled, self._asked = True, set(self.way.held)
            self._settle(now_s, anew=True)
            return
        fresh = self.wishes.on_granted(sender, granted, now_s)
        if fresh is None:
            return
        if granted.removal > self.removal:
            self._begin_anew(granted)
            return
        self._outlook.note(granted, now_s)
        if self._asked and granted.removal == self.removal and self.wishes.is_answered(granted):
            self._asked -= {booking.place for booking in granted.grants}
        self._note_hindrance(granted, now_s)
        unwanted = False
        if not self._obeys:
            self.way.keep(fresh)
        if fresh:
            asked = {place for group in self.wishes.groups(granted.district) for place in group}
            if self.is_placed and self.way.take(place for place in fresh if place in asked):
                self._drive_on(now_s)
            unwanted = any(place not in self.way.held for place in fresh)
            if not unwanted:
                groups = self._groups_in(granted.district, self._groups())
                if not groups:
                    self.wishes.count_as_said(
                        granted.district, self._holds_in(granted.district), (), self._state(now_s)
                    )
        self._settle(now_s, anew_in=granted.district if unwanted else "")

    def on_confirmed(self, sender: str, confirmed: PlaceConfirmed, now_s: float) -> None:
        """The witness of a book has told what it has copied."""
        if not self.wishes.on_confirmed(sender, confirmed):
            self._out.append(Ignore("what is confirmed by somebody who is not to confirm it"))
        self._take_missed(confirmed.district, now_s)

    def repeat_wish(self, district: str, now_s: float) -> None:
        super().repeat_wish(district, now_s)
        self._take_missed(district, now_s)

    def _take_missed(self, district: str, now_s: float) -> bool:
        missed = self.wishes.take_missed(district)
        if missed is not None:
            self.on_granted(*missed, now_s)
        return missed is not None

    def on_silence_told(self, now_s: float) -> None:
        """A keeper has told of silent vehicles: whoever would come to one looks for another way, once on each leg."""
        if self.errand is not Errand.OWN or self.docked or self.way.base_end == self.way.goal:
            return
        ahead = (self.way.base_end, *self.way.beyond)
        needed = {place for lane in pairwise(ahead) for place in self._places.needs(*lane)}
        met = needed & self._surroundings.silent_at(now_s)
        if met <= self._went_round:
            return
        self._went_round |= met
        way = self._ways.way(self.way.base_end, self.goal, self._outlook.prices(now_s))
        if way is not None:
            self.way.turn_to(way)
            self._settle(now_s)

    def on_yield_asked(self, sender: str, asked: YieldAsked, now_s: float) -> None:
        """Somebody wants to come by."""
        if not self.wishes.keeps(sender, asked.district):
            self._out.append(Ignore("asked to make room by somebody who does not keep that book"))
            return
        if not self._holds_in(asked.district):
            # The book is wrong about this vehicle: tell it.
            self._settle(now_s, anew_in=asked.district)
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
        # Who has nowhere to go inherits, too: it comes out with the rank of the one who makes room for it.
        self._yielding.inherit(asked, now_s)
        if way is None:
            self._yielding.refuse(asked.waiting, own[:ROUTE_MAX], self.way.held, now_s)
            self._settle(now_s)
        else:
            self._leave_for(way, now_s)

    def on_yield_refused(self, sender: str, refused: YieldRefused, now_s: float) -> None:
        """Whoever is in the way has nowhere to go."""
        if not self._can_yield or self._held_up_s is None or self.errand is Errand.REST:
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
        """Somebody else keeps a book from now on."""
        if asked.roll_call and not self._obeys:
            # Where the body goes is not known yet; whoever has not told is asked again.
            return
        is_to_tell = self.wishes.on_holds_asked(sender, asked)
        if self._take_missed(asked.district, now_s):
            return
        if not is_to_tell:
            return
        if asked.roll_call:
            self._tell(asked.district, sender, now_s)
        else:
            self._settle(now_s, anew_in=asked.district)

    # --- alarms ----------------------------------------------------------------------------------

    def reroute(self, now_s: float) -> None:
        """Held up for a while: is there a better way by now?"""
        if self._held_up_s is None or self.docked:
            return
        if now_s - max(self._held_up_s, self._aged_s) >= AGES_EVERY_S and self._blocked is Blocked.WAIT:
            self._aged_s = now_s
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

    @property
    def _can_yield(self) -> bool:
        return self.way.stands and self.is_placed and not self.docked and not self.stuck

    def _begin_anew(self, granted: PlaceGranted) -> None:
        """A person has said that it was carried away: nothing that it held is its own any more."""
        self.removal = granted.removal
        told = {booking.place for booking in granted.grants}
        district_of = self._places.district_of
        lost = [place for place in self.holds if district_of[place] == granted.district and place not in told]
        self.is_denied = bool(lost) and not self.way.stands
        self._asked = set(self.way.held)
        for district in self._places.keepers_of:
            self.wishes.open(district)

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
        self.errand = Errand.REFUGE
        self._yielding.leave(way[-1], now_s, refuser=refuser)
        self.way.turn_to(way)
        self._timers.clear(RESTED)
        self._settle(now_s)

    def _reach_refuge(self, now_s: float) -> None:
        self.errand = Errand.REST
        self._timers.set(RESTED, now_s + self._yielding.reach_refuge())

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
        """It stands at its goal: the body is to know that there is nothing more to drive."""
        if self.has_arrived and self._wheels.has_more(self.way):
            self._out.append(Instruct(self._wheels.finish(self.way)))

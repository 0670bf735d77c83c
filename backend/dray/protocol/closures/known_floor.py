"""A plant as one agent knows it: the plant file, and what people have closed, made slow or one-way since.

Every agent has its own, for each hears of a closure at a moment of its own. Whoever asks it for ways is given those that are open by
what the agent knows then; nobody else in the protocol need know of closures to price a transport or to drive.
"""

from __future__ import annotations

from collections.abc import Callable

from msgspec import UNSET, UnsetType
from msgspec.structs import replace

from dray.messages import Closure, Closures, closed_words
from dray.plant import Plant, Routes
from dray.plant.restrictions import OPEN, Ends, Restrictions
from dray.protocol.closures.closure_rules import restrictions_of
from dray.protocol.closures.detours import Detours
from dray.protocol.closures.obstacles import Obstacles
from dray.protocol.runtime.events import NEVER_S

KNOWN = "a list of closures that is no newer than the one that is known"
NOT_SIGNED = "a list of closures that nobody has signed whom this agent trusts"


class KnownFloor(Plant):
    """The plant of one agent.

    Args:
        plant: as it stands in its file; indexes and ways are shared with it.

    Attributes:
        restrictions: of the floor at present.
        said: the newest list that the agent has heard; None for none.
        ends_s: when the next closure ends by itself (plant clock).
        obstacles: what it knows to lie on lanes; whoever changes that calls `note_obstacles`.
        obstructed: the lanes on which something lies.
    """

    def __init__(self, plant: Plant) -> None:
        self.__dict__.update(plant.__dict__)
        self.restrictions = OPEN
        self.said: Closures | None = None
        self.ends_s = NEVER_S
        self.obstacles = Obstacles()
        self.obstructed: frozenset[Ends] = frozenset()
        self._current: dict[str, Routes] = {}

    def note_obstacles(self) -> None:
        """Go by the obstacles as they are known now."""
        if self.obstacles.lanes != self.obstructed:
            self.obstructed = self.obstacles.lanes
            self._current.clear()

    def routes(self, vehicle_type: str, restrictions: Restrictions | None = None) -> Routes:
        """See `Plant.routes`; by default the ways that are open as far as this agent knows."""
        if restrictions is not None:
            return super().routes(vehicle_type, restrictions)
        routes = self._current.get(vehicle_type)
        if routes is None:
            routes = super().routes(vehicle_type, self.restrictions)
            if self.obstructed:
                known = frozenset(ends for ends in self.obstructed if self.roads.lane(*ends) is not None)
                closed = replace(self.restrictions, lanes=self.restrictions.lanes | known)
                routes = Detours(super().routes(vehicle_type, closed), routes, known)
            self._current[vehicle_type] = routes
        return routes

    @property
    def closures_known(self) -> int | UnsetType:
        """The number of the newest list that was heard; UNSET for none."""
        return UNSET if self.said is None else self.said.number

    def objection(self, said: Closures, trusts: Callable[[bytes, bytes], bool] | None) -> str:
        """Why a list changes nothing; empty for one that is to be taken.

        Args:
            said: the list.
            trusts: called with words and a signature: whether it is that of somebody who is trusted; None where only a gateway's word is asked for.
        """
        if self.said is not None and said.number <= self.said.number:
            return KNOWN
        if trusts is not None and not trusts(closed_words(said.number, said.closures), said.signature):
            return NOT_SIGNED
        return ""

    def take(self, said: Closures, now_s: float) -> bool:
        """Go by a list from now on; True when the restrictions are others now."""
        self.said = said
        return self.look(now_s)

    def look(self, now_s: float) -> bool:
        """See what has ended by itself; True when the restrictions are others now."""
        lasting = (
            [] if self.said is None else [each for each in self.said.closures if not _is_over(each, now_s)]
        )
        self.ends_s = min((each.until_s for each in lasting if each.until_s is not None), default=NEVER_S)
        restrictions = restrictions_of(self, lasting)
        if restrictions == self.restrictions:
            return False
        self.restrictions = restrictions
        self._current.clear()
        return True


def _is_over(closure: Closure, now_s: float) -> bool:
    return closure.until_s is not None and now_s >= closure.until_s

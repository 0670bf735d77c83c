"""A plant as one agent knows it: the plant file, with people's closures, speed limits and one-way lanes.

Every agent has its own, because each hears of a closure at a different moment. It gives only ways that are open as
far as the agent knows; so no other code of the protocol has to know closures to price a transport or to drive.
"""

from __future__ import annotations

from msgspec import UNSET, UnsetType
from msgspec.structs import replace

from dray.messages import Closure, Closures, closed_words
from dray.plant import Plant, Routes
from dray.plant.restrictions import OPEN, Ends, Restrictions
from dray.protocol.closures.closure_rules import restrictions_of
from dray.protocol.closures.detours import Detours
from dray.protocol.closures.obstacles import Obstacles
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.runtime.trust import Trusts

KNOWN = "a list of closures that is not newer than the known one"
NOT_SIGNED = "a list of closures without a trusted signature"


class KnownFloor(Plant):
    """The plant of one agent.

    Args:
        plant: the plant of the file; everything of it that is not among the attributes here is shared with it.

    Attributes:
        restrictions: the present restrictions of the floor.
        said: the newest known list; None for none.
        ends_s: when the next closure ends by itself (plant clock).
        obstacles: known obstacles on lanes; code that changes them calls `note_obstacles`.
        obstructed: the lanes with obstacles.
    """

    def __init__(self, plant: Plant) -> None:
        self._share(plant)
        self.restrictions = OPEN
        self.said: Closures | None = None
        self.ends_s = NEVER_S
        self.obstacles = Obstacles()
        self.obstructed: frozenset[Ends] = frozenset()
        self._current: dict[str, Routes] = {}

    def note_obstacles(self) -> None:
        """Apply the present obstacles."""
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
        """The number of the newest known list; UNSET for none."""
        return UNSET if self.said is None else self.said.number

    def objection(self, said: Closures, trusts: Trusts) -> str:
        """Why a list is ignored; empty if it applies.

        Args:
            said: the list.
            trusts: the people whose signatures count.
        """
        if self.said is not None and said.number <= self.said.number:
            return KNOWN
        if not trusts(closed_words(said.number, said.closures), said.signature):
            return NOT_SIGNED
        return ""

    def take(self, said: Closures, now_s: float) -> bool:
        """Apply a list from now on; True if the restrictions have changed."""
        self.said = said
        return self.look(now_s)

    def look(self, now_s: float) -> bool:
        """End closures whose time is over; True if the restrictions have changed."""
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

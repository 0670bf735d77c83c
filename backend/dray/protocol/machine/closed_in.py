"""Whether closures leave a machine's dock without a way, and until when: then its goods cannot leave, and nothing comes."""

from __future__ import annotations

from dataclasses import dataclass

from dray.plant import Routes
from dray.protocol.closures.closure_listener import ClosureListener
from dray.protocol.closures.closure_rules import restrictions_of
from dray.protocol.closures.known_floor import KnownFloor
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.runtime.life import Change, Life
from dray.protocol.runtime.trust import Trusts

SHUT = "what is closed leaves no way to it"


@dataclass(frozen=True, slots=True)
class WaysChanged(Change):
    """Closures have changed, and with them perhaps the ways to and from the dock."""


class ClosedIn(ClosureListener):
    """The closures around one machine.

    Args:
        machine: the machine with the dock.
        floor: as the machine knows it.
        trusts, life: as of every listener.

    Attributes:
        until_s: when the first way to and from the dock opens, as far as closures end by themselves (plant clock);
            `NEVER_S` if none does; -`NEVER_S` while there is a way.
    """

    def __init__(self, machine: str, floor: KnownFloor, trusts: Trusts, life: Life) -> None:
        super().__init__(floor, trusts, life)
        self._machine = machine
        self.until_s = -NEVER_S

    def keeps_late(self, deadline_s: float) -> bool:
        """Whether closures make a deadline impossible."""
        return deadline_s < self.until_s

    def objection(self, deadline_s: float) -> str:
        """Why the machine refuses work with this deadline; empty if it does not."""
        return SHUT if self.keeps_late(deadline_s) else ""

    def _follow(self, now_s: float) -> None:
        self.until_s = self._reopens_s(now_s)
        self._life.note(WaysChanged())

    def _reopens_s(self, now_s: float) -> float:
        floor = self._floor
        said = () if floor.said is None else floor.said.closures
        if self._is_reached(floor.routes(self._type)):
            return -NEVER_S
        for at_s in sorted(
            {each.until_s for each in said if each.until_s is not None and each.until_s > now_s}
        ):
            left = [each for each in said if each.until_s is None or each.until_s > at_s]
            if self._is_reached(floor.routes(self._type, restrictions_of(floor, left))):
                return at_s
        return NEVER_S

    @property
    def _type(self) -> str:
        """The vehicle type whose ways are used: closures are the same for all."""
        return next(iter(self._floor.vehicle_types))

    def _is_reached(self, routes: Routes) -> bool:
        """Whether a way leads to the dock from another one, and from the dock to another one."""
        floor = self._floor
        here = floor.node_of(self._machine)
        others = dict.fromkeys(floor.node_of(place) for place in floor.places)
        others.pop(here, None)
        return any(routes.leads(each, here) for each in others) and any(
            routes.leads(here, each) for each in others
        )

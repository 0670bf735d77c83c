"""Materials by name: who waits for which, in words for people."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

from dray.gateway.live.reasons import told
from dray.gateway.live.views import CauseView, LackView
from dray.messages import MachineHeartbeat, MaterialWait


class Materials:
    """What products take, for telling whose goals wait for what.

    Args:
        names: of all materials, by id.
        bills: by product, the materials of one piece.
    """

    def __init__(self, names: Mapping[str, str], bills: Mapping[str, Collection[str]]) -> None:
        self._names, self._bills = names, dict(bills)

    def note(self, product: str, materials: Collection[str]) -> None:
        """A product takes these from now on."""
        self._bills[product] = materials

    def lacking(self, heartbeat: MachineHeartbeat) -> dict[str, tuple[MaterialWait, ...]]:
        """By goal of a machine that is not made and waits: for what."""
        lacking: dict[str, tuple[MaterialWait, ...]] = {}
        for goal in heartbeat.goals:
            bill = self._bills.get(goal.product, ())
            waits = tuple(wait for wait in heartbeat.waits if wait.item in bill)
            if goal.made < goal.quantity and waits:
                lacking[goal.goal] = waits
        return lacking

    def name(self, material: str) -> str:
        """What people call a material."""
        return self._names.get(material, material)

    def cause(self, waits: Iterable[MaterialWait]) -> CauseView | None:
        """For what somebody waits and why; None for nothing."""
        lacks = tuple(LackView(self.name(wait.item), wait.short, wait.silent) for wait in waits)
        return told(CauseView(lacks=lacks)) if lacks else None

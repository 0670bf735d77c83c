"""Materials by name, and the waits for them in words for people."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

from dray.gateway.live.reasons import told
from dray.gateway.live.views import CauseView, LackView
from dray.messages import MachineHeartbeat, MaterialWait


class Materials:
    """The materials that products take, to tell which goals wait for which.

    Args:
        names: names of all materials, by id.
        bills: per product, the materials of one piece.
    """

    def __init__(self, names: Mapping[str, str], bills: Mapping[str, Collection[str]]) -> None:
        self._names, self._bills = names, dict(bills)

    def note(self, product: str, materials: Collection[str]) -> None:
        """Set a product's materials."""
        self._bills[product] = materials

    def forget(self, product: str) -> None:
        """Forget a product's materials; harmless if it has none."""
        self._bills.pop(product, None)

    def lacking(self, heartbeat: MachineHeartbeat) -> dict[str, tuple[MaterialWait, ...]]:
        """Per unfinished goal of a machine, the materials that it waits for."""
        lacking: dict[str, tuple[MaterialWait, ...]] = {}
        for goal in heartbeat.goals:
            bill = self._bills.get(goal.product, ())
            waits = tuple(wait for wait in heartbeat.waits if wait.item in bill)
            if goal.made < goal.quantity and waits:
                lacking[goal.goal] = waits
        return lacking

    def name(self, material: str) -> str:
        """The name of a material for people."""
        return self._names.get(material, material)

    def cause(self, waits: Iterable[MaterialWait]) -> CauseView | None:
        """The cause of a wait for materials; None without any."""
        lacks = tuple(LackView(self.name(wait.item), wait.short, wait.silent) for wait in waits)
        return told(CauseView(lacks=lacks)) if lacks else None

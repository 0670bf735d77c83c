"""Goods and things on board of failed vehicles: people are asked to hand them over, and decide about them.

For each load the coordinator calls a person to its place (`protocol.calls`). The call ends when the load is handed
over, written off or given up, or its vehicle goes on (`takeover.left_aboard`). A vehicle that calls a person itself
needs no second call.
"""

from __future__ import annotations

from math import hypot
from typing import cast

from dray.messages import CommandRefusal, Problem, ProblemKind, Reason, Transport
from dray.plant import Plant
from dray.protocol.calls.help_calls import HelpCalls
from dray.protocol.contract_net.task import OpenTask
from dray.protocol.transports.held import HeldTransports
from dray.protocol.transports.transports import Transports

LEFT_ABOARD = Problem(kind=ProblemKind.LOAD, needs_person=True)
"""The reason of a call for goods."""


class GoodsRecovery:
    """The recovery of one coordinator's loads.

    Args:
        plant: the nodes where vehicles can be sent.
        tasks: its transports.
        held: transports and doubtful loads that a person must look for; they are called for alike.
    """

    def __init__(self, plant: Plant, tasks: Transports, held: HeldTransports) -> None:
        self._held = held
        self._plant = plant
        self._tasks = tasks
        self._aboard = tasks.failover.aboard

    def update_calls(self, calls: HelpCalls, now_s: float, *, expected: bool) -> None:
        """Open and close the calls for these loads.

        Args:
            calls: the coordinator's calls.
            now_s: the present time.
            expected: False for an agent that leaves: its next life calls.
        """
        if expected:
            self._held.update(now_s)
        waiting = [task for task in self._tasks if expected and _needs_person(task, now_s)]
        held = self._held.names() if expected else ()
        called_for = {*held, *(task.id for task in waiting)}
        for goods in [each for each in calls.goods if each not in called_for]:
            calls.close(now_s, goods=goods)
        if expected:
            self._held.call(calls, now_s)
        for task in waiting:
            atv = task.primary if task.stranded is None else task.stranded.atv
            what = "a thing" if task.is_thing else f"{cast(Transport, task.work).quantity} {task.work_item}"
            reason = f"{what} on board of {atv}"
            calls.open(LEFT_ABOARD, reason, now_s, goods=task.id, place_m=self.place_m(task.id))

    def names(self, now_s: float) -> tuple[str, ...]:
        """Transports whose loads wait for a person whom their vehicle has not called."""
        return tuple(task.id for task in self._tasks if _needs_person(task, now_s))

    def fetch(self, task: str, node: str, now_s: float) -> CommandRefusal | None:
        """A person hands goods over at a node. Returns the refusal; None when they are fetched there now.

        Args:
            task: their transport.
            node: the node; empty for the nearest one beside the vehicle.
            now_s: the present time.
        """
        node = node or self._beside(self._aboard.node_of(task))
        return self._aboard.fetch(task, node, now_s) if node in self._nodes else CommandRefusal.NO_SUCH_NODE

    @property
    def _nodes(self) -> tuple[str, ...]:
        """Nodes where vehicles can be sent, without places."""
        return tuple(node for node in self._plant.stops if not self._plant.has_place(node))

    def _beside(self, node: str) -> str:
        """The nearest other node for a second vehicle, if possible without a dock; empty if there is none."""
        here = self._plant.nodes.get(node)
        docks = {self._plant.node_of(place) for place in self._plant.places}

        def away(other: str) -> tuple[bool, float]:
            spot = self._plant.nodes[other]
            x_m, y_m = (spot.x_m, spot.y_m) if here is None else (here.x_m, here.y_m)
            return other in docks, hypot(spot.x_m - x_m, spot.y_m - y_m)

        return min((other for other in self._nodes if other != node), key=away, default="")

    def write_off(self, task: str, now_s: float) -> CommandRefusal | None:
        """A person writes goods off. Returns the refusal; None when they are made again now."""
        return self._aboard.write_off(task, now_s)

    def place_m(self, task: str) -> tuple[float, float] | None:
        """Their position (x, y) in m; None if unknown."""
        node = self._plant.nodes.get(self._aboard.node_of(task))
        return None if node is None else (node.x_m, node.y_m)


def _needs_person(task: OpenTask, now_s: float) -> bool:
    """Whether goods wait for a person whom their vehicle has not called, and are not handed over."""
    if task.stranded is None or task.stranded.handed_at:
        return False
    detector = task.contract.detector
    calls_itself = detector is not None and detector.last is not None and bool(detector.last.problem)
    return detector is None or not calls_itself or detector.failure(now_s) is Reason.SILENT

"""Which vehicles can be heard: some have lost their WLAN and have no neighbour that could relay for them."""

from __future__ import annotations

import asyncio
from math import hypot

from dray.messages import Link, Reason
from dray.messages.fact import CarrierChanged, TookOver
from dray.protocol.runtime.events import NEVER_S
from dray_sim.network.radio import RADIO
from dray_sim.run.stage import Stage

LOOK_S = 0.5
"""A vehicle drives less than a metre in this time."""

LATELY_S = 5.0
"""Longer than the silence that a takeover follows on."""


class Reach:
    """Looks at the whole floor, as no agent can, and judges suspicions of living vehicles.

    Args:
        stage: the run.

    Attributes:
        in_reach: tasks taken from a vehicle that lived and could be heard; there should be none.
        out_of_reach: tasks taken from a living vehicle that no agent could hear.
    """

    def __init__(self, stage: Stage) -> None:
        self.in_reach: list[str] = []
        self.out_of_reach: list[str] = []
        self._stage = stage
        self._unheard_s: dict[str, float] = {}
        self._judged: set[tuple[str, int]] = set()

    async def watch(self) -> None:
        """Look until cancelled."""
        await asyncio.gather(self._look(), self._judge_takeovers(), self._judge_auctions())

    async def _look(self) -> None:
        while True:
            self._unheard_s.update(dict.fromkeys(_unheard(self._stage), self._stage.now_s()))
            await asyncio.sleep(LOOK_S)

    async def _judge_takeovers(self) -> None:
        while True:
            took = await self._stage.witness.first(TookOver, within_s=NEVER_S)
            if took is not None and took.said.reason == Reason.SILENT:
                self._judge(took.said.task, took.said.epoch, took.said.primary, took.at_s)

    async def _judge_auctions(self) -> None:
        while True:
            changed = await self._stage.witness.first(CarrierChanged, within_s=NEVER_S)
            if changed is not None and changed.said.reason == Reason.SILENT:
                self._judge(changed.said.task, changed.said.epoch, changed.said.replaced, changed.at_s)

    def _judge(self, task: str, epoch: int, replaced: str, at_s: float) -> None:
        # The secondary and then the coordinator report one and the same change.
        if (task, epoch) in self._judged or not self._stage.factory.running(replaced):
            return
        self._judged.add((task, epoch))
        lately = at_s - self._unheard_s.get(replaced, -LATELY_S) <= LATELY_S
        (self.out_of_reach if lately else self.in_reach).append(task)


def _unheard(stage: Stage) -> list[str]:
    """Vehicles on the mesh from which no way leads over others to one that has WLAN."""
    senses = {atv: vehicle.sense() for atv, vehicle in stage.factory.vehicles.items()}
    lost = [atv for atv, sense in senses.items() if sense.link is Link.MESH]
    if not lost:
        return []
    heard = {
        atv: 0 for atv, sense in senses.items() if sense.link is Link.WLAN and stage.factory.running(atv)
    }
    waiting = list(heard)
    for atv in waiting:
        here = senses[atv].pose
        for other in lost:
            there = senses[other].pose
            near = hypot(here.x_m - there.x_m, here.y_m - there.y_m) <= RADIO.range_m
            if other not in heard and near and heard[atv] < RADIO.hops:
                heard[other] = heard[atv] + 1
                waiting.append(other)
    return [atv for atv in lost if atv not in heard]

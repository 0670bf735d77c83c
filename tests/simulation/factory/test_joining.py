"""A machine that no plant file knows joins a running factory: it is given goals, fed, and emptied, like all others."""

from __future__ import annotations

import asyncio

import pytest
from msgspec.structs import replace

from dray.errors import PlantError
from dray.messages import MachineHeartbeat
from dray.messages.fact import GoalContracted, GoalLost, GoodsDelivered, OrderFulfilled, TaskClosed
from dray.messages.keys import STRATEGIST
from dray.plant import Plant, default_plant, with_machine
from dray_sim.bodies.floor import NEARLY_EMPTY_FRAC
from dray_sim.run.evidence import HELD
from dray_sim.run.stage import Shift, Stage, play

JOINING = default_plant().machines["M3"]
PRODUCT = JOINING.makes[0].product

PLANT = Plant(
    replace(
        default_plant().file,
        machines=tuple(spec for spec in default_plant().machines.values() if spec.id != JOINING.id),
    )
)
"""As it was before M3 was bought."""

KEPT = (GoalContracted, GoalLost, GoodsDelivered, OrderFulfilled, TaskClosed)
SHIFT = Shift("joining", 1e5, codec=True, stock_frac=NEARLY_EMPTY_FRAC, keep=KEPT)

JOIN_S = 30.0
HOUR_S = 3600.0


async def _contracted(stage: Stage) -> str:
    """Let M3 join and order so much that all are needed; the first goal that it is given."""
    await stage.until_s(JOIN_S)
    stage.factory.add_machine(JOINING)
    await stage.until_s(2 * JOIN_S)
    makers = (*PLANT.machines_for(PRODUCT), JOINING.id)
    stage.order(PRODUCT, len(makers) * PLANT.products[PRODUCT].lot)
    seen = await stage.witness.first(GoalContracted, lambda fact: fact.machine == JOINING.id, within_s=HOUR_S)
    assert seen is not None
    return seen.said.goal


async def _delivered_of(stage: Stage, goal: str) -> int:
    seen = await stage.witness.first(GoodsDelivered, lambda fact: fact.goal == goal, within_s=2 * HOUR_S)
    return 0 if seen is None else seen.said.delivered


def test_a_joining_machine_is_given_a_goal_fed_and_emptied() -> None:
    async def script(stage: Stage) -> MachineHeartbeat:
        goal = await _contracted(stage)
        assert await _delivered_of(stage, goal) == PLANT.products[PRODUCT].lot
        await stage.settle(2 * HOUR_S)
        assert not stage.undelivered()
        brought = [seen for seen in stage.witness.all(TaskClosed) if seen.agent == JOINING.id]
        assert {seen.said.outcome for seen in brought} == {"delivered"}
        assert {seen.said.carrier for seen in brought} <= set(PLANT.fleet)
        return stage.witness.machines[JOINING.id]

    played = play(SHIFT, PLANT, 1, script)
    assert played.invariants == HELD
    heartbeat = played.result
    assert heartbeat is not None
    assert heartbeat.joining is not None
    assert heartbeat.joining.node == JOINING.node


def test_machines_of_the_plant_file_do_not_introduce_themselves() -> None:
    async def script(stage: Stage) -> None:
        await stage.until_s(JOIN_S)
        assert all(heartbeat.joining is None for heartbeat in stage.witness.machines.values())

    assert play(SHIFT, PLANT, 1, script).invariants == HELD


@pytest.mark.slow
def test_a_joining_machine_and_a_strategist_that_are_started_anew_go_on() -> None:
    async def script(stage: Stage) -> None:
        goal = await _contracted(stage)
        for agent in (STRATEGIST, JOINING.id):
            stage.factory.crash(agent)
            await asyncio.sleep(2.0)
            stage.factory.restart(agent)
        assert await _delivered_of(stage, goal) == PLANT.products[PRODUCT].lot
        await stage.settle(2 * HOUR_S)
        assert not stage.undelivered()
        assert stage.witness.all(GoalLost) == []

    assert play(SHIFT, PLANT, 1, script).invariants == HELD


@pytest.mark.slow
@pytest.mark.parametrize("strategist_too", [False, True])
def test_the_goals_of_a_joining_machine_that_fails_go_to_others(strategist_too: bool) -> None:
    async def script(stage: Stage) -> None:
        goal = await _contracted(stage)
        stage.factory.power_off(JOINING.id)
        if strategist_too:
            # Its next life has never heard of the joining machine.
            stage.factory.restart(STRATEGIST)
        lost = await stage.witness.first(GoalLost, within_s=HOUR_S)
        assert lost is not None
        assert (lost.said.goal, lost.said.machine) == (goal, JOINING.id)
        await stage.settle(4 * HOUR_S)
        assert not stage.undelivered()

    assert play(SHIFT, PLANT, 1, script).invariants == HELD


def test_a_machine_that_does_not_fit_is_refused_by_the_field() -> None:
    with pytest.raises(PlantError, match=r"new\.yaml: machines\[11\]\.node: there is no nowhere in `nodes`"):
        with_machine(PLANT, replace(JOINING, node="nowhere"), "new.yaml")
    with pytest.raises(PlantError, match=r"M1 is the id of"):
        with_machine(PLANT, replace(JOINING, id="M1"), "new.yaml")
    assert with_machine(PLANT, JOINING, "new.yaml").machines["M3"] == JOINING

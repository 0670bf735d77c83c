"""The operators of a factory: one for every area."""

from __future__ import annotations

from collections.abc import Mapping
from random import Random
from typing import TYPE_CHECKING

from dray.messages.kinds import Kind
from dray_sim.people.areas import EVERYWHERE
from dray_sim.people.floor_office import FloorOffice
from dray_sim.people.habits import Habits
from dray_sim.people.hands import Hands
from dray_sim.people.operators import Operator

if TYPE_CHECKING:
    from dray_sim.factory.sim_factory import SimFactory


def hire(
    factory: SimFactory,
    *,
    seed: int,
    habits: Habits | None = None,
    areas: Mapping[str, Habits] | None = None,
    office: FloorOffice | None = None,
) -> tuple[Operator, ...]:
    """One operator for every area of a factory; the caller lets them `run`.

    Args:
        factory: where they work.
        seed: each operator draws from a generator of its own that follows from it.
        habits: of all operators.
        areas: habits of single operators, by area, in place of those.
        office: see `Operator`.
    """
    of_all = habits or Habits()
    special = areas or {}
    hands = Hands(factory)
    crew = {
        area: Operator(
            area,
            plant=factory.plant,
            bus=factory.bus,
            clock=factory.clock,
            authority=factory.authority,
            hands=hands,
            random=Random(f"{seed} operator {area}"),
            habits=special.get(area, of_all),
            office=office,
            careless=Random(f"{seed} operator {area} careless"),
        )
        for area in factory.plant.areas or (EVERYWHERE,)
    }
    for operator in crew.values():
        operator.colleagues = crew
        factory.bus.kinds[operator.duty.agent_id] = Kind.OPERATOR
    return tuple(crew.values())

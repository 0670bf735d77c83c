"""A shift that is played in the plant editor, and the figures of the same hours: one shift is told by one number."""

from __future__ import annotations

from itertools import pairwise

import msgspec
import pytest
from wall_clock import NOW_S

from dray.gateway.factory.figure_sampler import SAMPLE_S, added
from dray.gateway.factory.figures import points
from dray.gateway.factory.shift_player import figures_of
from dray.gateway.live.projection import Projection
from dray.gateway.live.timescale import TimeScale
from dray.messages.keys import Keys
from dray.plant import load_plant
from dray.store.factory.kpis import KpiSample
from dray_sim.run.stage import Shift, Stage, play
from dray_sim.scenarios.day import SHIFT

LENGTH_S = 3600.0

STEP_S = 60.0
"""Of the charts of an hour, in wall seconds."""

SEED = 1


@pytest.mark.parametrize("speed", [1.0, 5.0])
def test_the_transports_an_hour_of_a_played_shift_are_those_of_the_figures_of_the_same_hours(
    speed: float,
) -> None:
    plant = load_plant("workshop")
    projection = Projection(plant.file, TimeScale(0.0, NOW_S, speed))
    minutes = int(LENGTH_S / (SAMPLE_S * speed))

    async def look(stage: Stage) -> list[KpiSample]:
        session = stage.factory.bus.join("panel", lambda _sender, message: projection.fold(message))
        session.subscribe(Keys(plant.id).all_heartbeats)
        session.subscribe(Keys(plant.id).all_events)
        totals = [projection.totals(NOW_S)]
        for minute in range(1, minutes + 1):
            await stage.until_s(minute * SAMPLE_S * speed)
            totals.append(projection.totals(NOW_S + minute * SAMPLE_S))
        return totals

    shift = Shift(name=SHIFT.name, duration_s=LENGTH_S, load=SHIFT.load)
    played = play(shift, plant, SEED, look)
    assert played.result is not None
    steps = list(points([added(*each) for each in pairwise(played.result)], STEP_S))
    editor = figures_of(msgspec.to_builtins(played.report))

    # As the panel sums it up ("over all steps").
    over_all = sum(step.transports for step in steps) * 3600.0 / sum(step.span_s for step in steps)
    assert editor.transports_per_h == pytest.approx(over_all, rel=0.001)
    # Of few minutes it is another number, and no step is the shift.
    each = [step.transports_per_hour for step in steps if step.transports_per_hour is not None]
    assert min(each) < 0.8 * over_all < 1.2 * over_all < max(each)

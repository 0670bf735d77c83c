"""The plant's clock and the wall's."""

from __future__ import annotations

import asyncio
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dray.gateway.live.timescale import LOOK_S, TimeScale, wait_until
from dray_sim.clock.loop import clock, run


def test_both_epochs_are_the_same_moment() -> None:
    time = TimeScale(plant_epoch_s=100.0, wall_epoch_s=1_900_000_000.0, speed=50.0)
    assert time.to_wall_s(100.0) == 1_900_000_000.0
    assert time.to_plant_s(1_900_000_000.0) == 100.0


def test_a_fast_factory_lives_long_in_a_short_time() -> None:
    time = TimeScale(plant_epoch_s=0.0, wall_epoch_s=1000.0, speed=50.0)
    assert time.to_wall_s(3600.0) == 1072.0
    assert time.to_plant_s(1060.0) == 3000.0


def test_what_was_before_the_epoch_has_its_time_too() -> None:
    time = TimeScale(plant_epoch_s=10.0, wall_epoch_s=1000.0, speed=2.0)
    assert time.to_wall_s(0.0) == 995.0
    assert time.to_plant_s(995.0) == 0.0


def test_where_the_plants_clock_has_stood_what_it_shows_is_later_on_the_wall() -> None:
    time = TimeScale(plant_epoch_s=0.0, wall_epoch_s=1000.0, speed=10.0)
    called_at_s = 1060.0  # The plant was at 500 s then, though 600 s were due.
    time.stood(10.0)
    assert time.to_plant_s(called_at_s) == 500.0
    assert time.to_wall_s(501.0) > called_at_s, "what follows a call is not told before it"


@given(
    plant_s=st.floats(-1e6, 1e6),
    epoch_s=st.floats(0.0, 1e6),
    speed=st.floats(0.01, 1000.0),
)
def test_there_and_back_is_the_same_moment(plant_s: float, epoch_s: float, speed: float) -> None:
    time = TimeScale(epoch_s, 1_900_000_000.0, speed)
    # Seconds since 1970 are kept to some 0.2 microseconds; a fast factory's clock is so much coarser.
    assert math.isclose(
        time.to_plant_s(time.to_wall_s(plant_s)), plant_s, rel_tol=1e-9, abs_tol=1e-6 * (1 + speed)
    )


@given(earlier_s=st.floats(-1e6, 1e6), later_s=st.floats(-1e6, 1e6), speed=st.floats(0.01, 1000.0))
def test_neither_clock_goes_back(earlier_s: float, later_s: float, speed: float) -> None:
    earlier_s, later_s = sorted((earlier_s, later_s))
    time = TimeScale(0.0, 1_900_000_000.0, speed)
    assert time.to_wall_s(earlier_s) <= time.to_wall_s(later_s)
    assert time.to_plant_s(earlier_s) <= time.to_plant_s(later_s)


@pytest.mark.parametrize("speed", [0.0, -1.0, math.nan])
def test_a_clock_that_does_not_go_on_is_refused(speed: float) -> None:
    with pytest.raises(ValueError, match="above 0"):
        TimeScale(0.0, 0.0, speed)


def test_a_moment_of_the_wall_clock_is_waited_for_whatever_is_done_to_the_clock() -> None:
    async def main() -> tuple[float, float]:
        loop, ahead_s = asyncio.get_running_loop(), 0.0
        told = asyncio.create_task(wait_until(100.0, lambda: clock().now_s() + ahead_s))
        await asyncio.sleep(30.0)
        ahead_s = -30.0
        await asyncio.sleep(75.0)
        assert not told.done()
        ahead_s = 0.0
        await told
        late_s = loop.time()
        await asyncio.wait_for(wait_until(math.inf, loop.time, _set_at(loop, late_s + 7.0)), 8.0)
        return late_s, loop.time()

    set_s, news_s = run(main())
    assert 105.0 <= set_s <= 105.0 + LOOK_S
    assert news_s == set_s + 7.0


def _set_at(loop: asyncio.AbstractEventLoop, at_s: float) -> asyncio.Event:
    news = asyncio.Event()
    loop.call_at(at_s, news.set)
    return news

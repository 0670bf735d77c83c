"""Machines that join are judged outside of the event loop, whatever people define meanwhile."""

from __future__ import annotations

import asyncio

import pytest
from fake_bus import PLANT
from gateway_kit import House, gateway
from joining_kit import BEFORE, SPEC, introduction, introduction_of
from loop_monitor import Tries, be, loop_monitor
from msgspec.structs import replace

from dray.gateway.http.provided import provided
from dray.gateway.live import joinings as joinings_module
from dray.gateway.live.joinings import TRIES, Joinings
from dray.gateway.live.projection.site import Site
from dray.plant import MachineSpec, Plant, load_plant

pytestmark = pytest.mark.anyio

STEP_MS = 20.0
"""Processor time that a step of the loop may take."""

LARGE = replace(load_plant("large").file, plant=PLANT.plant)
"""Under the name of the plant whose messages the bus of these tests carries."""

JOINING = LARGE.machines[-3:]
"""The least of their steps counts."""


async def _join(house: House, spec: MachineSpec) -> None:
    be(spec.id)
    house.bus.say(introduction_of(spec))
    await provided(house.app, Joinings).waiting.join()


async def test_no_step_of_the_loop_is_long_when_a_machine_joins_the_largest_plant_that_we_ship(
    url: str,
) -> None:
    tries = Tries()
    async with gateway(url, plant=replace(LARGE, machines=LARGE.machines[: -len(JOINING)])) as house:
        for spec in JOINING:
            with loop_monitor() as monitor:
                await asyncio.create_task(_join(house, spec))
            assert house.projection.site.plant.machines[spec.id] == spec
            tries.note(max(monitor.longest_s.values()), monitor.yardstick_s)
    print(f"a machine joins the plant large | {tries.least_ms:.1f} ms")  # noqa: T201 - for `pytest -s`
    assert tries.least_ms <= STEP_MS


@pytest.mark.parametrize("changes", [1, TRIES, TRIES + 1])
async def test_a_machine_joins_and_products_stay_that_people_define_meanwhile(
    url: str, monkeypatch: pytest.MonkeyPatch, changes: int
) -> None:
    async with gateway(url, plant=BEFORE) as house:
        site, loop, left = house.projection.site, asyncio.get_running_loop(), changes
        joined = joinings_module.joined

        async def define() -> None:
            # The same products again: a new plant all the same.
            site.plant = site.plant.with_products(site.plant.file)

        def judged(plant: Plant, spec: MachineSpec) -> Plant | None:
            nonlocal left
            if left:
                left -= 1
                asyncio.run_coroutine_threadsafe(define(), loop).result()
            return joined(plant, spec)

        monkeypatch.setattr(joinings_module, "joined", judged)
        house.bus.say(introduction())
        await provided(house.app, Joinings).waiting.join()
        assert site.plant.machines[SPEC.id] == SPEC
        assert left == max(0, changes - TRIES)


async def test_a_machine_that_does_not_fit_changes_nothing_and_the_next_one_joins(url: str) -> None:
    async with gateway(url, plant=BEFORE) as house:
        before = house.projection.site.plant
        house.bus.say(introduction("X1", node="nowhere"))
        await provided(house.app, Joinings).waiting.join()
        assert house.projection.site.plant is before
        house.bus.say(introduction())
        await provided(house.app, Joinings).waiting.join()
        assert SPEC.id in house.projection.site.plant.machines


def test_without_a_gateway_a_machine_joins_at_once() -> None:
    site = Site(BEFORE)
    site.on_heartbeat(introduction())
    assert site.plant.machines[SPEC.id] == SPEC

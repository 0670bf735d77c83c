"""The fault injector of `dray up`: faults that are begun in one thread happen in another."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine, Iterator
from typing import Any

import pytest

from dray.cli.simulation.fault_injection import SimFaultInjector
from dray.errors import UnavailableError
from dray.gateway.factory.fault_injection import FaultRefused
from dray.plant import default_plant
from dray_sim.clock.loop import clock, paced
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.faults import Faults
from dray_sim.faults.kinds import KIND_NAMES
from dray_sim.network.bridge import SimThread

NOW_S = 1_900_000_000.0


@pytest.fixture
def thread() -> Iterator[SimThread[Faults]]:
    async def live(ready: Callable[[Faults], None]) -> None:
        factory = SimFactory(default_plant(), clock(), seed=1)
        ready(Faults(factory))
        await factory.run()

    thread: SimThread[Faults] = SimThread(live, paced(10.0))
    yield thread
    thread.stop()


@pytest.fixture
def faults(thread: SimThread[Faults]) -> Faults:
    """To be looked at only: they belong to the other thread."""
    return thread.start(60.0)


@pytest.fixture
def injector(thread: SimThread[Faults], faults: Faults) -> SimFaultInjector:
    return SimFaultInjector(faults, thread.loop, lambda: NOW_S)


def run(call: Coroutine[Any, Any, Any]) -> Any:
    return asyncio.run(call)


def test_every_kind_of_fault_is_offered_with_its_fields(injector: SimFaultInjector) -> None:
    kinds = {kind.kind: kind for kind in injector.kinds}
    assert tuple(kinds) == KIND_NAMES
    assert (kinds["vehicle_broken"].fields, kinds["vehicle_broken"].optional) == (
        ("atv",),
        ("reason", "problem"),
    )
    assert all(kind.what for kind in injector.kinds)


def test_a_fault_has_happened_when_it_is_answered_and_is_over_when_it_is_ended(
    injector: SimFaultInjector, faults: Faults
) -> None:
    begun = run(injector.begin({"kind": "powered_off", "agent": "ATV3"}))
    assert (begun.kind, begun.agents, begun.began_at_s) == ("powered_off", ("ATV3",), NOW_S)
    assert begun.fault == {"kind": "powered_off", "agent": "ATV3"}
    assert list(faults.active) == [begun.id]
    assert not faults.world.running("ATV3")
    for _ in range(2):
        run(injector.end(begun.id))
    assert not faults.active
    assert faults.world.running("ATV3")


def test_a_fault_of_the_network_is_about_those_that_it_names(injector: SimFaultInjector) -> None:
    one = run(injector.begin({"kind": "link_trouble", "sender": "ATV3", "loss_frac": 0.2}))
    assert one.agents == ("ATV3",)
    assert run(injector.begin({"kind": "partition", "groups": [["ATV*"]]})).agents == ()


@pytest.mark.parametrize(
    ("fault", "field"),
    [
        ({"kind": "powered_off", "agent": "ATV99"}, "agent"),
        ({"kind": "load_shifted", "atv": "ATV1"}, "atv"),
        ({"kind": "powered_off"}, "body"),
        ({"kind": "powered_off", "agent": "ATV1", "why": "so"}, "body"),
        ({"kind": "powered_off", "agent": 7}, "agent"),
        ({"kind": "fly"}, "kind"),
        ({"kind": "link_trouble", "loss_frac": 2}, "loss_frac"),
    ],
)
def test_a_fault_that_makes_no_sense_is_refused_at_its_field(
    injector: SimFaultInjector, faults: Faults, fault: dict[str, Any], field: str
) -> None:
    with pytest.raises(FaultRefused) as refused:
        run(injector.begin(fault))
    assert refused.value.field == field
    assert refused.value.reason
    assert not faults.active


def test_a_factory_that_has_ended_does_not_answer(
    thread: SimThread[Faults], injector: SimFaultInjector
) -> None:
    thread.stop()
    with pytest.raises(UnavailableError, match="has ended"):
        run(injector.begin({"kind": "powered_off", "agent": "ATV3"}))

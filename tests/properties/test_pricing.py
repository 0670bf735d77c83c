"""Prices move the way they should, wherever a vehicle stands."""

from __future__ import annotations

import msgspec
import pytest
from defaults import PLANT
from hypothesis import given
from hypothesis import strategies as st
from spoken import transport

from dray.messages import Refusal
from dray.protocol.vehicle.pricing import Pricer, Quote, Unable, low_battery_s

LIGHT = Pricer(PLANT, "light")
NODES = st.sampled_from(sorted(PLANT.nodes))
FRACS = st.floats(min_value=0.0, max_value=1.0)
SOURCES = st.lists(st.sampled_from(sorted(PLANT.storages)), min_size=1, unique=True).map(tuple)
DESTINATIONS = st.sampled_from(sorted(PLANT.machines))
SPANS_S = st.floats(min_value=0.0, max_value=600.0)
NO_DEADLINE_S = float("inf")


def answer(
    node: str,
    sources: tuple[str, ...],
    destination: str,
    *,
    battery_frac: float = 1.0,
    node_at_s: float = 0.0,
    deadline_s: float = NO_DEADLINE_S,
) -> Quote | Unable:
    return LIGHT.quote(
        transport(sources=sources, destination=destination),
        node=node,
        node_at_s=node_at_s,
        battery_frac=battery_frac,
        now_s=0.0,
        deadline_s=deadline_s,
    )


def quote(node: str, sources: tuple[str, ...], destination: str, node_at_s: float = 0.0) -> Quote:
    found = answer(node, sources, destination, node_at_s=node_at_s)
    assert isinstance(found, Quote)
    return found


@given(NODES, SOURCES, DESTINATIONS, FRACS, FRACS)
def test_an_emptier_battery_is_never_cheaper_and_never_abler(
    node: str, sources: tuple[str, ...], destination: str, one_frac: float, other_frac: float
) -> None:
    low, high = sorted((one_frac, other_frac))
    emptier = answer(node, sources, destination, battery_frac=low)
    fuller = answer(node, sources, destination, battery_frac=high)
    if isinstance(emptier, Quote):
        assert isinstance(fuller, Quote)
        assert fuller.cost.total_s <= emptier.cost.total_s
    else:
        assert emptier.reason is Refusal.BATTERY


@given(NODES, SOURCES, DESTINATIONS, SPANS_S, SPANS_S)
def test_a_vehicle_that_is_free_later_is_dearer_and_done_later(
    node: str, sources: tuple[str, ...], destination: str, one_s: float, other_s: float
) -> None:
    sooner_s, later_s = sorted((one_s, other_s))
    sooner = quote(node, sources, destination, sooner_s)
    later = quote(node, sources, destination, later_s)
    assert sooner.cost.total_s <= later.cost.total_s + 1e-9
    assert sooner.finish_s <= later.finish_s + 1e-9


@given(NODES, SOURCES, DESTINATIONS)
def test_the_parts_of_a_price_add_up_and_none_is_negative(
    node: str, sources: tuple[str, ...], destination: str
) -> None:
    cost = quote(node, sources, destination).cost
    parts = (cost.empty_way_s, cost.loaded_way_s, cost.energy_s, cost.suitability_s)
    assert cost.total_s == pytest.approx(sum(parts))
    assert min(parts) >= 0.0


@given(NODES, SOURCES, DESTINATIONS)
def test_more_sources_are_never_dearer_and_one_of_them_is_offered(
    node: str, sources: tuple[str, ...], destination: str
) -> None:
    best = quote(node, sources, destination)
    assert best.source in sources
    assert best.cost.total_s == min(quote(node, (source,), destination).cost.total_s for source in sources)


@given(NODES, SOURCES, DESTINATIONS, SPANS_S)
def test_what_is_quoted_is_done_by_the_deadline_and_what_is_refused_is_not(
    node: str, sources: tuple[str, ...], destination: str, deadline_s: float
) -> None:
    free = quote(node, sources, destination)
    found = answer(node, sources, destination, deadline_s=deadline_s)
    if free.finish_s <= deadline_s:
        assert found == free
    else:
        assert isinstance(found, Unable)
        assert found.reason is Refusal.DEADLINE


@given(FRACS, FRACS)
def test_the_premium_grows_as_the_battery_empties(one_frac: float, other_frac: float) -> None:
    low, high = sorted((one_frac, other_frac))
    assert low_battery_s(high) <= low_battery_s(low)


@given(NODES, SOURCES, DESTINATIONS, FRACS)
def test_a_price_depends_on_nothing_but_its_arguments(
    node: str, sources: tuple[str, ...], destination: str, battery_frac: float
) -> None:
    first = answer(node, sources, destination, battery_frac=battery_frac)
    fresh = Pricer(PLANT, "light").quote(
        transport(sources=sources, destination=destination),
        node=node,
        node_at_s=0.0,
        battery_frac=battery_frac,
        now_s=0.0,
        deadline_s=NO_DEADLINE_S,
    )
    assert msgspec.json.encode(first) == msgspec.json.encode(fresh)

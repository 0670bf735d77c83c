"""Agents of the last version and of this one work together, and what would end that is told."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path
from random import Random
from typing import Any

import pytest
from hypothesis import given, settings
from utterances import Utterances

from dray.codec import decode, encode
from dray.messages import Message
from dray.plant import default_plant
from dray.wire.compatibility import breaks
from dray.wire.documents import RELEASED, current
from dray_sim.clock.loop import clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.people import demand
from dray_sim.people.order_client import OrderClient
from dray_sim.run.trace import Trace

FOLDER = Path(__file__).parents[2] / "docs" / "wire"

SPAN_S = 1800.0
"""Of a busy shift: everything that is said in an ordinary day is said by then."""

Schemas = dict[str, Any]


def test_this_version_speaks_with_the_last_one() -> None:
    released = json.loads((FOLDER / RELEASED).read_text(encoding="utf-8"))
    assert breaks(released, current()) == [], "see docs/wire/README.md"


# --- what a change breaks ----------------------------------------------------------------------------


def add(field: str, *, required: bool) -> Callable[[Schemas], None]:
    def change(new: Schemas) -> None:
        new["Handover"]["properties"][field] = {"type": "integer"}
        if required:
            new["Handover"]["required"].append(field)

    return change


def drop(part: str, field: str) -> Callable[[Schemas], None]:
    def change(new: Schemas) -> None:
        del new[part]["properties"][field]
        new[part]["required"] = [name for name in new[part]["required"] if name != field]

    return change


def put(part: str, field: str, **schema: Any) -> Callable[[Schemas], None]:
    def change(new: Schemas) -> None:
        new[part]["properties"][field].update(schema)

    return change


def forget(part: str) -> Callable[[Schemas], None]:
    return lambda new: new.pop(part)


def need(field: str) -> Callable[[Schemas], None]:
    return lambda new: new["Bid"]["required"].append(field)


def let_out(field: str) -> Callable[[Schemas], None]:
    return lambda new: new["Bid"]["required"].remove(field)


def one_more_fact(new: Schemas) -> None:
    new["Event"]["properties"]["fact"]["anyOf"].append({"$ref": "#/Novelty"})


def one_fact_less(new: Schemas) -> None:
    new["Event"]["properties"]["fact"]["anyOf"].pop()


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (add("more", required=False), []),
        (drop("Bid", "source"), []),
        (one_more_fact, []),
        (put("Handover", "quantity", description="how many"), []),
        (put("Bid", "source", default="S1"), []),
        (lambda new: new.update(Novelty={"type": "object", "properties": {}}), []),
        (add("more", required=True), ["Handover.more is new"]),
        (drop("Handover", "quantity"), ["Handover.quantity is gone"]),
        (put("Handover", "quantity", maximum=10), ["Handover.quantity is another"]),
        (put("Handover", "quantity", type="string"), ["Handover.quantity is another"]),
        (forget("Handover"), ["Handover is gone"]),
        (need("source"), ["Bid.source is needed now"]),
        (let_out("cost"), ["Bid.cost may be left out now"]),
        (one_fact_less, ["Event.fact is another"]),
        (lambda new: new["AtvStatus"]["enum"].append("ASLEEP"), ["AtvStatus is another"]),
    ],
)
def test_what_a_change_would_break_is_told(change: Callable[[Schemas], Any], told: list[str]) -> None:
    old = current()
    new = deepcopy(old)
    change(new)
    found = breaks(old, new)
    assert len(found) == len(told)
    assert all(fault.startswith(start) for fault, start in zip(found, told, strict=True))


# --- agents of two versions -------------------------------------------------------------------------


def with_news(part: Any) -> Any:
    """What a newer version says: a field more in everything."""
    if isinstance(part, dict):
        return {
            "novelty": {"words": ["of", 1, None]},
            **{name: with_news(value) for name, value in part.items()},
        }
    if isinstance(part, list):
        return [with_news(value) for value in part]
    return part


def as_newer(sender: str, message: Message) -> bytes:
    return json.dumps(with_news(json.loads(encode(sender, message)))).encode()


@settings(deadline=None)
@given(Utterances({"": ("M1", "ATV1")}).any())
def test_fields_that_are_not_known_are_ignored_at_every_depth(message: Message) -> None:
    assert decode(as_newer("A1", message)) == ("A1", message)


def day(monkeypatch: pytest.MonkeyPatch, newer: Callable[[str], bool]) -> str:
    """The trace of a shift on the wire format in which some agents are of a newer version."""

    def encode_by_version(sender: str, message: Message) -> bytes:
        return as_newer(sender, message) if newer(sender) else encode(sender, message)

    async def main() -> str:
        trace, plant = Trace(), default_plant()
        factory = SimFactory(plant, clock(), seed=1, codec=True, listener=trace)
        orders = demand.orders(plant, Random(1), load=0.8, until_s=SPAN_S)
        async with asyncio.TaskGroup() as group:
            tasks = [
                group.create_task(factory.run()),
                group.create_task(OrderClient(factory.bus, clock()).place(orders)),
            ]
            await asyncio.sleep(SPAN_S)
            for task in tasks:
                task.cancel()
        return trace.hexdigest()

    monkeypatch.setattr("dray_sim.network.sim_network.encode", encode_by_version)
    return run(main())


@pytest.mark.slow
def test_a_factory_in_which_half_of_all_agents_are_newer_goes_on_as_before(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    names = [*default_plant().machines, *default_plant().fleet]
    newer = set(names[::2])
    assert day(monkeypatch, newer.__contains__) == day(monkeypatch, lambda _: False)

"""What is published of the wire is what the code says, and what agents really say."""

from __future__ import annotations

import asyncio
import json
import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Any

import jsonschema_rs
import pytest
from hypothesis import given, settings
from utterances import MESSAGE_TYPES, Utterances

from dray.codec import encode
from dray.messages import Message
from dray.plant import default_plant
from dray.wire import asyncapi
from dray.wire.channels import CHANNELS
from dray.wire.documents import RELEASED, documents
from dray.wire.schemas import message_schema
from dray_sim.clock.loop import clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.people import demand
from dray_sim.people.order_client import OrderClient

FOLDER = Path(__file__).parents[2] / "docs" / "wire"

SPAN_S = 1800.0
"""Of a busy shift: all that is published is published by then."""


def test_the_published_files_are_those_that_the_code_makes() -> None:
    published = {
        str(file.relative_to(FOLDER)): file.read_text(encoding="utf-8")
        for file in FOLDER.rglob("*.json")
        if file.name != RELEASED
    }
    assert published == documents(), "run `dray wire write` and commit docs/wire"


@pytest.mark.parametrize("kind", MESSAGE_TYPES, ids=lambda kind: kind.__name__)
def test_whatever_may_be_said_fits_its_published_schema(kind: type[Message]) -> None:
    fits = jsonschema_rs.validator_for(message_schema(kind))

    @settings(deadline=None, max_examples=30)
    @given(Utterances({"": ("M1", "ATV1")}).message(kind))
    def said(message: Message) -> None:
        fits.validate(json.loads(encode("ATV-07", message)))

    said()


def test_a_schema_tells_a_wrong_value_another_message_and_another_version() -> None:
    fits = jsonschema_rs.validator_for(
        message_schema(next(k for k in MESSAGE_TYPES if k.__name__ == "Handover"))
    )
    good = {"v": 2, "from": "ATV1", "m": {"type": "Handover", "task": "t", "epoch": 1, "quantity": 4}}
    assert fits.is_valid(good)
    for change in ({"quantity": -1}, {"task": "a/b"}, {"type": "Docked"}):
        assert not fits.is_valid({**good, "m": {**good["m"], **change}})
    assert not fits.is_valid({**good, "v": 1})
    assert not fits.is_valid({**good, "from": "*"})


def references(part: Any) -> Iterator[str]:
    if isinstance(part, dict):
        if isinstance(part.get("$ref"), str):
            yield part["$ref"]
        for value in part.values():
            yield from references(value)
    elif isinstance(part, list):
        for value in part:
            yield from references(value)


def test_every_reference_of_the_document_leads_somewhere() -> None:
    document = asyncapi.document()
    found = set(references(document))
    assert len(found) > len(MESSAGE_TYPES)
    for reference in found:
        place: Any = document
        for step in reference.removeprefix("#/").split("/"):
            place = place[step]
        assert place


def test_every_message_has_a_channel_and_every_operation_its_speakers() -> None:
    assert {kind for channel in CHANNELS for kind in channel.messages} == set(MESSAGE_TYPES)
    assert all(operation["x-speakers"] for operation in asyncapi.document()["operations"].values())


def test_everything_is_said_on_the_channel_that_is_published_for_it() -> None:
    plant = default_plant()
    addresses = {
        re.compile(re.sub(r"\\{\w+\\}", "[^/]+", re.escape(channel.address))): channel for channel in CHANNELS
    }
    said: defaultdict[str, set[type[Message]]] = defaultdict(set)

    class Listener:
        def on_message(self, at_s: float, sender: str, address: str, message: Message) -> None:
            key = f"{plant.id}/agent/@{address[1:]}" if address.startswith(">") else address
            (channel,) = (channel for pattern, channel in addresses.items() if pattern.fullmatch(key))
            said[channel.name].add(type(message))

    async def main() -> None:
        factory = SimFactory(plant, clock(), seed=1, listener=Listener())
        orders = demand.orders(plant, Random(1), load=0.8, until_s=SPAN_S)
        async with asyncio.TaskGroup() as group:
            tasks = [
                group.create_task(factory.run()),
                group.create_task(OrderClient(factory.bus, clock()).place(orders)),
            ]
            await asyncio.sleep(SPAN_S)
            for task in tasks:
                task.cancel()

    run(main())
    # Nobody is shut out and nothing is closed here: these are people's decisions, which a gateway tells. There are
    # vehicles enough, none has a problem, nobody is on duty, one strategist has no other one, and they drive without right of way.
    unsaid = {"shutOut", "closures", "removals", "free", "problems", "floor", "docks"}
    unsaid |= {"operatorHeartbeats", "strategistHeartbeats", "calls", "breakdowns", "obstacles"}
    assert set(said) == {channel.name for channel in CHANNELS} - unsaid
    for channel in CHANNELS:
        assert said[channel.name] <= set(channel.messages)

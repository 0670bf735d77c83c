"""`dray up --vda5050`: the simulated factory with its vehicles behind a broker, in one command."""

from __future__ import annotations

import asyncio
import json
import re
from collections.abc import Callable
from typing import Any

import aiomqtt
import pytest
import typer

from dray.cli.commands.simulation.up import brokered

PATIENCE_S = 120.0


@pytest.mark.slow
def test_vehicles_of_all_versions_are_ordered_about_over_a_broker(start_dray: Callable[..., Any]) -> None:
    dray = start_dray("--vda5050", "--traffic", "--speed", "10")
    port = int(re.findall(r"mqtt://127\.0\.0\.1:(\d+)", dray.output())[0])

    async def versions() -> set[str]:
        heard: set[str] = set()
        async with (
            asyncio.timeout(PATIENCE_S),
            aiomqtt.Client("127.0.0.1", port, identifier="test") as client,
        ):
            for topic in ("uagv/v2/Dray/+/order", "vda5050/v3/Dray/+/order"):
                await client.subscribe(topic)
            async for message in client.messages:
                heard.add(json.loads(message.payload)["version"])
                if len(heard) == 3:
                    break
        return heard

    assert asyncio.run(versions()) == {"2.0.0", "2.1.0", "3.0.0"}
    # A vehicle's agent begins another life, and its body goes on.
    atvs = dray.ask("/api/atvs")
    assert not any(atv["problem"] for atv in (atvs if isinstance(atvs, list) else atvs["items"]))
    assert dray.stop() == 0


@pytest.mark.parametrize(
    ("options", "words"), [({"vda5050": False}, "only with"), ({"vda5050": True}, "mqtt://HOST")]
)
def test_a_broker_that_cannot_be_is_refused(options: dict[str, bool], words: str) -> None:
    with pytest.raises(typer.BadParameter, match=words), brokered(url="nowhere", **options):
        pass

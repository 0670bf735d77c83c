"""The body of a gate whose counter and reader are topics of a broker."""

from __future__ import annotations

import asyncio

import aiomqtt
import msgspec
import pytest
from gate_rig import SHAFTS, linked
from plc import PATIENCE_S

from dray.adapters.mapping_file import parse_mapping
from dray.adapters.mqtt.link import SignalsOverMqtt
from dray.adapters.mqtt.mapping_file import MqttMapping
from dray.adapters.signals.gate import SETTLE_S
from dray.adapters.vda5050.link import BrokerAddress
from dray_sim.vda5050.local_broker import local_broker

TOPICS = b"""
signals:
  pieces: {topic: gate/in, path: pieces}
  goal: {topic: gate/in, path: label}
  admitted: {topic: gate/do, path: pieces}
  admitted_goal: {topic: gate/do, path: label}
"""


def test_it_may_be_on_topics_where_silence_is_noticed() -> None:
    parse_mapping(b"silent_after_s: 5\n" + TOPICS, "gate.yaml", MqttMapping).check_gate()
    with pytest.raises(ValueError, match="silent_after_s is missing"):
        parse_mapping(TOPICS, "gate.yaml", MqttMapping).check_gate()


def test_a_container_comes_in_over_a_broker() -> None:
    async def story(broker: BrokerAddress) -> None:
        spec = parse_mapping(b"silent_after_s: 300\n" + TOPICS, "gate.yaml", MqttMapping)
        async with (
            aiomqtt.Client(broker.host, broker.port, identifier="reader") as reader,
            linked(SignalsOverMqtt(spec, broker, "dray-gate")) as rig,
        ):

            async def says(pieces: int, label: str | None) -> None:
                await reader.publish(
                    "gate/in", msgspec.json.encode({"pieces": pieces, "label": label}), qos=1
                )

            async def hears(pieces: int) -> None:
                """Wait until the agent says so; it says it every second."""
                async with (
                    asyncio.timeout(PATIENCE_S),
                    aiomqtt.Client(broker.host, broker.port, identifier="ear") as ear,
                ):
                    await ear.subscribe("gate/do")
                    async for message in ear.messages:
                        said = msgspec.json.decode(bytes(message.payload))  # type: ignore[arg-type]
                        if said == {"pieces": pieces, "label": SHAFTS}:
                            return

            async with asyncio.timeout(PATIENCE_S):
                while rig.body.away:
                    await says(500, None)
                    await asyncio.sleep(0.1)
            await says(500, SHAFTS)
            await rig.until(lambda: rig.body.label == SHAFTS)
            rig.clock.pass_s(SETTLE_S)
            await hears(10)
            await says(504, SHAFTS)
            await rig.until(lambda: rig.arrived == {SHAFTS: 4})
            await says(506, None)
            await hears(0)
            assert (rig.arrived, rig.body.away, rig.body.label) == ({SHAFTS: 6}, "", "")

    with local_broker() as broker:
        asyncio.run(asyncio.wait_for(story(broker), 3 * PATIENCE_S))

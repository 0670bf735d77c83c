"""A machine whose sensors are topics of a broker: what is said is counted once, and what is no value says so."""

from __future__ import annotations

import asyncio
import os
import subprocess
import sys
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import Any

import aiomqtt
import msgspec
import pytest
from iotcore import Broker
from signals_rig import PLANT, PLENTY, PRODUCT, SPEC, HandClock

from dray.adapters.machine_acts import Wanted
from dray.adapters.mapping_file import parse_mapping
from dray.adapters.mqtt.commissioning import MqttCommissioning
from dray.adapters.mqtt.link import SignalsOverMqtt
from dray.adapters.mqtt.mapping_file import MqttMapping
from dray.adapters.mqtt.values import LARGEST_BYTES, message_of, sample_of
from dray.adapters.signals.signal import Quality, Sample, Value
from dray.adapters.signals.workcell import Kept, SignalledWorkcell
from dray.adapters.system_clock import SystemClock
from dray.adapters.vda5050.link import BrokerAddress
from dray.body import CycleDone, DockReady, OpenDock, Report, StartCycle
from dray.errors import SettingsError
from dray_sim.vda5050.local_broker import local_broker

PATIENCE_S = 60.0
"""Far beyond what a busy computer takes."""

TEXT = b"""
stock: %b
signals:
  pieces: {topic: press/counts, path: count.good}
  bad: {topic: press/counts, path: count.bad}
  fault: {topic: press/fault}
  dock_ready: {topic: press/dock, path: $.safe}
  dock_permit: {topic: press/do, path: dock.permit}
  dock_vehicle: {topic: press/do, path: dock.vehicle}
  run: {topic: press/do, path: run}
  alive: {topic: press/alive}
""" % msgspec.json.encode(PLENTY)


def counts(good: int, bad: int = 0) -> bytes:
    return msgspec.json.encode({"count": {"good": good, "bad": bad}})


# --- values, pure ---


@pytest.mark.parametrize(
    ("data", "path", "value"),
    [
        (b"42", "", 42),
        (b" true\n", "", True),
        (b'{"a": {"b": [0, {"c": 1.5}]}}', "a.b.1.c", 1.5),
        (b'{"a": 3}', "$.a", 3),
        (b'"Jam"', "", "Jam"),
        (b"OutOfService", "", "OutOfService"),
    ],
)
def test_a_value_is_found(data: bytes, path: str, value: Value) -> None:
    sample = sample_of(data, path)
    assert (sample.value, sample.quality) == (value, Quality.GOOD)


@pytest.mark.parametrize(
    ("data", "path", "why"),
    [
        (b"{", "", "no JSON"),
        (b'{"a": 1', "a", "no JSON"),
        (b"word", "a", "no JSON"),
        (b"\xff\xfe", "a", "no JSON"),
        (b"", "", "no JSON"),
        (b'{"a": 1}', "b", "nothing at 'b'"),
        (b'{"a": 1}', "a.b", "nothing at 'a.b'"),
        (b'{"a": "text"}', "a.x", "nothing at 'a.x'"),
        (b"[1]", "3", "nothing at '3'"),
        (b"[1]", "x", "nothing at 'x'"),
        (b'{"a": null}', "a", "it is empty"),
        (b'{"a": {}}', "a", "no single value"),
        (b"NaN", "a", "no JSON"),
        (b" " * (LARGEST_BYTES + 1), "", "none of a sensor"),
        (b"[" * 60_000, "", "no JSON"),
    ],
)
def test_what_is_no_value_says_why(data: bytes, path: str, why: str) -> None:
    sample = sample_of(data, path)
    assert sample.quality is Quality.BAD
    assert why in sample.reason


@pytest.mark.parametrize(("data", "path"), [(b"null", ""), (b"", ""), (b" ", ""), (b'{"a": null}', "a")])
def test_no_text_is_an_empty_one_where_a_signal_is_always_a_text(data: bytes, path: str) -> None:
    assert sample_of(data, path, text=True) == Sample("")
    assert sample_of(data, path).quality is Quality.BAD


def test_what_is_written_to_one_topic_is_one_message() -> None:
    said = message_of([("dock.permit", True), ("dock.vehicle", "ATV1"), ("run", False)])
    assert msgspec.json.decode(said) == {"dock": {"permit": True, "vehicle": "ATV1"}, "run": False}
    assert message_of([("", 7)]) == b"7"


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("signals: {pieces: {node: a}}", "needs a `topic`"),
        ("signals: {pieces: {topic: a, node: b}}", "has no `node`"),
        ("signals: {pieces: {topic: a/+/b}}", "is not one topic"),
        ("signals: {pieces: {topic: a}, run: {topic: a}}", "would be heard as its controller's word"),
        ("silent_after_s: 0\nsignals: {pieces: {topic: a}}", "silent_after_s"),
        ("url: mqtt://x\nsignals: {pieces: {topic: a}}", "unknown field `url`"),
    ],
)
def test_a_mapping_that_cannot_be_used_says_why(text: str, why: str) -> None:
    with pytest.raises(SettingsError, match=why):
        parse_mapping(text.encode(), "m.yaml", MqttMapping)


# --- over a broker ---


class MqttRig:
    """A machine behind a broker, over several lives of its agent, and the machine's own client."""

    def __init__(self, broker: BrokerAddress, text: bytes = TEXT) -> None:
        self.broker = broker
        self.mapping = parse_mapping(text, "m.yaml", MqttMapping)
        self.clock, self.kept, self.reports = HandClock(), None, list[Report]()
        self.said: dict[str, bytes] = {}
        """By topic, what the agent has said last."""

    kept: Kept | None

    def remember(self, kept: Kept) -> None:
        self.kept = kept

    def write(self) -> None:
        self.link.write()

    @asynccontextmanager
    async def life(self) -> AsyncIterator[None]:
        """One life of its agent."""
        self.link = SignalsOverMqtt(self.mapping, self.broker, "dray-M1")
        self.body = SignalledWorkcell(SPEC, PLANT, self.mapping, self.clock, self, self.kept)
        self.body.attach(self.reports.append)
        running = asyncio.create_task(self.link.run(self.body))
        try:
            yield
        finally:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)

    async def begins_at(self, good: int) -> None:
        """Its controller is linked, and its counter was seen once."""
        await self.until(self.link.linked.is_set)
        await self.say("press/counts", counts(good))
        await self.until(lambda: self.kept is not None and self.kept.pieces is not None)

    async def say(self, topic: str, data: bytes, *, retain: bool = False) -> None:
        """The machine says something."""
        async with aiomqtt.Client(self.broker.host, self.broker.port, identifier="press") as client:
            await client.publish(topic, data, qos=1, retain=retain)

    async def says_until(self, data: bytes, seen: Callable[[], bool]) -> None:
        """The machine says its counts again and again. No task is cancelled: the client may swallow that."""
        async with asyncio.timeout(PATIENCE_S):
            while not seen():
                with suppress(aiomqtt.MqttError):
                    await self.say("press/counts", data)
                await asyncio.sleep(0.1)

    async def hears(self, topic: str, wanted: Callable[[object], bool]) -> None:
        """Wait until the agent has said something on a topic."""
        async with aiomqtt.Client(self.broker.host, self.broker.port, identifier="ear") as client:
            await client.subscribe(topic)
            async with asyncio.timeout(PATIENCE_S):
                async for message in client.messages:
                    if wanted(msgspec.json.decode(bytes(message.payload))):  # type: ignore[arg-type]
                        return

    async def until(self, seen: Callable[[], bool]) -> None:
        async with asyncio.timeout(PATIENCE_S):
            while not seen():  # noqa: ASYNC110 - the body has no event
                await asyncio.sleep(0.02)

    def counted(self, *, bad: bool = False) -> int:
        return sum(isinstance(report, CycleDone) and report.bad is bad for report in self.reports)

    @property
    def broken(self) -> str:
        return self.body.sense().broken


def play(story: Callable[[BrokerAddress], object]) -> None:
    with local_broker() as broker:
        asyncio.run(asyncio.wait_for(story(broker), 3 * PATIENCE_S))  # type: ignore[arg-type]


def test_pieces_a_dock_and_words_from_end_to_end_and_what_is_said_twice_counts_once() -> None:
    async def story(broker: BrokerAddress) -> None:
        rig = MqttRig(broker)
        async with rig.life():
            await rig.begins_at(7)
            rig.body.instruct(StartCycle(product=PRODUCT))
            await rig.hears("press/do", lambda said: said["run"] is True)  # type: ignore[index]
            rig.clock.pass_s(100.0)
            for _ in range(3):
                await rig.say("press/counts", counts(8, 1))
            await rig.until(lambda: rig.counted() == 1 and rig.counted(bad=True) == 1)
            rig.body.instruct(OpenDock("ATV1", PRODUCT, 1))
            await rig.hears("press/do", lambda said: said["dock"] == {"permit": True, "vehicle": "ATV1"})  # type: ignore[index]
            await rig.say("press/dock", b'{"safe": true}')
            await rig.until(lambda: DockReady("ATV1") in rig.reports)
            await rig.hears("press/alive", lambda said: isinstance(said, int))
            assert (rig.counted(), rig.broken) == (1, "")

    play(story)


@pytest.mark.parametrize(
    ("data", "why"),
    [
        (b'{"count": ', "no JSON"),
        (b'{"count": {"bad": 0}}', "nothing at 'count.good'"),
        (b'{"count": {"good": "many", "bad": 0}}', "'many' is no count"),
        (b'{"count": {"good": -1, "bad": 0}}', "-1 is no count"),
    ],
)
def test_what_is_no_value_is_a_problem_until_there_is_one(data: bytes, why: str) -> None:
    async def story(broker: BrokerAddress) -> None:
        rig = MqttRig(broker)
        async with rig.life():
            await rig.begins_at(7)
            await rig.say("press/counts", data)
            await rig.until(lambda: why in rig.broken)
            rig.clock.pass_s(100.0)
            await rig.say("press/counts", counts(8))
            await rig.until(lambda: rig.broken == "" and rig.counted() == 1)

    play(story)


def test_what_the_broker_has_kept_counts_nothing_and_lets_nobody_in_but_a_fault_of_it_is_believed() -> None:
    async def story(broker: BrokerAddress) -> None:
        rig = MqttRig(broker)
        async with rig.life():
            await rig.begins_at(100)
        rig.clock.pass_s(3_600.0)
        await rig.say("press/counts", counts(95), retain=True)
        await rig.say("press/dock", b'{"safe": true}', retain=True)
        await rig.say("press/fault", b"true", retain=True)
        async with rig.life():
            rig.body.instruct(OpenDock("ATV1", PRODUCT, 1))
            await rig.until(lambda: rig.broken == "a fault")
            await rig.say("press/fault", b"false")
            await rig.say("press/counts", counts(102))
            await rig.until(lambda: rig.counted() == 2)
            assert (rig.broken, DockReady("ATV1") in rig.reports) == ("", False)

    play(story)


def test_a_counter_that_was_reset_while_it_was_heard_counts_on() -> None:
    async def story(broker: BrokerAddress) -> None:
        rig = MqttRig(broker)
        async with rig.life():
            await rig.begins_at(500)
            rig.clock.pass_s(100.0)
            await rig.say("press/counts", counts(1))
            await rig.until(lambda: rig.counted() == 1)
            assert rig.broken == ""

    play(story)


def test_a_broker_that_goes_and_comes_back_is_a_problem_meanwhile_and_no_piece_is_lost_or_counted_twice() -> (
    None
):
    async def story() -> None:
        with local_broker() as first:
            port, rig = first.port, MqttRig(first)
            living = rig.life()
            await living.__aenter__()
            await rig.begins_at(7)
        await rig.until(lambda: "is not heard" in rig.broken)
        rig.clock.pass_s(600.0)
        second = Broker(port=port, listen="127.0.0.1").start()
        try:
            await rig.until(lambda: rig.broken == "")
            for _ in range(2):
                await rig.say("press/counts", counts(10))
            await rig.until(lambda: rig.counted() == 3)
            assert rig.broken == ""
        finally:
            await living.__aexit__(None, None, None)
            second.stop()

    asyncio.run(asyncio.wait_for(story(), 3 * PATIENCE_S))


def test_one_that_should_say_something_and_does_not_is_away_and_is_there_when_it_does() -> None:
    async def story(broker: BrokerAddress) -> None:
        rig = MqttRig(broker, b"silent_after_s: 2\n" + TEXT)
        async with rig.life():
            for _ in range(2):
                assert rig.broken != ""
                await rig.says_until(counts(7), lambda: rig.broken == "")
                await rig.until(lambda: "nothing was said for 2 s" in rig.broken)

    play(story)


def test_the_agent_of_a_machine_with_simple_sensors(tmp_path: Path) -> None:
    async def story(broker: BrokerAddress) -> None:
        rig = MqttRig(broker)
        file = tmp_path / "m1.yaml"
        file.write_bytes(TEXT)
        process = await asyncio.create_subprocess_exec(
            *(sys.executable, "-m", "dray", "agent", "machine", "M1", "--body", "mqtt"),
            *("--mapping", str(file), "--broker", str(broker)),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env={**os.environ, "DRAY_BUS_PLAIN": "true", "DRAY_JOURNAL_FOLDER": str(tmp_path)},
            cwd=tmp_path,
        )
        assert process.stdout is not None
        assert (await process.stdout.readline()).decode() == "M1 is ready\n"
        kept = tmp_path / "M1.workcell.json"
        for good in (7, 9):
            await rig.say("press/counts", counts(good))
            await rig.until(lambda: kept.exists() and read(kept).pieces.value == good)  # type: ignore[union-attr]  # noqa: B023
        remembered = read(kept)
        assert remembered.stock[PRODUCT] == 2
        assert remembered.pieces is not None
        assert remembered.pieces.broker == str(broker)
        process.terminate()
        _, told = await process.communicate()
        assert process.returncode == 0, told.decode()

    play(story)


def commissioning(rig: MqttRig, broker: BrokerAddress, **changes: Any) -> MqttCommissioning:
    clock = SystemClock(asyncio.get_running_loop())
    return MqttCommissioning(rig.mapping, broker, SPEC, PLANT, clock, **{"wanted": Wanted()} | changes)


async def speaks(rig: MqttRig) -> None:
    """A machine that says all it has, makes a piece when one is wanted, and opens its dock."""
    good, safe = 7, False
    async with aiomqtt.Client(rig.broker.host, rig.broker.port, identifier="press") as client:
        await client.subscribe("press/do")

        async def say() -> None:
            while True:
                await client.publish("press/counts", counts(good))
                await client.publish("press/fault", b"false")
                await client.publish("press/dock", msgspec.json.encode({"safe": safe}))
                await asyncio.sleep(0.1)

        saying = asyncio.create_task(say())
        try:
            async for message in client.messages:
                told = msgspec.json.decode(bytes(message.payload))  # type: ignore[arg-type]
                safe = told["dock"]["permit"]
                good = 8 if told["run"] else good
        finally:
            saying.cancel()


def test_a_check_shows_each_signal_and_lets_it_make_a_piece_and_open_its_dock() -> None:
    async def story(broker: BrokerAddress) -> None:
        rig = MqttRig(broker)
        machine = asyncio.create_task(speaks(rig))
        done = commissioning(rig, broker, wanted=Wanted(cycle=True, dock=True))
        steps = {step.name: step async for step in done.run()}
        machine.cancel()
        assert [name for name, step in steps.items() if step.passed is False] == []
        assert steps["pieces"].text == "press/counts count.good, shows 7"
        assert steps["cycle"].text.startswith(f"one {PRODUCT} after")
        assert "ready after" in steps["dock"].text
        assert done.steps.passed
        assert "press/counts count.good" in done.report()

    play(story)


def test_a_check_says_what_was_not_said_and_what_is_no_value() -> None:
    async def story(broker: BrokerAddress) -> None:
        rig = MqttRig(broker)
        await rig.say("press/counts", counts(7), retain=True)
        silent = {step.name: step async for step in commissioning(rig, broker, hear_s=0.5).run()}
        assert silent["pieces"].passed is False
        assert silent["pieces"].text.endswith("nothing was said within 0.5 s, only what the broker has kept")
        assert silent["dock_ready"].passed is None
        assert "cycle" not in silent

    play(story)


def test_a_check_of_a_broker_that_is_not_there(monkeypatch: pytest.MonkeyPatch) -> None:
    async def story() -> None:
        with local_broker() as broker:
            rig = MqttRig(broker)
        monkeypatch.setattr("dray.adapters.mqtt.commissioning.LINK_S", 1.0)
        [step] = [step async for step in commissioning(rig, broker).run()]
        assert (step.name, step.passed) == ("connection", False)

    asyncio.run(asyncio.wait_for(story(), PATIENCE_S))


def read(file: Path) -> Kept:
    return msgspec.json.decode(file.read_bytes(), type=Kept)

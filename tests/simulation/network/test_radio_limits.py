"""The limits of the radio mesh: cut radios, frames, rates, losses and hops, the same for the same seed."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from math import cos, sin
from random import Random

import pytest
from hash_seeds import printed_by_each
from radio_floor import CLEAR, SOON_S, Floor, heartbeat, play

from dray.codec import encode
from dray.messages import (
    Brief,
    Docked,
    Handover,
    HandoverAccepted,
    Link,
    Phase,
    Pose,
    Resigned,
    Role,
)
from dray_sim.clock.loop import clock, run
from dray_sim.faults import (
    CoverageHole,
    LinkTrouble,
    NetworkFault,
    Partition,
    RadioCut,
    WlanCut,
)
from dray_sim.network.latency import Latency
from dray_sim.network.radio import TOO_LONG, TOO_MANY
from dray_sim.network.sim_network import SimNetwork
from dray_sim.run.trace import Trace

# --- the limits of the radio ------------------------------------------------------------------------


def test_a_cut_radio_neither_sends_nor_hears_nor_passes_on() -> None:
    for cut in ("V0", "V1"):

        async def story(cut: str = cut) -> None:
            floor = Floor(0.0, 20.0)
            floor.network.begin(RadioCut(cut))
            await floor.cut("V0")
            await floor.beat_and_wait("V0")
            assert not floor.beats("M")
            floor.network.end(RadioCut(cut))
            await floor.beat_and_wait("V0")
            assert len(floor.beats("M")) == 1

        play(story())


def test_a_long_heartbeat_leaves_out_what_others_can_do_without() -> None:
    async def story() -> None:
        watch = Brief("T2", 1, Role.SECONDARY, "M2")
        task = Brief("T1", 3, Role.PRIMARY, "M1", Phase.CARRYING, "steel", 5, 99.0)
        full = {
            "task": task,
            "watches": (watch,) * 4,
            "way": ("n1", "n2") * 20,
            "software": "1",
            "dwell_point": "P1",
        }
        sizes = [
            len(encode("V0", heartbeat("V0", link=Link.MESH, **fields)))
            for fields in (full, full | {"way": ()}, full | {"way": (), "watches": ()})
        ]
        beats = []
        for size in (*sizes, sizes[-1] - 1):
            floor = Floor(0.0, 20.0, radio=replace(CLEAR, frame_bytes=size))
            await floor.cut("V0")
            await floor.beat_and_wait("V0", **full)
            beats += floor.beats("M")
        assert [len(beat.way) for beat in beats] == [40, 0, 0, 0]
        assert [len(beat.watches) for beat in beats] == [4, 4, 0, 0]
        assert [beat.software + beat.dwell_point for beat in beats] == ["1P1", "1P1", "1P1", ""]
        assert all(beat.task == task for beat in beats)

    play(story())


def test_what_is_longer_than_a_frame_is_lost_and_counted() -> None:
    async def story() -> None:
        floor = Floor(0.0, 20.0)
        await floor.cut("V0")
        await floor.beat_and_wait("V0", problem="x" * CLEAR.frame_bytes)
        floor.sessions["V0"].send("M", Resigned("T", 1, Role.PRIMARY, "x" * CLEAR.frame_bytes))
        await asyncio.sleep(SOON_S)
        assert not floor.heard["M"]
        assert floor.network.lost == {TOO_LONG: 2}

    play(story())


def test_a_vehicle_sends_a_burst_and_then_its_rate() -> None:
    async def story() -> None:
        floor = Floor(0.0, 20.0)
        await floor.cut("V0")
        sent = 0
        for number in range(1000):
            floor.sessions["V0"].send("M", Handover("T", 1, number))
            sent += 1
            await asyncio.sleep(0.01)
        await asyncio.sleep(SOON_S)
        expected = CLEAR.burst + 10.0 * CLEAR.rate_hz
        assert len(floor.heard["M"]) == pytest.approx(expected, abs=1.0)
        assert floor.network.lost == {TOO_MANY: sent - len(floor.heard["M"])}

    play(story())


def test_passing_on_costs_a_relay_its_own_rate() -> None:
    async def story() -> None:
        floor = Floor(0.0, 20.0, 40.0, radio=replace(CLEAR, rate_hz=1.0, burst=1.0))
        await floor.cut("V0", "V1")
        floor.beat("V1")
        await floor.beat_and_wait("V0")
        assert [beat.atv for beat in floor.beats("M")] == ["V1"]
        # Neither can say again what the other one has said.
        assert floor.network.lost == {TOO_MANY: 2}

    play(story())


def test_the_radio_loses_its_share_of_frames() -> None:
    async def story() -> None:
        floor = Floor(0.0, 20.0, radio=replace(CLEAR, loss_frac=0.25))
        await floor.cut("V0")
        for _ in range(2000):
            floor.beat("V0")
            await asyncio.sleep(0.2)
        await asyncio.sleep(SOON_S)
        assert len(floor.beats("M")) / 2000 == pytest.approx(0.75, abs=0.03)

    play(story())


def test_each_hop_takes_its_time() -> None:
    async def story() -> None:
        slow = Latency(base_s=0.5, mean_extra_s=0.0, cap_s=0.5)
        floor = Floor(0.0, 20.0, 40.0, radio=replace(CLEAR, latency=slow))
        await floor.cut("V0", "V1")
        floor.beat("V0")
        await asyncio.sleep(1.0)
        assert not floor.beats("M")
        await asyncio.sleep(0.3)
        assert len(floor.beats("M")) == 1

    play(story())


# --- one seed, one run ------------------------------------------------------------------------------


STORM: list[tuple[float, float, NetworkFault]] = [
    (5.0, 40.0, WlanCut("V1")),
    (8.0, 30.0, CoverageHole(x_m=20.0, y_m=0.0, radius_m=12.0)),
    (12.0, 35.0, LinkTrouble(sender="V*", loss_frac=0.2, jitter_s=0.5, duplicate_frac=0.1, reorder_frac=0.1)),
    (15.0, 20.0, RadioCut("V3")),
    (18.0, 28.0, Partition((("V2", "V5", "M"),))),
]


async def storm(seed: int, *, codec: bool = False) -> str:
    """Eight vehicles drive in circles and talk through everything that a network can suffer."""
    trace = Trace()
    network = SimNetwork(clock(), Random(seed), chance=Random(f"{seed} faults"), codec=codec, trace=trace)
    machine = network.join("M", lambda sender, _: machine.send(sender, HandoverAccepted("T", 1)))
    machine.subscribe("p/hb/**")

    def drive(number: int) -> None:
        def where() -> Pose:
            angle = clock().now_s() / 10.0 + number
            return Pose(20.0 * cos(angle), 10.0 * sin(angle), 0.0)

        name = f"V{number}"
        network.equip(name, where, lambda *_: beat())
        session = network.join(name, lambda *_: None)

        def beat() -> None:
            session.publish(f"p/hb/atv/{name}", heartbeat(name, at_s=clock().now_s(), pose=where()))
            session.send("M", Docked(name, 1, "S1"))

        def beat_again() -> None:
            beat()
            clock().call_at(clock().now_s() + 1.0, beat_again)

        clock().call_at(number / 8.0, beat_again)

    for number in range(8):
        drive(number)
    for from_s, until_s, fault in STORM:
        clock().call_at(from_s, network.begin, fault)
        clock().call_at(until_s, network.end, fault)
    await asyncio.sleep(50.0)
    assert network.relayed > 50
    assert all(network.link_of(f"V{number}") is Link.WLAN for number in range(8))
    counts = (network.delivered, network.wlan.doubled, network.relayed, sorted(network.lost.items()))
    return f"{trace.hexdigest()} {counts}"


def test_one_seed_gives_one_storm_and_the_wire_format_changes_nothing() -> None:
    first = run(storm(1))
    assert first == run(storm(1)) == run(storm(1, codec=True))
    assert first != run(storm(2))


def test_a_storm_does_not_hang_on_the_hash_seed_of_the_process() -> None:
    script = (
        "import importlib.util, sys;"
        "spec = importlib.util.spec_from_file_location('story', sys.argv[1]);"
        "story = importlib.util.module_from_spec(spec); spec.loader.exec_module(story);"
        "print(story.run(story.storm(3)))"
    )
    assert printed_by_each(script, __file__) == {run(storm(3)) + "\n"}

"""The radio mesh: what vehicles say rises to the next one that has WLAN, and answers come down."""

from __future__ import annotations

import asyncio
import typing

import msgspec
import pytest
from radio_floor import CLEAR, SOON_S, Floor, play

from dray.adapters.security.signing import SigningKey
from dray.messages import (
    Accepted,
    AnyMessage,
    AtvHeartbeat,
    Award,
    Bid,
    CallAnswer,
    CallAnswered,
    CallState,
    CommandAnswered,
    CommandKind,
    Confirmed,
    Declined,
    Docked,
    DockHeld,
    DockOpened,
    DwellPointClaimed,
    Handover,
    HandoverAccepted,
    HelpCall,
    Link,
    Message,
    Reason,
    Refusal,
    Release,
    Resigned,
    Role,
    Superseded,
    TakenOver,
    Transport,
    VehicleCommand,
    Withdrawn,
)
from dray.messages.cost import TransportCost
from dray.messages.floor.traffic import (
    HoldsAsked,
    PlaceConfirmed,
    PlaceGranted,
    PlaceRequested,
    PlaceReservation,
    YieldAsked,
    YieldRefused,
)
from dray_sim.clock.loop import run
from dray_sim.faults import LinkTrouble, Partition
from dray_sim.network.radio import NOBODY_NEAR, UNFIT
from dray_sim.network.sim_network import GATEWAY_S, NO_GATEWAY, NO_WLAN
from dray_sim.run.trace import Trace

SAID = [
    Docked("T", 1, "S1"),
    DockOpened("T", 1, "S1"),
    DockHeld("T", 1, "S1", "no room"),
    Handover("T", 1, 5),
    HandoverAccepted("T", 1),
    Superseded("T", 2),
    Release("T", 1, Role.PRIMARY, Reason.SILENT),
    Resigned("T", 1, Role.SECONDARY, Reason.ON_MESH),
    Withdrawn("T", 1, Reason.NOT_NEEDED),
    TakenOver("T", 2, "V1"),
    Confirmed("T", 2),
    SigningKey(bytes(32)).grant(
        "V0",
        VehicleCommand("gateway.12-345", CommandKind.SET_SPEED, speed_frac=0.5, issued_by="a name" * 5),
        person="4f0c2a1e-7b0d-4c55-9c1e-0c9d5c1f2b77",
        areas=[f"AREA{number}" for number in range(1, 9)],
        valid_until_s=123456.789,
    ),
    CommandAnswered("C1", done=True),
    Declined("T", 1, Role.PRIMARY, Refusal.NOT_FIT),
    PlaceRequested(
        district="M",
        life=1,
        seq=1,
        epoch=1,
        rank=(0, 12.5, "V0"),
        holds=("n1",),
        groups=(("n2",), ("n3", "n4")),
        seen=3,
        stands=True,
        docked=False,
    ),
    PlaceGranted(district="M", epoch=1, life=1, upto=1, grants=(PlaceReservation("n2", 4),)),
    PlaceConfirmed(district="M", epoch=1, grants=(PlaceReservation("n2", 4, "V0", b"mark"),)),
    HoldsAsked(district="M", epoch=2, recovery_poll=True),
    YieldAsked(district="M", waiting="V1", rank=(0, 12.5, "V1"), avoid=("n1", "n2"), chain=()),
    YieldRefused(avoid=("n1",), holds=("n1",)),
]
"""One of each kind that may go by radio."""


TRANSPORT = Transport("steel", 5, ("S1",), "M1", "tote")

NOT_FOR_RADIO = [
    Bid("T", 1, Role.PRIMARY, 1, TransportCost(1.0, 2.0, 3.0, 4.0), 9.0),
    Award("T", 1, Role.PRIMARY, TRANSPORT, 100.0),
    Accepted("T", 1, Role.PRIMARY),
    DwellPointClaimed("CH1", "V0", 0.5, standing=False),
]


# --- what rises -------------------------------------------------------------------------------------


def test_without_wlan_a_heartbeat_comes_over_a_neighbour_under_the_same_key() -> None:
    async def story() -> None:
        trace = Trace()
        floor = Floor(0.0, 20.0, trace=trace)
        await floor.cut("V0")
        await floor.beat_and_wait("V0")
        (sender, beat), *more = floor.heard["M"]
        assert isinstance(beat, AtvHeartbeat)
        assert (sender, beat.atv, beat.link, beat.via) == ("V0", "V0", Link.MESH, ("V1",))
        assert not more
        assert floor.beats("G") == [beat]
        assert [(said.sender, said.address) for said in trace.tail] == [
            ("V0", "p/hb/atv/V0"),
            ("V1", "p/hb/atv/V0"),
        ]

    play(story())


def test_a_heartbeat_names_all_relays_in_order_and_the_last_one_has_wlan() -> None:
    async def story() -> None:
        floor = Floor(0.0, 20.0, 40.0, 60.0)
        await floor.cut("V0", "V1", "V2")
        await floor.beat_and_wait("V0")
        assert [beat.via for beat in floor.beats("M")] == [("V1", "V2", "V3")]
        assert floor.network.radio.sent == 3

    play(story())


def test_no_frame_goes_farther_than_the_hops_that_are_allowed() -> None:
    async def story(stations: int) -> int:
        floor = Floor(*(20.0 * number for number in range(stations)))
        await floor.cut(*(f"V{number}" for number in range(stations - 1)))
        await floor.beat_and_wait("V0")
        return len(floor.beats("M"))

    assert run(story(CLEAR.hops + 1)) == 1
    assert run(story(CLEAR.hops + 2)) == 0


@pytest.mark.parametrize(("distance_m", "reached"), [(25.0, 1), (25.1, 0)])
def test_the_radio_reaches_as_far_as_its_range(distance_m: float, reached: int) -> None:
    async def story() -> None:
        floor = Floor(0.0, distance_m)
        await floor.cut("V0")
        await floor.beat_and_wait("V0")
        assert len(floor.beats("M")) == reached
        assert floor.network.lost[NOBODY_NEAR] == 1 - reached

    play(story())


def test_many_neighbours_put_a_heartbeat_on_the_bus_once() -> None:
    async def story() -> None:
        floor = Floor(0.0, 1.0, 2.0, 3.0, 4.0, 5.0)
        await floor.cut("V0", "V5")
        for number in range(20):
            await floor.beat_and_wait("V0", seq=number)
        assert [beat.seq for beat in floor.beats("M")] == list(range(20))
        assert len({beat.via for beat in floor.beats("M")}) > 1
        assert floor.network.relayed == 20

    play(story())


def test_neighbours_in_two_parts_of_the_network_both_pass_a_heartbeat_on() -> None:
    async def story() -> None:
        floor = Floor(0.0, 1.0, 2.0)
        floor.network.begin(Partition((("V1", "M"),)))
        await floor.cut("V0")
        await floor.beat_and_wait("V0")
        assert [beat.via for beat in floor.beats("M")] == [("V1",)]
        assert [beat.via for beat in floor.beats("G")] == [("V2",)]

    play(story())


def test_a_gateways_own_link_can_be_in_trouble() -> None:
    async def story() -> None:
        floor = Floor(0.0, 1.0)
        floor.network.begin(LinkTrouble(sender="V1", receiver="M", loss_frac=1.0))
        await floor.cut("V0")
        await floor.beat_and_wait("V0")
        assert not floor.beats("M")
        assert len(floor.beats("G")) == 1

    play(story())


CALL = HelpCall("V0-1-1", "V0", 1, 1, 5.0, CallState.ASKING, 4.0, asked=("operator.a",), on_duty=1)
ANSWERED = CallAnswered("V0-1-1", "operator.a", CallAnswer.TAKE, 60.0)


@pytest.mark.parametrize("message", SAID, ids=lambda said: type(said).__name__)
def test_short_control_messages_go_both_ways(message: Message) -> None:
    async def story() -> None:
        floor = Floor(0.0, 20.0, 40.0)
        await floor.cut("V0", "V1")
        await floor.beat_and_wait("V0")
        floor.sessions["V0"].send("M", message)
        floor.sessions["M"].send("V0", message)
        await asyncio.sleep(SOON_S)
        assert floor.heard["M"][1:] == [("V0", message)]
        assert floor.heard["V0"] == [("M", message)]
        assert floor.heard["V1"] == []

    play(story())


def test_a_vehicle_without_wlan_calls_for_help_and_hears_who_comes() -> None:
    async def story() -> None:
        floor = Floor(0.0, 20.0)
        await floor.cut("V0")
        await floor.beat_and_wait("V0")
        operator: list[Message] = []
        session = floor.network.join("operator.a", lambda _sender, message: operator.append(message))
        session.subscribe("p/call/*")
        floor.sessions["V0"].publish("p/call/V0", CALL)
        await asyncio.sleep(SOON_S)
        session.send("V0", ANSWERED)
        await asyncio.sleep(SOON_S)
        assert operator == [CALL]
        assert floor.heard["V0"] == [("operator.a", ANSWERED)]

    play(story())


def test_the_short_control_messages_are_these_and_no_others() -> None:
    said = {type(message) for message in (*SAID, CALL, ANSWERED)}
    assert said == {kind for kind in typing.get_args(AnyMessage) if kind.radio}


@pytest.mark.parametrize("message", NOT_FOR_RADIO, ids=lambda said: type(said).__name__)
def test_what_is_not_for_the_radio_is_lost_and_counted_both_ways(message: Message) -> None:
    async def story() -> None:
        floor = Floor(0.0, 20.0)
        await floor.cut("V0")
        await floor.beat_and_wait("V0")
        floor.sessions["V0"].send("M", message)
        floor.sessions["V0"].publish("p/dwell-point/CH1", message)
        answer = (
            msgspec.structs.replace(message, atv="M") if isinstance(message, DwellPointClaimed) else message
        )
        floor.sessions["M"].send("V0", answer)
        await asyncio.sleep(SOON_S)
        assert len(floor.heard["M"]) == 1
        assert floor.heard["V0"] == []
        assert floor.network.lost == {UNFIT: 3}

    play(story())


def test_publications_do_not_fall_to_a_vehicle_without_wlan() -> None:
    async def story() -> None:
        floor = Floor(0.0, 20.0)
        floor.sessions["V0"].subscribe("p/task/*")
        await floor.cut("V0")
        await floor.beat_and_wait("V0")
        floor.sessions["M"].publish("p/task/0_0", Withdrawn("T", 1, Reason.NOT_NEEDED))
        await asyncio.sleep(SOON_S)
        assert floor.heard["V0"] == []
        assert floor.network.lost == {NO_WLAN: 1}

    play(story())


def test_two_vehicles_without_wlan_hear_one_another_by_radio_alone() -> None:
    async def story() -> None:
        floor = Floor(0.0, 20.0, 40.0)
        await floor.cut("V0", "V1", "V2")
        for number in range(3):
            floor.sessions[f"V{number}"].subscribe("p/hb/**")
        await floor.beat_and_wait("V0")
        floor.sessions["V0"].send("V2", Handover("T", 1, 5))
        await asyncio.sleep(SOON_S)
        assert [beat.via for beat in floor.beats("V1")] == [()]
        assert [beat.via for beat in floor.beats("V2")] == [("V1",)]
        assert {beat.link for name in ("V1", "V2") for beat in floor.beats(name)} == {Link.MESH}
        assert floor.heard["V2"][-1] == ("V0", Handover("T", 1, 5))
        assert not floor.heard["M"]

    play(story())


def test_a_neighbour_with_wlan_hears_the_heartbeat_once() -> None:
    async def story() -> None:
        floor = Floor(0.0, 10.0, 20.0)
        for name in ("V1", "V2"):
            floor.sessions[name].subscribe("p/hb/**")
        await floor.cut("V0")
        await floor.beat_and_wait("V0")
        assert len(floor.beats("V1")) == len(floor.beats("V2")) == 1

    play(story())


def test_a_word_to_a_neighbour_comes_once_though_others_could_pass_it_on() -> None:
    async def story() -> None:
        floor = Floor(0.0, 5.0, 10.0, 15.0)
        await floor.cut("V0", "V3")
        for number in range(10):
            floor.sessions["V0"].send("V3", Handover("T", 1, number))
            floor.sessions["V0"].send("V1", Handover("T", 1, number))
            await asyncio.sleep(SOON_S)
        for name in ("V1", "V3"):
            assert [said for _, said in floor.heard[name]] == [Handover("T", 1, n) for n in range(10)]

    play(story())


# --- what falls -------------------------------------------------------------------------------------


def test_nobody_reaches_a_vehicle_that_has_not_been_heard_by_radio() -> None:
    async def story() -> None:
        floor = Floor(0.0, 20.0)
        await floor.cut("V0")
        floor.sessions["M"].send("V0", DockOpened("T", 1, "S1"))
        await asyncio.sleep(SOON_S)
        assert not floor.heard["V0"]
        assert floor.network.lost == {NO_GATEWAY: 1}

    play(story())


def test_a_way_by_radio_is_forgotten_after_a_while() -> None:
    async def story() -> None:
        floor = Floor(0.0, 20.0)
        await floor.cut("V0")
        await floor.beat_and_wait("V0")
        await asyncio.sleep(GATEWAY_S - SOON_S - 0.5)
        floor.sessions["M"].send("V0", DockOpened("T", 1, "S1"))
        await asyncio.sleep(SOON_S)
        floor.sessions["M"].send("V0", DockOpened("T", 2, "S1"))
        await asyncio.sleep(SOON_S)
        assert [said for _, said in floor.heard["V0"]] == [DockOpened("T", 1, "S1")]
        assert floor.network.lost == {NO_GATEWAY: 1}

    play(story())


def test_a_gateway_that_has_left_passes_nothing_on() -> None:
    async def story() -> None:
        floor = Floor(0.0, 20.0)
        await floor.cut("V0")
        await floor.beat_and_wait("V0")
        floor.sessions["V1"].leave()
        floor.sessions["M"].send("V0", DockOpened("T", 1, "S1"))
        await floor.beat_and_wait("V0")
        assert not floor.heard["V0"]
        assert len(floor.beats("M")) == 1

    play(story())

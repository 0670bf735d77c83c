"""On probation: short tasks only, until enough were done well (paper, 4.2 case 6)."""

from __future__ import annotations

import pytest
from defaults import PLANT
from effects import facts, sent
from rigs import MachineRig, VehicleRig
from spoken import announcement, award, production, rhb, transport

from dray.messages import (
    Accepted,
    AtvHeartbeat,
    Bid,
    Declined,
    DockOpened,
    Handover,
    HandoverAccepted,
    MachineHeartbeat,
    ProbationBrief,
    Refusal,
    Role,
    Superseded,
)
from dray.messages.fact import BidRefused
from dray.protocol.contract_net.trust.probation import PASSED_OVER_ROUNDS, SHORT_S, Probation

SHORT = transport()
"""S3 is near p3, and M8 is not far from it: 80 s."""

LONG = transport(sources=("S1",), destination="M12")
"""To the other end of the plant: 106 s."""


def vehicle(probation: int = 2, node: str = "p3") -> VehicleRig:
    rig = VehicleRig(probation=probation, node=node)
    rig.start()
    return rig


def carry(rig: VehicleRig, number: int) -> None:
    """ATV1 does a transport well."""
    task = f"M8-{number}"
    rig.on_message("M8", award(task=task))
    rig.arrive()
    rig.picked()
    rig.arrive()
    rig.on_message("M8", DockOpened(task=task, epoch=1, station="M8"))
    rig.dropped()
    rig.on_message("M8", HandoverAccepted(task=task, epoch=1))
    rig.run(rig.now_s)


def told(rig: VehicleRig | MachineRig) -> ProbationBrief | None:
    rig.run(rig.now_s)
    kind = AtvHeartbeat if isinstance(rig, VehicleRig) else MachineHeartbeat
    return rig.heartbeats(kind)[-1].probation


def test_the_transports_of_these_tests_are_short_and_long() -> None:
    finish_s = [
        bid.finish_s
        for work in (SHORT, LONG)
        for bid in sent(vehicle(0).on_message("M8", announcement(work=work)), Bid)
    ]
    assert finish_s[0] <= SHORT_S < finish_s[1]


def test_on_probation_a_vehicle_bids_for_short_transports_only() -> None:
    rig = vehicle()
    assert len(sent(rig.on_message("M8", announcement(work=SHORT)), Bid)) == 1
    effects = rig.on_message("M1", announcement(task="M1-1", coordinator="M1", work=LONG))
    assert not sent(effects, Bid)
    [refused] = facts(effects, BidRefused)
    assert refused.reason is Refusal.NOT_FIT
    assert refused.detail.startswith("on probation")


def test_what_nobody_has_taken_is_taken_on_probation_too() -> None:
    rig = vehicle()
    again = announcement(task="M1-1", coordinator="M1", work=LONG, round=PASSED_OVER_ROUNDS + 1)
    assert len(sent(rig.on_message("M1", again), Bid)) == 1
    assert len(sent(rig.on_message("M1", award(task="M1-1", work=LONG)), Accepted)) == 1


def test_on_probation_a_vehicle_watches_nobody() -> None:
    rig = vehicle()
    watch = announcement(role=Role.SECONDARY, primary="ATV2", round=PASSED_OVER_ROUNDS + 1)
    assert not sent(rig.on_message("M8", watch), Bid)
    # Whoever has bid to carry it may be asked to watch it.
    [declined] = sent(rig.on_message("M8", award(role=Role.SECONDARY, primary="ATV2")), Declined)
    assert declined.reason is Refusal.NOT_FIT


def test_after_so_many_handovers_its_probation_is_over() -> None:
    rig = vehicle(2)
    assert told(rig) == ProbationBrief(of=2, done=0)
    carry(rig, 1)
    assert told(rig) == ProbationBrief(of=2, done=1)
    carry(rig, 2)
    assert told(rig) is None
    rig.arrive()
    far = announcement(task="M1-1", coordinator="M1", work=LONG)
    assert len(sent(rig.on_message("M1", far), Bid)) == 1


def test_a_transport_that_others_finish_does_not_count() -> None:
    rig = vehicle(1)
    rig.on_message("M8", award())
    rig.on_message("M8", Superseded(task="M8-1", epoch=2))
    assert told(rig) == ProbationBrief(of=1, done=0)


@pytest.mark.parametrize("make", [VehicleRig, MachineRig])
def test_who_is_not_on_probation_says_nothing_of_it(make: type[VehicleRig | MachineRig]) -> None:
    rig = make()
    rig.start()
    assert told(rig) is None


LOT = PLANT.products["pump-p3"].lot


def machine(probation: int = 1) -> MachineRig:
    full = {material: PLANT.materials[material].buffer for material in PLANT.materials_of("M7")}
    rig = MachineRig("M7", full, probation=probation)
    rig.start()
    return rig


def put_up(rig: MachineRig, pieces: int, number: int = 1, rounds: int = 1) -> list[Bid]:
    goal = announcement(
        task=f"G{number}", coordinator="STRATEGIST", work=production(quantity=pieces), round=rounds
    )
    return sent(rig.on_message("STRATEGIST", goal), Bid)


def test_on_probation_a_machine_takes_goals_of_one_container() -> None:
    rig = machine()
    assert len(put_up(rig, LOT)) == 1
    assert not put_up(rig, LOT + 1, 2)
    assert len(put_up(rig, LOT + 1, 2, PASSED_OVER_ROUNDS + 1)) == 1


def test_a_transport_that_is_handed_over_to_it_counts() -> None:
    rig = machine()
    rig.stock["housing"] = 0
    rig.run(1.0)
    rig.take_goal("G1", production())
    rig.hire("M7-1", "ATV1")
    rig.on_message("ATV1", rhb("ATV1", 1, rig.now_s, task="M7-1", coordinator="M7"))
    assert told(rig) == ProbationBrief(of=1, done=0)
    rig.on_message("ATV1", Handover(task="M7-1", epoch=1, quantity=24))
    assert told(rig) is None
    assert len(put_up(rig, 10 * LOT, 3)) == 1


def test_probation_ends_with_its_last_transport_and_counts_no_more() -> None:
    probation = Probation(1)
    probation.note_done()
    probation.note_done()
    assert not probation.lasts
    assert not probation.bars(short=False, round_number=1)

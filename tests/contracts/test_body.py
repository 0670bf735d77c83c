"""What `dray.ports.Body` guarantees, for every body that stands behind it.

A new implementation joins by one more `Case`: a body, something that it can do, something that it cannot,
and something that is not its business at all.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest
from msgspec.structs import replace

sys.path.insert(0, str(Path(__file__).parents[1] / "simulation/kits"))
sys.path.insert(0, str(Path(__file__).parents[1] / "adapters/vda5050"))
from vda_rig import FLOWING, PROFILE, Rig
from yard import PLANT, Yard, drive

from dray.adapters.vda5050.profile import Profile
from dray.body import (
    ActionFailed,
    CycleDone,
    CycleFailed,
    Hold,
    Instruction,
    NodePassed,
    Report,
    StartCycle,
    WayDone,
)
from dray.ports import Body
from dray_sim.bodies.workcell import SimWorkcell


@dataclass(frozen=True)
class Case:
    """One implementation of the port."""

    make: Callable[[Yard], Body]
    can: Instruction
    """Takes a while and is reported when it is done."""
    done: type[Report]
    cannot: Instruction
    """Is answered with a failure."""
    failed: type[Report]
    foreign: Instruction
    """Is for another kind of body."""
    seconds: float
    """After which all of it is over."""


def workcell(yard: Yard) -> Body:
    return SimWorkcell(PLANT.machines["M1"], PLANT, yard.clock, {"shaft": 50, "seal": 40})


def by_wire(yard: Yard, profile: Profile) -> Body:
    """A vehicle behind VDA 5050, of which something was heard."""
    rig = Rig(profile, yard=yard, delay_s=0.0)
    yard.run(0.0)
    return rig.body


CASES = {
    "vehicle": Case(
        make=lambda yard: yard.vehicle(),
        can=drive("west", "middle"),
        done=WayDone,
        cannot=drive("nowhere", order=2),
        failed=ActionFailed,
        foreign=StartCycle(product="gear"),
        seconds=100.0,
    ),
    **{
        f"vehicle behind VDA 5050 {profile.version}, {how}": Case(
            make=lambda yard, profile=profile: by_wire(yard, profile),
            can=drive("west", "middle"),
            done=WayDone,
            cannot=drive("nowhere", order=2),
            failed=ActionFailed,
            foreign=StartCycle(product="gear"),
            seconds=100.0,
        )
        for how, profile in (("steps", PROFILE), ("updates", replace(FLOWING, version="3.0")))
    },
    "workcell": Case(
        make=workcell,
        can=StartCycle(product="gear"),
        done=CycleDone,
        cannot=StartCycle(product="valve"),
        failed=CycleFailed,
        foreign=Hold(),
        seconds=100.0,
    ),
}


@pytest.fixture(params=CASES)
def case(request: pytest.FixtureRequest) -> Case:
    return CASES[request.param]


@pytest.fixture
def yard() -> Yard:
    return Yard()


@pytest.fixture
def body(case: Case, yard: Yard) -> Body:
    return case.make(yard)


@pytest.fixture
def heard(body: Body) -> list[Report]:
    heard: list[Report] = []
    body.attach(heard.append)
    return heard


def test_what_can_be_done_is_reported_when_it_is_done(
    case: Case, yard: Yard, body: Body, heard: list[Report]
) -> None:
    body.instruct(case.can)
    yard.run(1.0)
    assert not any(isinstance(report, case.done) for report in heard)
    yard.run(case.seconds)
    assert isinstance(heard[-1], case.done)


def test_what_cannot_be_done_is_answered_with_a_failure(
    case: Case, yard: Yard, body: Body, heard: list[Report]
) -> None:
    body.instruct(case.cannot)
    yard.run(0.0)
    assert [type(report) for report in heard] == [case.failed]


def test_no_report_comes_inside_an_instruction(
    case: Case, yard: Yard, body: Body, heard: list[Report]
) -> None:
    body.instruct(case.cannot)
    body.instruct(case.can)
    assert heard == []
    yard.run(case.seconds)
    assert heard


def test_reports_come_in_the_order_of_what_happened(
    case: Case, yard: Yard, body: Body, heard: list[Report]
) -> None:
    body.instruct(case.cannot)
    body.instruct(case.can)
    yard.run(case.seconds)
    kinds = [type(report) for report in heard if not isinstance(report, NodePassed)]
    assert kinds == [case.failed, case.done]


def test_a_body_that_is_told_something_while_it_reports_goes_on_as_told(
    case: Case, yard: Yard, body: Body
) -> None:
    heard: list[Report] = []

    def answer(report: Report) -> None:
        heard.append(report)
        if isinstance(report, case.failed):
            body.instruct(case.can)

    body.attach(answer)
    body.instruct(case.cannot)
    yard.run(case.seconds)
    assert isinstance(heard[-1], case.done)


def test_sensing_changes_nothing(case: Case, yard: Yard, body: Body, heard: list[Report]) -> None:
    body.instruct(case.can)
    yard.run(3.0)
    assert body.sense() == body.sense()
    other_yard = Yard()
    other = case.make(other_yard)
    other.instruct(case.can)
    for second in range(4):
        other_yard.run(float(second))
        other.sense()
    assert other.sense() == body.sense()
    yard.run(case.seconds)
    assert isinstance(heard[-1], case.done)


def test_only_the_last_one_attached_is_reported_to(
    case: Case, yard: Yard, body: Body, heard: list[Report]
) -> None:
    body.instruct(case.can)
    yard.run(3.0)
    early, late = len(heard), []
    body.attach(late.append)
    yard.run(case.seconds)
    assert len(heard) == early
    assert isinstance(late[-1], case.done)


def test_a_body_to_which_nobody_is_attached_works_all_the_same(case: Case, yard: Yard, body: Body) -> None:
    before = body.sense()
    body.instruct(case.cannot)
    body.instruct(case.can)
    yard.run(case.seconds)
    assert body.sense() != before


def test_an_instruction_for_another_kind_of_body_is_nobodys_business(
    case: Case, yard: Yard, body: Body, heard: list[Report]
) -> None:
    before = body.sense()
    body.instruct(case.foreign)
    assert body.sense() == before
    yard.run(0.0)
    assert heard == []

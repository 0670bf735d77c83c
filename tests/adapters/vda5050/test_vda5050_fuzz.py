"""Whatever a vehicle has said: once it is sane again, its driver has no problem left, and work goes on."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from odd_states import changed, odd_states
from vda_rig import FLOWING, PROFILE, Rig
from yard import PICK, TO_CORNER, UNHOLD, drive

from dray.body import ActionFailed, Drive, WayDone
from dray.messages import ProblemKind

VERSIONS = ("2.0", "2.1", "3.0")

SANE_S = 900.0
"""The longest that a problem which has come again and again is held, and an order that is cancelled again and again."""

TRIES = 3
"""An agent whose way was refused tries again."""

QUICK, LONG = 4, 900
"""Examples of 30 to 60 states; three versions at length are more than 100,000 states."""


def go_through(version: str, states: list[Any], *, flowing: bool, picks: bool, hears_it_too: bool) -> None:
    """Work is begun, odd states come, and honest ones afterwards.

    Args:
        version: of VDA 5050.
        states: the odd ones (`odd_states`).
        flowing: orders are updated while it drives.
        picks: the work is a pick, not a way.
        hears_it_too: honest states come between the odd ones.
    """
    # Its word for what is on board counts once a person has looked: nobody here takes a load off.
    rig = Rig(msgspec.structs.replace(FLOWING if flowing else PROFILE, version=version, load="type"))
    rig.do(PICK if picks else drive(*TO_CORNER), for_s=2.0)
    give = rig.give
    rig.give = lambda topic, data: give(topic, data) if hears_it_too or topic != "state" else None  # type: ignore[method-assign]
    for gap_s, changes in states:
        rig.run(gap_s)
        honest = rig.said("state", "it")[-1]
        give("state", changed(honest, changes, honest["headerId"] + 1))
    del rig.give  # type: ignore[method-assign]
    rig.body.instruct(UNHOLD)
    rig.vehicle.say_state()
    be_well(rig)
    if rig.body.sense().about_problem.kind is ProblemKind.LOAD:
        # It has said that a pick was done which was not, say: a person looks, as the problem asks for.
        for rig.vehicle.condition.mode in ("MANUAL", "AUTOMATIC"):
            rig.vehicle.say_state()
            rig.run(5.0)
        be_well(rig)
    assert rig.body.sense().problem == ""
    for order in range(100, 100 + TRIES):
        node = rig.body.sense().next_node
        goal = rig.yard.plant.roads.leaving[node][0].end
        heard = rig.do(Drive(order=order, nodes=(node, goal), released=2))
        ends_s = rig.clock.now_s() + 200.0
        while (
            not any(isinstance(one, WayDone | ActionFailed) for one in heard) and rig.clock.now_s() < ends_s
        ):
            heard += rig.do(for_s=5.0)
        if WayDone(order=order, node=goal) in heard:
            return
    pytest.fail(
        f"no way is driven any more: {rig.heard[-3:]}, {rig.body.control.waits_for(rig.clock.now_s())}"
    )


def be_well(rig: Rig) -> None:
    """Let time pass until its problems have ended."""
    ends_s = rig.clock.now_s() + SANE_S
    while rig.clock.now_s() < ends_s and not (rig.body.control.is_known and rig.body.sense().problem == ""):
        rig.run(20.0)
    assert rig.body.control.is_known


def fuzzed(version: str, count: int, told: Callable[[int], None] | None = None) -> None:
    """Go through so many lists of odd states.

    Args:
        version: of VDA 5050.
        count: how many lists.
        told: hears how long each was: at length, with other lists each time, and what fails is made shorter, which takes
            minutes.
    """
    at_length = told is not None
    phases = [Phase.generate, *([Phase.shrink] if at_length else [])]

    @settings(
        max_examples=count,
        derandomize=not at_length,
        phases=phases,
        deadline=None,
        suppress_health_check=list(HealthCheck),
        database=None,
    )
    @given(odd_states(version), st.booleans(), st.booleans(), st.booleans())
    def try_one(states: list[Any], flowing: bool, picks: bool, hears_it_too: bool) -> None:
        if told is not None:
            told(len(states))
        go_through(version, states, flowing=flowing, picks=picks, hears_it_too=hears_it_too)

    try_one()


@pytest.mark.filterwarnings("ignore:Generating overly large repr")
@pytest.mark.parametrize("version", VERSIONS)
def test_after_odd_states_work_goes_on(version: str) -> None:
    fuzzed(version, QUICK)


@pytest.mark.filterwarnings("ignore:Generating overly large repr")
@pytest.mark.campaign
@pytest.mark.parametrize("version", VERSIONS)
def test_after_a_hundred_thousand_odd_states_of_three_versions_work_goes_on(
    version: str, record_property: Callable[[str, object], None]
) -> None:
    lengths: list[int] = []
    fuzzed(version, LONG, lengths.append)
    record_property("seeds", f"{version}: {sum(lengths)} states")
    assert sum(lengths) >= 100_000 / len(VERSIONS)

"""Whatever a real body says, others can read what its agent tells: a talkative vehicle is not silenced."""

from __future__ import annotations

from typing import Any

from callers import OperatorRig
from defaults import PLANT
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from rigs import MachineRig, Rig, VehicleRig

from dray.body import (
    WORDS_MAX,
    ActionFailed,
    BodyState,
    Broken,
    CycleFailed,
    DutyChanged,
    GateState,
    GoodsArrived,
    ProblemRaised,
    StockChanged,
    StorageState,
    VehicleState,
    WorkcellState,
    bounded,
)
from dray.codec import decode, encode
from dray.messages import (
    AtvHeartbeat,
    BodyWait,
    Event,
    MachineHeartbeat,
    OperatorHeartbeat,
    Pose,
    StationHeartbeat,
)
from dray.protocol.gate.gate import DeliveryGate
from dray.protocol.runtime.events import Publish, Record, Send
from dray.protocol.station.station import Station

NUMBERS = st.floats() | st.sampled_from([2e6, -1e300, 1e11, -0.0])

WORDS = st.text(st.characters(), max_size=20) | st.text("x\ud800\udfff…", min_size=1).map(
    lambda some: some * 700
)
"""Lone surrogates and whole pages among them."""

POSES = st.builds(Pose, x_m=NUMBERS, y_m=NUMBERS, heading_rad=NUMBERS)

SENSED = st.fixed_dictionaries(
    {
        "pose": POSES,
        "speed_mps": NUMBERS,
        "battery_frac": NUMBERS,
        "next_node_s": NUMBERS,
        "problem": WORDS,
        "load_quantity": st.integers(),
        "wait": st.none() | st.builds(BodyWait, what=WORDS, since_s=NUMBERS, until=WORDS),
    }
)


def assert_read(rig: Rig, heartbeat: type) -> None:
    """All that the agent has said can be read, and a heartbeat was among it."""
    said = [effect.message for effect in rig.all if isinstance(effect, Send | Publish)]
    said += [
        Event(agent=rig.agent.id, incarnation=1, number=1, at_s=0.0, fact=effect.fact)
        for effect in rig.all
        if isinstance(effect, Record)
    ]
    for message in said:
        assert decode(encode(rig.agent.id, message)) == (rig.agent.id, message)
    assert heartbeat in {type(message) for message in said}


@settings(max_examples=examples(200))
@given(SENSED, WORDS, st.booleans())
def test_a_vehicle_with_any_values_and_words_is_heard(
    sensed: dict[str, Any], words: str, raises: bool
) -> None:
    rig = VehicleRig()
    state = bounded(replace(rig.sense(), **sensed))
    rig.sense = lambda: state  # type: ignore[method-assign]
    rig.start()
    rig.report(bounded(ProblemRaised(reason=words) if raises else ActionFailed(order=1, reason=words)))
    rig.run(12.0)
    assert_read(rig, AtvHeartbeat)


@settings(max_examples=examples(200))
@given(
    WORDS, st.dictionaries(st.sampled_from(["board", "shaft"]), st.integers()), st.booleans(), st.integers()
)
def test_a_machine_with_any_stock_and_words_is_heard(
    words: str, stock: dict[str, int], breaks: bool, change: int
) -> None:
    rig = MachineRig()
    state = rig.sense()
    state = bounded(replace(state, broken=words if breaks else "", stock=state.stock | stock))
    rig.sense = lambda: state  # type: ignore[method-assign]
    rig.start()
    rig.report(bounded(Broken(reason=words) if breaks else CycleFailed(product="gear", reason=words)))
    rig.report(bounded(StockChanged(item="shaft", change=change, seq=rig.sense().seq + 1, vehicle="")))
    rig.run(12.0)
    assert_read(rig, MachineHeartbeat)


@settings(max_examples=examples(100))
@given(
    st.dictionaries(st.sampled_from(["board", "shaft"]), st.integers()),
    st.integers(),
    st.integers(min_value=0),
)
def test_a_storage_with_any_stock_is_heard(stock: dict[str, int], change: int, seq: int) -> None:
    rig = Rig(Station("S1", PLANT))
    state = bounded(
        StorageState(
            stock={kept.material: 0 for kept in PLANT.storages["S1"].stocks} | stock, seq=0, opened=()
        )
    )
    rig.sense = lambda: state  # type: ignore[method-assign]
    rig.start()
    rig.report(bounded(StockChanged(item="shaft", change=change, seq=seq, vehicle="")))
    rig.run(12.0)
    assert_read(rig, StationHeartbeat)


@settings(max_examples=examples(100))
@given(st.integers(), st.integers())
def test_a_gate_with_any_count_is_heard(arrived: int, total: int) -> None:
    rig = Rig(DeliveryGate(PLANT))
    rig.sense = lambda: bounded(GateState(arrived={"O1-1.1": arrived}))  # type: ignore[method-assign]
    rig.start()
    rig.report(bounded(GoodsArrived("O1-1.1", total, 4, "ATV1")))
    rig.run(12.0)
    assert_read(rig, StationHeartbeat)


@settings(max_examples=examples(100))
@given(WORDS, st.none() | NUMBERS)
def test_whoever_is_on_duty_is_heard(label: str, busy_until_s: float | None) -> None:
    rig = OperatorRig("operator.A")
    rig.state = bounded(replace(rig.state, label=label, busy_until_s=busy_until_s))
    rig.start()
    rig.report(bounded(DutyChanged(replace(rig.state, label=label))))
    rig.run(12.0)
    assert_read(rig, OperatorHeartbeat)


@settings(max_examples=examples(300))
@given(SENSED)
def test_what_is_within_the_bounds_is_left_as_it_is_and_bounds_are_kept_twice(sensed: dict[str, Any]) -> None:
    once = bounded(replace(VehicleRig().sense(), **sensed))
    assert bounded(once) == once
    assert len(once.problem) <= WORDS_MAX
    honest: list[BodyState] = [VehicleRig().sense(), MachineRig().sense()]
    assert [bounded(state) for state in honest] == honest
    assert isinstance(once, VehicleState)
    stock = {"board": 7, "shaft": 0}
    storage = StorageState(stock=stock, seq=1, opened=())
    assert bounded(storage) == storage
    assert isinstance(honest[1], WorkcellState)

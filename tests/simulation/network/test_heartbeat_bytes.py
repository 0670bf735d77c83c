"""Heartbeats are as small as the paper asks (3.2): what has its default, and stock that has not changed, is not in each of them."""

from __future__ import annotations

import json
from typing import Any

import msgspec
import pytest

from dray.codec import encode
from dray.messages import AtvHeartbeat, MachineHeartbeat
from dray.messages.heartbeat_stock import with_stock
from dray.plant import default_plant
from dray_sim.run.stage import Shift, Stage, play

SPAN_S, WARM_UP_S = 1800.0, 300.0

Beats = dict[type[Any], list[tuple[str, Any]]]


@pytest.mark.slow
def test_heartbeats_have_at_most_half_of_the_bytes_that_they_would_have_with_all_in_each() -> None:
    """In one run, so at the same rate and the same bound of suspicion."""
    shift = Shift(name="bytes", duration_s=SPAN_S, load=0.6, keep=(AtvHeartbeat, MachineHeartbeat))
    beats = play(shift, default_plant(), 1, _listen).result
    assert beats is not None
    said = {kind: sum(len(encode(by, beat)) for by, beat in heard) for kind, heard in beats.items()}
    in_full = {kind: _in_full_bytes(heard) for kind, heard in beats.items()}
    assert min(len(heard) for heard in beats.values()) > 1000
    assert said[MachineHeartbeat] < 0.5 * in_full[MachineHeartbeat]
    assert sum(said.values()) < 0.5 * sum(in_full.values())


async def _listen(stage: Stage) -> Beats:
    await stage.until_s(SPAN_S)
    kinds = AtvHeartbeat, MachineHeartbeat
    return {
        kind: [(seen.agent, seen.said) for seen in stage.witness.all(kind, since_s=WARM_UP_S)]
        for kind in kinds
    }


def _in_full_bytes(heard: list[tuple[str, Any]]) -> int:
    """Of the same heartbeats, with every field in each."""
    total, last = 0, dict[str, MachineHeartbeat]()
    for by, beat in heard:
        told = beat
        if isinstance(beat, MachineHeartbeat):
            told = last[by] = with_stock(beat, last.get(by))
        envelope = {"v": 2, "from": by, "m": {"type": type(told).__name__} | _fields(told)}
        total += len(json.dumps(msgspec.to_builtins(envelope), separators=(",", ":")))
    return total


def _fields(value: Any) -> Any:
    if isinstance(value, msgspec.Struct):
        said = {name: getattr(value, name) for name in value.__struct_fields__}
        return {name: _fields(each) for name, each in said.items() if each is not msgspec.UNSET}
    return [_fields(each) for each in value] if isinstance(value, tuple) else value

"""The strategists of a simulated factory, and the gate that they share."""

from __future__ import annotations

from collections.abc import Iterator

from dray.messages.keys import GATE
from dray.messages.speakers import Kind
from dray.plant import Plant
from dray.protocol.gate.gate import DeliveryGate
from dray.protocol.strategist.gated import GatedStrategist
from dray_sim.bodies.gate import Gate
from dray_sim.factory.installation import MakeAgent, MakeBody, always


def with_gate(
    plant: Plant, gate: Gate, strategists: tuple[str, ...]
) -> Iterator[tuple[str, Kind, MakeAgent, MakeBody]]:
    """The gate and each strategist: how its agent is made, and its body. Strategists have none."""
    yield (
        GATE,
        Kind.GATE,
        lambda life, software, _probation: DeliveryGate(plant, incarnation=life, software=software),
        always(gate),
    )
    for strategist in strategists:
        yield strategist, Kind.STRATEGIST, _maker(plant, strategist, strategists), always(None)


def _maker(plant: Plant, agent: str, strategists: tuple[str, ...]) -> MakeAgent:
    others = tuple(other for other in strategists if other != agent)
    return lambda life, _software, _probation: GatedStrategist(
        plant, agent=agent, incarnation=life, others=others
    )

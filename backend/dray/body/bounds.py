"""Bounds of a body's reports and states."""

from __future__ import annotations

from typing import TypeVar

import msgspec

from dray.body.any_body import BodyState, Report
from dray.body.gate import GateProblem, GateState
from dray.body.operator import DutyChanged, DutyState
from dray.body.storage import StorageState
from dray.body.vehicle import ActionFailed, NodePassed, ProblemRaised, UnplacedVehicle, VehicleState
from dray.body.workcell import Broken, CycleFailed, WorkcellState
from dray.messages.base import COUNT_MAX, HEADING_MAX_RAD, LONGEST_S, METRES_MAX, SPEED_MAX_MPS, encodable
from dray.messages.heartbeat import BodyWait, Pose

Said = TypeVar("Said", bound=Report | BodyState)

WORDS_MAX = 500
"""Maximum characters of a body's texts: half of what a message may carry, since its agent adds to them."""


def bounded(said: Said) -> Said:
    """A report or a state of a real body, within the bounds of the wire.

    Every reader refuses a message beyond a bound, so one long text would silence a vehicle. Longer texts are cut and end with
    an ellipsis. Numbers become the nearest allowed one, and NaN becomes 0.
    """
    match said:
        case VehicleState(pose=pose):
            return msgspec.structs.replace(
                said,
                pose=Pose(
                    x_m=_between(pose.x_m, METRES_MAX),
                    y_m=_between(pose.y_m, METRES_MAX),
                    heading_rad=_between(pose.heading_rad, HEADING_MAX_RAD),
                ),
                next_node_s=max(0.0, _between(said.next_node_s, LONGEST_S)),
                speed_mps=_between(said.speed_mps, SPEED_MAX_MPS),
                battery_frac=max(0.0, _between(said.battery_frac, 1.0)),
                load_quantity=_count(said.load_quantity),
                problem=_words(said.problem),
                wait=said.wait and _wait(said.wait),
            )
        case UnplacedVehicle():
            return msgspec.structs.replace(said, why=_words(said.why))
        case ProblemRaised() | ActionFailed() | CycleFailed() | Broken():
            return msgspec.structs.replace(said, reason=_words(said.reason))
        case NodePassed():
            return msgspec.structs.replace(said, battery_frac=max(0.0, _between(said.battery_frac, 1.0)))
        case WorkcellState():
            return msgspec.structs.replace(said, broken=_words(said.broken), stock=_stock(said.stock))
        case GateState() | GateProblem():
            return msgspec.structs.replace(said, problem=_words(said.problem))
        case StorageState():
            return msgspec.structs.replace(said, stock=_stock(said.stock))
        case DutyState():
            busy_until_s = said.busy_until_s
            if busy_until_s is not None:
                busy_until_s = _between(busy_until_s, LONGEST_S)
            return msgspec.structs.replace(said, label=_words(said.label), busy_until_s=busy_until_s)
        case DutyChanged():
            return msgspec.structs.replace(said, state=bounded(said.state))
        case _:
            return said


def _words(text: str) -> str:
    text = encodable(text)
    return text if len(text) <= WORDS_MAX else text[: WORDS_MAX - 1] + "…"


def _wait(wait: BodyWait) -> BodyWait:
    return BodyWait(
        what=_words(wait.what), since_s=_between(wait.since_s, LONGEST_S), until=_words(wait.until)
    )


def _between(value: float, most: float) -> float:
    return min(max(value, -most), most) if value == value else 0.0  # noqa: PLR0124 - NaN differs from itself


def _count(value: int) -> int:
    return min(max(value, 0), COUNT_MAX)


def _stock(stock: dict[str, int]) -> dict[str, int]:
    return {item: _count(count) for item, count in stock.items()}

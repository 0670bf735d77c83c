"""Faults with their times, and how they are written down: JSON, checked when it is read.

[{"at_s": 60, "until_s": 300, "fault": {"kind": "wlan_cut", "agent": "ATV3"}}]
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, TypeVar

import msgspec
from msgspec import Meta

from dray_sim.faults.kinds import KIND_NAMES, Fault, describe
from dray_sim.faults.names import Cast, FaultError

MAX_BYTES = 1024 * 1024
"""A schedule of a whole day with a fault in every minute has some 200 kB."""

Moment = Annotated[float, Meta(ge=0.0, le=1e11)]
T = TypeVar("T")


class Timed(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A fault, and when it begins and ends (plant clock)."""

    at_s: Moment
    fault: Fault
    until_s: Moment | None = None
    """After `at_s`; None for a fault that is ended by other means, or never."""

    def __str__(self) -> str:
        end = "for ever" if self.until_s is None else f"until {self.until_s:.1f} s"
        return f"{self.at_s:8.1f} s  {describe(self.fault)} {end}"


def read_fault(data: bytes | str, cast: Cast) -> Fault:
    """Read one fault from JSON.

    Raises:
        FaultError: the JSON is no fault, or names an agent that is not in `cast`; names the field.
    """
    fault = _decode(data, _fault_decoder, "fault")
    cast.check(fault, "fault")
    return fault


def read_schedule(data: bytes | str, cast: Cast) -> tuple[Timed, ...]:
    """Read a schedule from JSON, in the order in which it is written.

    Raises:
        FaultError: the JSON is no schedule, or a fault in it names an agent that is not in `cast`; names the field.
    """
    schedule = _decode(data, _schedule_decoder, "schedule")
    for place, timed in enumerate(schedule):
        where = f"schedule[{place}]"
        if timed.until_s is not None and timed.until_s <= timed.at_s:
            reason = f"{timed.until_s:g} is not after at_s, {timed.at_s:g}; let it end later, or leave it out"
            raise FaultError(f"{where}.until_s", reason)
        cast.check(timed.fault, f"{where}.fault")
    return schedule


def write_schedule(schedule: Sequence[Timed]) -> bytes:
    """A schedule as JSON, a line for each fault; `read_schedule` gives the same back."""
    lines = b",\n ".join(msgspec.json.encode(timed) for timed in schedule)
    return b"[" + lines + b"]\n"


_fault_decoder: msgspec.json.Decoder[Fault] = msgspec.json.Decoder(Fault)
_schedule_decoder = msgspec.json.Decoder(tuple[Timed, ...])


def _decode(data: bytes | str, decoder: msgspec.json.Decoder[T], root: str) -> T:
    if len(data) > MAX_BYTES:
        raise FaultError(root, f"{len(data)} bytes, more than {MAX_BYTES}; split it")
    try:
        return decoder.decode(data)
    except (msgspec.MsgspecError, ValueError, RecursionError) as fault:
        # A decoder's own words end with the place, as "Expected `float` <= 1.0 - at `$[2].fault.loss_frac`".
        reason, _, path = str(fault).rpartition(" - at `$")
        if not reason:
            reason, path = str(fault), "`"
        if path.endswith("kind`"):
            reason += f"; the kinds are {', '.join(KIND_NAMES)}"
        raise FaultError(root + path[:-1], reason) from fault

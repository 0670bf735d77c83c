"""Fault injection into the simulated factory of `dray up`: the gateway's fault injector, across the threads."""

from __future__ import annotations

import asyncio
import inspect
from collections.abc import Callable
from typing import Any, TypeVar

import msgspec

from dray.cli.simulation.factory_thread import inside
from dray.gateway.factory.fault_injection import FaultKind, FaultRefused
from dray.gateway.live.views import FaultView
from dray_sim.faults import Fault, FaultError, Faults, kind_of, read_fault
from dray_sim.faults.kinds import KINDS

T = TypeVar("T")

SUBJECTS = ("agent", "atv", "machine", "sender", "receiver")
"""Fields of faults that may name an agent."""


class SimFaultInjector:
    """Begins and ends faults in a factory that runs in another thread.

    Args:
        faults: the factory's faults; used in its thread only.
        loop: the factory's loop.
        wall_s: the wall clock.
    """

    def __init__(self, faults: Faults, loop: asyncio.AbstractEventLoop, wall_s: Callable[[], float]) -> None:
        self._faults, self._loop, self._wall_s = faults, loop, wall_s

    @property
    def kinds(self) -> tuple[FaultKind, ...]:
        """See `FaultInjector.kinds`."""
        return tuple(_kind(each) for each in KINDS)

    async def begin(self, fault: dict[str, Any]) -> FaultView:
        """See `FaultInjector.begin`."""
        data = msgspec.json.encode(fault)
        name, begun = await self._inside(lambda: self._begin(data))
        told: dict[str, Any] = msgspec.to_builtins(begun)
        agents = {told[field] for field in SUBJECTS if field in told and "*" not in told[field]}
        return FaultView(
            id=name, kind=kind_of(begun), fault=told, agents=tuple(sorted(agents)), began_at_s=self._wall_s()
        )

    async def end(self, fault: str) -> None:
        """See `FaultInjector.end`."""
        await self._inside(lambda: self._end(fault))

    async def _inside(self, call: Callable[[], T]) -> T:
        """Call in the factory's thread.

        Raises:
            FaultRefused: for the simulator's `FaultError`.
            UnavailableError: the factory has ended, or is too busy.
        """
        try:
            return await inside(self._loop, call)
        except FaultError as error:
            # The whole request is the fault, so its fields need no prefix.
            field = error.field.removeprefix("fault").lstrip(".") or "body"
            raise FaultRefused(field, error.reason) from None

    # --- in the factory's thread ---

    def _begin(self, data: bytes) -> tuple[str, Fault]:
        fault = read_fault(data, self._faults.cast)
        return self._faults.begin(fault), fault

    def _end(self, fault: str) -> None:
        if fault in self._faults.active:
            self._faults.end(fault)


def _kind(fault: type[Fault]) -> FaultKind:
    info = msgspec.inspect.type_info(fault)
    assert isinstance(info, msgspec.inspect.StructType)  # noqa: S101 - every fault is one
    return FaultKind(
        kind=str(info.tag),
        what=(inspect.getdoc(fault) or "").partition("\n\n")[0].replace("\n", " "),
        fields=tuple(field.name for field in info.fields if field.required),
        optional=tuple(field.name for field in info.fields if not field.required),
    )

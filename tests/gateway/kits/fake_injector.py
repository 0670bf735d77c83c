"""A fault injector without a factory."""

from __future__ import annotations

from typing import Any

from wall_clock import NOW_S

from dray.errors import UnavailableError
from dray.gateway.factory.fault_injection import FaultKind, FaultRefused
from dray.gateway.live.views import FaultView


class FakeInjector:
    """A fault injector without a factory: it knows the agent ATV3 only."""

    kinds = (FaultKind("powered_off", "Switched off.", ("agent",)),)

    def __init__(self) -> None:
        self.begun: list[dict[str, Any]] = []
        self.ended: list[str] = []
        self.away = False
        """Whether the factory does not answer."""

    async def begin(self, fault: dict[str, Any]) -> FaultView:
        self._answer()
        if fault.get("agent") != "ATV3":
            raise FaultRefused("agent", "there is no such agent")
        self.begun.append(fault)
        name = f"f{len(self.begun)}"
        return FaultView(id=name, kind=fault["kind"], fault=fault, agents=("ATV3",), began_at_s=NOW_S)

    async def end(self, fault: str) -> None:
        self._answer()
        self.ended.append(fault)

    def _answer(self) -> None:
        if self.away:
            raise UnavailableError("the simulated factory", "does not answer", "look at the log")

"""Fault injection: a person causes a fault in a simulated factory.

The gateway knows neither the simulator nor the meaning of its faults. It passes data on and shows active
faults. The program that starts a gateway on a simulated factory provides an injector.
"""

from __future__ import annotations

from http import HTTPStatus
from typing import Any, Protocol

import msgspec

from dray.errors import InputError
from dray.gateway.http.problems import Problem
from dray.gateway.live.projection.injected_faults import InjectedFaults
from dray.gateway.live.views import FaultView


class FaultKind(msgspec.Struct, frozen=True):
    """A kind of fault."""

    kind: str
    what: str
    """Description in one line."""
    fields: tuple[str, ...]
    """Required fields beside `kind`."""
    optional: tuple[str, ...] = ()


class FaultRefused(InputError):
    """A fault that cannot be begun.

    Attributes:
        field: the field that is wrong.
        reason: why, and what to do.
    """

    def __init__(self, field: str, reason: str) -> None:
        self.field, self.reason = field, reason
        super().__init__(f"{field}: {reason}")


class FaultInjector(Protocol):
    """Begins and ends faults; both take effect before the answer comes."""

    @property
    def kinds(self) -> tuple[FaultKind, ...]:
        """All kinds that can be begun."""
        ...

    async def begin(self, fault: dict[str, Any]) -> FaultView:
        """Begin a fault.

        Args:
            fault: its `kind` and its fields.

        Raises:
            FaultRefused: the fault is impossible here.
            UnavailableError: the factory does not answer.
        """
        ...

    async def end(self, fault: str) -> None:
        """End a fault; harmless when it has ended.

        Raises:
            UnavailableError: the factory does not answer.
        """
        ...


class FaultInjection:
    """Faults by hand, and the active ones shown.

    Args:
        injector: None where the factory is not simulated.
        shown: the active faults on the panels.
    """

    def __init__(self, injector: FaultInjector | None, shown: InjectedFaults) -> None:
        self._injector, self.shown = injector, shown

    @property
    def injector(self) -> FaultInjector:
        """The injector.

        Raises:
            Problem: 409, the factory is not simulated.
        """
        if self._injector is None:
            raise Problem(
                HTTPStatus.CONFLICT,
                "not-simulated",
                "The factory is not simulated",
                "faults can be begun by hand in a simulated factory only: start one with `dray up`",
            )
        return self._injector

"""Fault injection: a person lets something go wrong, in a factory that is simulated.

The gateway knows neither the simulator nor what its faults mean. It hands on data, and shows what is at
work; whoever starts a gateway on a simulated factory gives it an injector.
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
    """What can go wrong."""

    kind: str
    what: str
    """In one line."""
    fields: tuple[str, ...]
    """Those that must be given, beside `kind`."""
    optional: tuple[str, ...] = ()


class FaultRefused(InputError):
    """A fault that cannot be begun.

    Attributes:
        field: which part of it cannot be used.
        reason: why, and what to do.
    """

    def __init__(self, field: str, reason: str) -> None:
        self.field, self.reason = field, reason
        super().__init__(f"{field}: {reason}")


class FaultInjector(Protocol):
    """Begins and ends faults; both take effect before the answer comes."""

    @property
    def kinds(self) -> tuple[FaultKind, ...]:
        """All that can be begun."""
        ...

    async def begin(self, fault: dict[str, Any]) -> FaultView:
        """Let something go wrong.

        Args:
            fault: its `kind` and its fields.

        Raises:
            FaultRefused: it makes no sense here.
            UnavailableError: the factory does not answer.
        """
        ...

    async def end(self, fault: str) -> None:
        """Put it right again; ending what has ended changes nothing.

        Raises:
            UnavailableError: the factory does not answer.
        """
        ...


class FaultInjection:
    """Faults by hand, and those that are shown as being at work.

    Args:
        injector: None where the factory is not simulated.
        shown: on the panels.
    """

    def __init__(self, injector: FaultInjector | None, shown: InjectedFaults) -> None:
        self._injector, self.shown = injector, shown

    @property
    def injector(self) -> FaultInjector:
        """Who begins and ends them.

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

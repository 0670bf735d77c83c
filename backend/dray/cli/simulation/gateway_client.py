"""A client for the fault injection of a running gateway, for the command line."""

from __future__ import annotations

from typing import Any
from urllib.parse import quote

import msgspec

from dray.cli.runtime.rest_client import RestClient


class Fault(msgspec.Struct, frozen=True):
    """An active fault."""

    id: str
    kind: str
    fault: dict[str, Any]
    agents: tuple[str, ...]
    began_at_s: float
    """Wall clock."""


class Kind(msgspec.Struct, frozen=True):
    """A kind of fault."""

    kind: str
    what: str
    fields: tuple[str, ...]
    optional: tuple[str, ...] = ()


class Faults(msgspec.Struct, frozen=True):
    """The active faults, and the possible kinds."""

    items: tuple[Fault, ...]
    kinds: tuple[Kind, ...]


class Gateway:
    """A client of one gateway.

    Args:
        url: its panel's address; None for the default of `dray up`.
        token: the caller's; None for the administrator's of the environment.

    Raises:
        SettingsError: the URL is invalid.
    """

    def __init__(self, url: str | None, token: str | None) -> None:
        self._client = RestClient(url, token, "see `dray fault list`")

    def faults(self) -> Faults:
        """The injected faults, and the possible kinds."""
        return self._client.ask("GET", "/api/faults", Faults)

    def begin_fault(self, fault: dict[str, Any]) -> Fault:
        """Inject a fault."""
        return self._client.ask("POST", "/api/faults", Fault, fault)

    def end_fault(self, fault: str) -> Fault:
        """End a fault."""
        return self._client.ask("DELETE", f"/api/faults/{quote(fault, safe='')}", Fault)

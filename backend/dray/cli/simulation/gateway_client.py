"""The faults of a running gateway, from the command line over REST."""

from __future__ import annotations

from typing import Any
from urllib.parse import quote

import msgspec

from dray.cli.runtime.rest_client import RestClient


class Fault(msgspec.Struct, frozen=True):
    """A fault that is at work."""

    id: str
    kind: str
    fault: dict[str, Any]
    agents: tuple[str, ...]


class Kind(msgspec.Struct, frozen=True):
    """What can go wrong."""

    kind: str
    what: str
    fields: tuple[str, ...]
    optional: tuple[str, ...] = ()


class Faults(msgspec.Struct, frozen=True):
    """Those at work, and the kinds that there are."""

    items: tuple[Fault, ...]
    kinds: tuple[Kind, ...]


class Gateway:
    """One gateway.

    Args:
        url: where its panel is; None for the address that `dray up` has by default.
        token: who asks; None for the administrator's of the environment.

    Raises:
        SettingsError: it is no address of the web.
    """

    def __init__(self, url: str | None, token: str | None) -> None:
        self._client = RestClient(url, token, "see `dray fault list`")

    def faults(self) -> Faults:
        """What is wrong by hand, and what could be."""
        return self._client.ask("GET", "/api/faults", Faults)

    def begin_fault(self, fault: dict[str, Any]) -> Fault:
        """Let something go wrong."""
        return self._client.ask("POST", "/api/faults", Fault, fault)

    def end_fault(self, fault: str) -> Fault:
        """Put it right again."""
        return self._client.ask("DELETE", f"/api/faults/{quote(fault, safe='')}", Fault)

"""Computers that are network namespaces of this one, with real links between them.

    ATV3 --wlan0-- the WLAN: a bridge in a namespace of its own --wlan0-- M8
    ATV3 --ATV1-------- a link of the vehicles' radio ------ATV3-- ATV1

Nothing of this computer's own network is touched. Every namespace is named with the process's id, and is
removed in the end with all that is in it.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from itertools import combinations
from typing import Self

from dray.errors import UnavailableError

WLAN, RADIO = "10.7.0.{}", "10.8.{}.{}"
"""Addresses: one network for the WLAN, one for every link of the radio."""

RADIO_NETWORK = "10.8.0.0/16"

WLAN_INTERFACE, BRIDGE = "wlan0", "air"


@dataclass(frozen=True, slots=True)
class Computers:
    """Some computers on one WLAN, and a radio link between any two of the vehicles.

    Attributes:
        names: of all of them.
        vehicles: those with a radio.
    """

    names: tuple[str, ...]
    vehicles: tuple[str, ...]

    @classmethod
    @contextmanager
    def opened(cls, names: Sequence[str], vehicles: Sequence[str]) -> Iterator[Self]:
        """All of them, with their links up, as long as the context lasts.

        Raises:
            UnavailableError: this computer does not have, or allow, namespaces of networks.
        """
        computers = cls(tuple(names), tuple(vehicles))
        with ExitStack() as stack:
            for name in (BRIDGE, *names):
                _ip("netns", "add", _namespace(name))
                stack.callback(_ip, "netns", "del", _namespace(name))
            computers._connect()
            yield computers

    def command(self, name: str, *command: str) -> tuple[str, ...]:
        """A command that runs on one of them."""
        return _iproute2(), "netns", "exec", _namespace(name), *command

    def wlan_address(self, name: str) -> str:
        """Its address on the WLAN."""
        return WLAN.format(self.names.index(name) + 1)

    def radio_address(self, name: str, neighbour: str) -> str:
        """Its address on the radio link to a neighbour."""
        pair = tuple(sorted((name, neighbour)))
        return RADIO.format(self._pairs.index(pair), pair.index(name) + 1)

    def switch_wlan(self, name: str, to: str) -> None:
        """Switch its WLAN ``up`` or ``down``."""
        _ip("-n", _namespace(name), "link", "set", WLAN_INTERFACE, to)

    def switch_radio(self, name: str, to: str) -> None:
        """Likewise its radio, to all neighbours."""
        for neighbour in self.vehicles:
            if neighbour != name:
                _ip("-n", _namespace(name), "link", "set", neighbour, to)

    @property
    def _pairs(self) -> list[tuple[str, ...]]:
        return list(combinations(sorted(self.vehicles), 2))

    def _connect(self) -> None:
        air = _namespace(BRIDGE)
        _ip("-n", air, "link", "add", BRIDGE, "type", "bridge")
        _ip("-n", air, "link", "set", BRIDGE, "up")
        for name in self.names:
            _cable(_namespace(name), WLAN_INTERFACE, air, name)
            _ip("-n", air, "link", "set", name, "master", BRIDGE)
            _give(_namespace(name), WLAN_INTERFACE, f"{self.wlan_address(name)}/24")
        for one, other in self._pairs:
            _cable(_namespace(one), other, _namespace(other), one)
            for here, there in ((one, other), (other, one)):
                _give(_namespace(here), there, f"{self.radio_address(here, there)}/24")


def _cable(one: str, plug: str, other: str, other_plug: str) -> None:
    """Join two namespaces by a pair of interfaces."""
    _ip("-n", one, "link", "add", plug, "type", "veth", "peer", "name", other_plug, "netns", other)
    for namespace, interface in ((one, plug), (other, other_plug)):
        _ip("-n", namespace, "link", "set", interface, "up")


def _give(namespace: str, interface: str, address: str) -> None:
    _ip("-n", namespace, "address", "add", address, "dev", interface)


def _namespace(name: str) -> str:
    return f"dray-{os.getpid()}-{name}"


def _iproute2() -> str:
    found = shutil.which("ip")
    if found is None:
        raise UnavailableError(
            "iproute2", "is not installed", "install it; on Debian: apt-get install iproute2"
        )
    return found


def _ip(*arguments: str) -> None:
    done = subprocess.run(  # noqa: S603 (no shell, and no word of a stranger's)
        [_iproute2(), *arguments], capture_output=True, text=True, check=False
    )
    if done.returncode:
        reason = done.stderr.strip() or f"ip has ended with {done.returncode}"
        raise UnavailableError(
            "network namespaces", reason, "they need Linux and root, or CAP_SYS_ADMIN and CAP_NET_ADMIN"
        )

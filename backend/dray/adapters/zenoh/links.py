"""A process's links to the others: their addresses, their discovery, their security.

Every session is a Zenoh router, so neighbours relay for one another. Any remaining path bypasses a cut link. Links are TLS with
mutual authentication; plain TCP must be requested explicitly.
"""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import Any

import zenoh

from dray.adapters.security.identity import Identity
from dray.adapters.zenoh.access import Apart
from dray.errors import SettingsError, UnavailableError

RETRY_MS = {"period_init_ms": 500, "period_max_ms": 4000, "period_increase_factor": 2}
"""Delays between calls of a peer that does not answer: it is back within some seconds, and a peer gone for good costs almost
nothing."""

QUEUE_BATCHES = 16
"""Maximum batches of 64 kB each that wait on one link: 1 MB is more than all agents send within any lease. A peer that cannot
take it has been silent for longer."""

DROP_AT_ONCE_US = 0
"""A full link delays nobody: further messages are lost, and their receivers count them."""

RUNTIME = ("ZENOH_RUNTIME", "(rx: (worker_threads: 32))")
"""Set before Zenoh starts, unless it is set already. A link that dies silently with unsent data holds one of these threads for
ten seconds (eclipse-zenoh/zenoh#1101). In that time the system still tries to send. With the default of two threads, a vehicle
that lost its WLAN heard nothing by its radio either. Now 32 links may die at once."""

SCOUTING_MS = 10
"""The wait for other processes at the start: none is needed, and later ones are linked later."""


@dataclass(frozen=True, slots=True)
class Links:
    """The links of one process.

    Attributes:
        listen: HOST:PORT each; port 0 lets the system choose one.
        peers: HOST:PORT of the peers, called until they answer.
        multicast: find others on the same network by multicast.
        identity: our own identity; None only with `plain`.
        plain: TCP without encryption or authentication: any process that reaches the port may send anything.
        lease_s: seconds of silence after which a link is closed and bypassed.
        apart: messages refused on links with vehicles; only with an identity, and in a wired process.
    """

    listen: tuple[str, ...] = ()
    peers: tuple[str, ...] = ()
    multicast: bool = False
    identity: Identity | None = None
    plain: bool = False
    lease_s: float = 2.0
    apart: Apart | None = None

    def open(self) -> zenoh.Session:
        """Open the links; takes some 10 ms, and does not wait for peers.

        Raises:
            SettingsError: there is neither an identity nor `plain`, or an address is invalid.
            UnavailableError: listening on an address failed.
        """
        config = self.config()
        os.environ.setdefault(*RUNTIME)
        try:
            return zenoh.open(config)
        except zenoh.ZError as error:
            where = ", ".join(self.listen) or "no address"
            # The text after this names a place in Zenoh's own sources.
            reason = str(error).splitlines()[0].partition(" at /")[0]
            raise UnavailableError(
                f"the bus on {where}", reason, "choose another address, or free this one"
            ) from None

    def config(self) -> zenoh.Config:
        """The links as Zenoh's configuration."""
        if self.identity is None and not self.plain:
            raise SettingsError(
                "DRAY_BUS_CERTIFICATES",
                "agents on many computers need certificates: name the folder that `dray certs` has made, "
                "or allow plain TCP with DRAY_BUS_PLAIN=true on a network that nobody else can reach",
            )
        linked_by_itself = ["router"] if self.multicast else []
        settings: dict[str, Any] = {
            "mode": "router",
            "listen/endpoints": [self._endpoint(address) for address in self.listen],
            "connect/endpoints": [self._endpoint(address) for address in self.peers],
            "connect/exit_on_failure": False,
            "connect/timeout_ms": -1,
            "connect/retry": RETRY_MS,
            "scouting/delay": SCOUTING_MS,
            "scouting/multicast/enabled": self.multicast,
            "scouting/multicast/autoconnect": {"router": linked_by_itself},
            "scouting/gossip/enabled": self.multicast,
            "scouting/gossip/autoconnect": {"router": linked_by_itself},
            "timestamping/enabled": {"router": False},
            "transport/link/tx/lease": int(self.lease_s * 1000),
            "transport/link/tx/queue/size/data": QUEUE_BATCHES,
            "transport/link/tx/queue/congestion_control/drop/wait_before_drop": DROP_AT_ONCE_US,
            "transport/shared_memory/enabled": False,
        }
        if self.identity is not None:
            settings |= {
                "transport/link/protocols": ["tls"],
                "transport/link/tls/root_ca_certificate": str(self.identity.authority),
                "transport/link/tls/enable_mtls": True,
                # A vehicle has no name in a DNS; its certificate has its identity.
                "transport/link/tls/verify_name_on_connect": False,
                "transport/link/tls/close_link_on_expiration": True,
            }
            for side in ("listen", "connect"):
                settings[f"transport/link/tls/{side}_certificate"] = str(self.identity.certificate)
                settings[f"transport/link/tls/{side}_private_key"] = str(self.identity.key)
            if self.apart is not None:
                settings["access_control"] = self.apart.config()
        config = zenoh.Config()
        for path, value in settings.items():
            config.insert_json5(path, json.dumps(value))
        return config

    def _endpoint(self, address: str) -> str:
        host, colon, port = address.rpartition(":")
        if not (host and colon and port.isdecimal() and int(port) < 2**16):
            raise SettingsError(address, "is no address for the bus; write HOST:PORT")
        return f"{'tcp' if self.identity is None else 'tls'}/{address}"

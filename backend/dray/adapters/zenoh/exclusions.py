"""Exclusions on the real bus: one process's knowledge of the excluded agents.

Gateways repeat the list on one key (`dray.messages.shutout`), and each process subscribes to it, independently of its
agents. It stores the newest list, so that its next life knows it before any message, even while no gateway is there.

A list's number is the time of its decision. One from the future, of a gateway whose clock is ahead or of a thief of its certificate,
counts as the present time. So people's next decision is always newer.
"""

from __future__ import annotations

import logging
import os
import threading
import time
from collections.abc import Callable
from pathlib import Path

import msgspec
import zenoh

from dray.adapters.spares import Spares
from dray.adapters.zenoh.bus import ZenohBus
from dray.adapters.zenoh.shares import Shares
from dray.adapters.zenoh.stamp import Tally
from dray.messages import ShutOut

log = logging.getLogger(__name__)

_read = msgspec.json.Decoder(ShutOut).decode
_write = msgspec.json.Encoder().encode


class Exclusions:
    """Tells a bus which agents are excluded, until it is ended.

    Args:
        bus: the bus of this process.
        file: the stored list; created when there is something to store.
        now_s: unix time.
    """

    def __init__(self, bus: ZenohBus, file: Path, now_s: Callable[[], float] = time.time) -> None:
        self._bus, self._file, self._now_s = bus, file, now_s
        self._lock = threading.Lock()
        self._list = self._read_list()
        self._shares = Shares(Tally(), bus.speed)
        bus.shut_out = frozenset(self._list.agents)
        self._ear = bus.inner.declare_subscriber(bus.keys.shut_out, bus.on_zenohs_thread(self._on_sample))
        self._spares = Spares(bus.inner)
        self._spares.of_subscription(bus.keys.shut_out)

    def end(self) -> None:
        """Take no more decisions; earlier ones hold as long as the bus is used."""
        self._spares.end()
        self._ear.undeclare()

    def _on_sample(self, sample: zenoh.Sample) -> None:
        """On Zenoh's threads."""
        heard = self._bus.read(self._bus.keys.shut_out, sample, self._shares)
        if heard is not None and isinstance(heard.message, ShutOut):
            self._take(heard.sender, heard.message)

    def _take(self, gateway: str, said: ShutOut) -> None:
        with self._lock:
            number = min(said.number, int(self._now_s() * 1000))
            if said.number <= self._list.number or (
                said.number > number and said.agents == self._list.agents
            ):
                return
            before, self._list = set(self._list.agents), ShutOut(number, said.agents)
            self._bus.shut_out = frozenset(said.agents)
            self._keep(self._list)
        for agent in sorted(before.symmetric_difference(said.agents)):
            log.warning("%s is %s, says %s", agent, "readmitted" if agent in before else "shut out", gateway)

    def _read_list(self) -> ShutOut:
        try:
            kept = _read(self._file.read_bytes())
            # Earlier versions have kept numbers from the future.
            return ShutOut(min(kept.number, int(self._now_s() * 1000)), kept.agents)
        except FileNotFoundError:
            return ShutOut(number=0)
        except (OSError, msgspec.MsgspecError) as error:
            log.warning("%s: %s; who is shut out is known when a gateway says it", self._file, error)
            return ShutOut(number=0)

    def _keep(self, said: ShutOut) -> None:
        """Replace the file as a whole: an interrupted process leaves the old one."""
        fresh = self._file.with_name(f"{self._file.name}.new")
        try:
            self._file.parent.mkdir(parents=True, exist_ok=True)
            with fresh.open("wb") as file:
                file.write(_write(said))
                file.flush()
                os.fsync(file.fileno())
            fresh.replace(self._file)
        except OSError as error:
            log.warning("%s cannot be written: %s; the next start hears it from a gateway", self._file, error)

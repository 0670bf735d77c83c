"""The radio between vehicles: short range, small frames, few of them, passed on from one to the next.

A frame is flooded: a vehicle that hears it for the first time sends it again, up to `hops` hops. The receiver does
not, nor does a vehicle that can relay it to the bus. Later copies are dropped, so a frame takes the first way that
worked. The network interprets frames, and decides which vehicles relay to the bus.

Each vehicle has a token bucket: excess frames are dropped and counted, never queued.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import hypot
from typing import TYPE_CHECKING

from dray.codec import encode
from dray.messages import AtvHeartbeat
from dray.messages.radio import shortened, shortened_word
from dray_sim.network.latency import QUANTILE_BITS, Latency

if TYPE_CHECKING:
    from random import Random

    from dray.messages import Message
    from dray_sim.clock.loop import VirtualClock
    from dray_sim.network.modem import Modem

UNFIT = "not for the radio"
TOO_LONG = "too long for the radio"
TOO_MANY = "radio rate"
FADED = "radio loss"
NOBODY_NEAR = "nobody in radio range"


HOP = Latency(base_s=0.025, mean_extra_s=0.015, cap_s=0.250)
"""One hop: the air time of a long frame, and listening before talking."""


@dataclass(frozen=True, slots=True)
class RadioSpec:
    """The properties of the radio: a module for industrial sub-gigahertz bands, 250 kbit/s.

    Attributes:
        range_m: in a hall; beyond it nothing is heard.
        hops: a frame is sent at most so often on one way. Four reach through a hall of 100 m.
        frame_bytes: the longest frame. A heartbeat on the wire's JSON has some 500; IEEE 802.15.4g allows 2047, and
            shorter frames are lost less often.
        rate_hz: frames per second that a vehicle may send in the long run: a fifth of the air time.
        burst: frames at once: a heartbeat, its neighbours' and the words of a docking.
        loss_frac: frames that one receiver does not get.
        latency: of one hop.
    """

    range_m: float = 25.0
    hops: int = 4
    frame_bytes: int = 768
    rate_hz: float = 8.0
    burst: float = 8.0
    loss_frac: float = 0.02
    latency: Latency = HOP


RADIO = RadioSpec()


@dataclass(eq=False, slots=True)
class Frame:
    """Something on the air, all its copies together.

    Attributes:
        origin: the sender.
        message: the content.
        key: where it is published; empty when it is for one agent.
        to: that one agent; empty when it is published.
        rising: from a vehicle towards the bus; the other way round it goes to a vehicle.
        heard: vehicles that have heard it.
        gateways: vehicles that have relayed it to the bus.
        reached: the one agent that it is for, once it has come there, by radio or by the bus.
    """

    origin: str
    message: Message
    key: str = ""
    to: str = ""
    rising: bool = True
    heard: dict[str, None] = field(default_factory=dict)
    gateways: list[str] = field(default_factory=list)
    reached: list[str] = field(default_factory=list)


Take = Callable[["Modem", Frame, tuple[str, ...]], bool]
"""Handles a frame that came over these relays at a station; true when the station should send it again."""


class Radio:
    """All vehicles' radios, and the air between them.

    Args:
        clock: hops are its callbacks.
        random: the only source of chance.
        spec: the radios' properties.
        stations: all that have a radio, in the order in which they came.
        on_air: whether a vehicle's radio works at this moment.
        take: asked for every frame that a station hears for the first time.
        lost: where losses are counted, by reason.

    Attributes:
        sent: frames put on the air, those that were said again included.
    """

    def __init__(
        self,
        clock: VirtualClock,
        random: Random,
        spec: RadioSpec,
        *,
        stations: Mapping[str, Modem],
        on_air: Callable[[str], bool],
        take: Take,
        lost: Counter[str],
    ) -> None:
        self.spec = spec
        self.sent = 0
        self._clock = clock
        self._random = random
        self._delays_s = spec.latency.quantiles()
        self._stations = stations
        self._on_air = on_air
        self._take = take
        self._lost = lost

    def shorten(self, sender: str, message: Message) -> Message | None:
        """The part of a message that goes into a frame; None when it may not or cannot, which is counted.

        The frame's own header (sender, receiver, relays) is not counted.
        """
        if not message.radio and type(message) is not AtvHeartbeat:
            self._lost[UNFIT] += 1
            return None
        shorter = shortened(message) if isinstance(message, AtvHeartbeat) else shortened_word(message)
        for short in shorter:
            if len(encode(sender, short)) <= self.spec.frame_bytes:
                return short
        self._lost[TOO_LONG] += 1
        return None

    def send(self, station: Modem, frame: Frame, via: tuple[str, ...] = ()) -> None:
        """Put a frame on the air.

        Args:
            station: whose radio.
            frame: to be sent; `station` counts as one that has heard it.
            via: its relays so far, this station included if it is one.
        """
        frame.heard[station.agent] = None
        if not self._spend_token(station):
            self._lost[TOO_MANY] += 1
            return
        self.sent += 1
        now_s, spec, random = self._clock.time_s, self.spec, self._random
        x_m, y_m = station.position_m(now_s)
        alone = True
        for other in self._stations.values():
            if other.agent in frame.heard or not self._on_air(other.agent):
                continue
            other_x_m, other_y_m = other.position_m(now_s)
            if hypot(other_x_m - x_m, other_y_m - y_m) > spec.range_m:
                continue
            alone = False
            if random.random() < spec.loss_frac:
                self._lost[FADED] += 1
                continue
            when_s = now_s + self._delays_s[random.getrandbits(QUANTILE_BITS)]
            self._clock.call_at(when_s, self._arrive, other, frame, via)
        if alone and not via:
            self._lost[NOBODY_NEAR] += 1

    def _arrive(self, station: Modem, frame: Frame, via: tuple[str, ...]) -> None:
        if station.agent in frame.heard or not self._on_air(station.agent):
            return
        frame.heard[station.agent] = None
        if self._take(station, frame, via) and len(via) + 1 < self.spec.hops:
            self.send(station, frame, (*via, station.agent))

    def _spend_token(self, station: Modem) -> bool:
        now_s, spec = self._clock.time_s, self.spec
        tokens = station.tokens + (now_s - station.tokens_s) * spec.rate_hz
        station.tokens, station.tokens_s = min(tokens, spec.burst), now_s
        if station.tokens < 1.0:
            return False
        station.tokens -= 1.0
        return True

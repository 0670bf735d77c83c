"""When silence becomes failure: pure arithmetic.

An agent's status tells how often it sends heartbeats, so any receiver can judge its silence. The bound depends on
how its heartbeats have arrived so far:

    bound_s = misses * interval_s + lateness_s

    misses       losses in a row that chance causes once in 1 / FALSE_ALARM heartbeats,
                 at the measured loss: 3 up to 4.6 % loss, 6 at 20 %, 11 at 40 %
    lateness_s   four mean deviations of the delay, as in RFC 6298, and never below JITTER_S

On a good link a working vehicle is suspected after 3.5 s. The bound never exceeds MISSES_MAX intervals and
LATENESS_MAX_S: a worse link is no link.
"""

from __future__ import annotations

from math import ceil, log

from msgspec import UNSET

from dray.messages import AtvHeartbeat, MachineHeartbeat, StationHeartbeat

WORKING_INTERVAL_S = 1.0
"""A working agent beats at 1 Hz: a takeover is due within a few seconds of its death."""

IDLE_INTERVAL_S = 5.0
"""An idle agent beats at 0.2 Hz: no agent waits for it, so it need not load the network (paper, 3.2)."""

FALSE_ALARM = 1e-4
"""Accepted rate of false suspicions per heartbeat: at 1 Hz one unnecessary takeover in nearly three hours of work."""

MISSES = 3
"""Minimum losses allowed, even on a link without losses so far."""

MISSES_MAX = 12

JITTER_S = 0.5
"""More than the latency of a loaded WLAN, less than half a working interval."""

LATENESS_MAX_S = 5.0
"""The worst link that is still a link (paper, case 3)."""

GAIN = 1.0 / 32.0
"""Weight of the newest heartbeat: half a minute of work is remembered, and one loss changes little."""

DEVIATIONS = 4.0
"""Allowed lateness of a message in mean deviations (RFC 6298)."""

BREAKDOWN_S = 600.0
"""How long a broken machine may keep its goals (s). A technician mends most breakdowns in less, and finished pieces are
carried away meanwhile."""

GOAL_SILENCE_S = 15.0
"""How long a machine may omit a goal before it has lost it (s). A machine with goals beats at 1 Hz, so fifteen heartbeats
are missing in a row; a restart of its software takes less."""

CLEAN_FRAC = 0.04
"""Up to this loss `MISSES` losses in a row are rare enough, without arithmetic."""

AnyHeartbeat = AtvHeartbeat | MachineHeartbeat | StationHeartbeat


def interval_s(heartbeat: AnyHeartbeat) -> float:
    """Time until the next heartbeat after this one (s).

    Others rely on an agent with a task or goals, even while the last goods are on the way. People wait for news of
    an agent that needs help. An agent out of service calls nobody.
    """
    match heartbeat:
        case AtvHeartbeat():
            is_relied_on = heartbeat.task is not None or _needs_somebody(heartbeat)
        case MachineHeartbeat():
            is_relied_on = bool(heartbeat.goals) or _needs_somebody(heartbeat)
        case StationHeartbeat():
            is_relied_on = False
    return WORKING_INTERVAL_S if is_relied_on else IDLE_INTERVAL_S


def _needs_somebody(heartbeat: AtvHeartbeat | MachineHeartbeat) -> bool:
    """Whether it reports a problem for which a person is called."""
    return bool(heartbeat.problem) and heartbeat.out_of_service is UNSET


def allowed_misses(loss_frac: float) -> int:
    """Losses in a row without a suspicion, at this loss fraction."""
    if loss_frac <= CLEAN_FRAC:
        return MISSES
    if loss_frac >= 1.0:
        return MISSES_MAX
    return min(max(ceil(log(FALSE_ALARM) / log(loss_frac)), MISSES), MISSES_MAX)


def bound_s(interval_s: float, loss_frac: float = 0.0, deviation_s: float = 0.0) -> float:
    """How long an agent that beats every `interval_s` may be silent without a suspicion (s).

    Args:
        interval_s: between two heartbeats.
        loss_frac: the fraction of heartbeats that is lost.
        deviation_s: the mean deviation of their delays.
    """
    lateness_s = DEVIATIONS * deviation_s
    if lateness_s < JITTER_S:
        lateness_s = JITTER_S
    elif lateness_s > LATENESS_MAX_S:
        lateness_s = LATENESS_MAX_S
    misses = MISSES if loss_frac <= CLEAN_FRAC else allowed_misses(loss_frac)
    return misses * interval_s + lateness_s


def silence_bound_s(heartbeat: AnyHeartbeat, arrivals: ArrivalStatistics) -> float:
    """How long an agent may be silent after this heartbeat before it counts as failed (s).

    Args:
        heartbeat: its newest.
        arrivals: arrival statistics of its heartbeats at the observer.
    """
    if isinstance(heartbeat, MachineHeartbeat) and heartbeat.goals:
        return GOAL_SILENCE_S
    return bound_s(interval_s(heartbeat), arrivals.loss_frac, arrivals.deviation_s)


def gone_s(every_s: float) -> float:
    """Silence that no link explains, however bad (s).

    Args:
        every_s: the agent's interval.
    """
    return MISSES_MAX * every_s + LATENESS_MAX_S


class ArrivalStatistics:
    """Running estimates of the loss and the delay of heartbeats.

    Args:
        prior: initial values: the same agent's statistics of others' heartbeats.
    """

    __slots__ = ("deaf_s", "delay_s", "deviation_s", "heard", "loss_frac")

    def __init__(self, prior: ArrivalStatistics | None = None) -> None:
        self.heard: int = 0 if prior is None else prior.heard
        """Heartbeats so far."""
        self.loss_frac: float = 0.0 if prior is None else prior.loss_frac
        self.delay_s: float = 0.0 if prior is None else prior.delay_s
        """The mean delay (s)."""
        self.deviation_s: float = 0.0 if prior is None else prior.deviation_s
        """The mean deviation of the delay (s)."""
        self.deaf_s = 0.0
        """Total time in which the listening agent itself was held up (s): silence in that time does not count."""

    def note(self, missed: int, delay_s: float) -> None:
        """Update the estimates by one heartbeat.

        Args:
            missed: heartbeats lost before this one.
            delay_s: its delay by the plant's clock.
        """
        # Beyond these bounds one of two clocks is wrong, not the link.
        if delay_s < 0.0:
            delay_s = 0.0
        elif delay_s > LATENESS_MAX_S:
            delay_s = LATENESS_MAX_S
        loss_frac = self.loss_frac
        if missed > 0:
            for _ in range(min(missed, MISSES_MAX)):
                loss_frac += GAIN * (1.0 - loss_frac)
        self.loss_frac = loss_frac - GAIN * loss_frac
        if self.heard:
            off_s = delay_s - self.delay_s
            self.deviation_s += GAIN * (abs(off_s) - self.deviation_s)
            self.delay_s += GAIN * off_s
        else:
            self.deviation_s -= GAIN * self.deviation_s
            self.delay_s = delay_s
        self.heard += 1

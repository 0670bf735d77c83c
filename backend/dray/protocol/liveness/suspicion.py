"""When silence becomes failure: pure arithmetic.

An agent says itself how often it speaks (by its status), so its silence can be judged by anybody
who hears it. The bound follows from how its heartbeats have arrived so far:

    bound_s = misses * interval_s + lateness_s

    misses       so many losses in a row that chance alone makes them once in 1 / FALSE_ALARM
                 heartbeats, at the loss that was seen: 3 up to 4.6 % loss, 6 at 20 %, 11 at 40 %
    lateness_s   four mean deviations of the delay, as in RFC 6298, and never below JITTER_S

On a good link a working vehicle is suspected after 3.5 s. No link is so bad that the bound exceeds
MISSES_MAX intervals and LATENESS_MAX_S: what is worse than that is no link.
"""

from __future__ import annotations

from math import ceil, log

from msgspec import UNSET

from dray.messages import AtvHeartbeat, MachineHeartbeat, StationHeartbeat

WORKING_INTERVAL_S = 1.0
"""A working agent beats at 1 Hz: a takeover is due within a few seconds of its death."""

IDLE_INTERVAL_S = 5.0
"""An idle one at 0.2 Hz: nobody waits for it, so it need not load the network (paper, 3.2)."""

FALSE_ALARM = 1e-4
"""One heartbeat in so many may be followed by a silence that looks like death: at 1 Hz, nearly three
hours of work between two takeovers for nothing."""

MISSES = 3
"""Allowed on a link that loses nothing, too: the first losses come unannounced."""

MISSES_MAX = 12

JITTER_S = 0.5
"""More than the latency of a loaded WLAN, less than half a working interval."""

LATENESS_MAX_S = 5.0
"""The worst link that is still a link (paper, case 3)."""

GAIN = 1.0 / 32.0
"""Weight of the newest heartbeat: half a minute of work is remembered, and one loss changes little."""

DEVIATIONS = 4.0
"""Mean deviations by which a message may be later than on average (RFC 6298)."""

BREAKDOWN_S = 600.0
"""How long a machine may be broken and keep its goals. A technician mends most breakdowns in less, and
what was made before is carried away meanwhile."""

GOAL_SILENCE_S = 15.0
"""How long a machine may not name a goal before it has lost it. A machine that holds goals beats at 1 Hz,
so fifteen heartbeats are missing in a row; and its software starts again in less."""

CLEAN_FRAC = 0.04
"""A link that loses no more needs no arithmetic: so many losses in a row as `MISSES` are rare enough."""

AnyHeartbeat = AtvHeartbeat | MachineHeartbeat | StationHeartbeat


def interval_s(heartbeat: AnyHeartbeat) -> float:
    """How long after this heartbeat the next one is due.

    Whoever holds a task or goals is relied on, also while all that is left of them is on the way; and who needs somebody
    is waited for by people, who want to see at once when it is over, or gets worse. Nobody is called to one out of service.
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
    """Whether it tells of a problem for which somebody is called."""
    return bool(heartbeat.problem) and heartbeat.out_of_service is UNSET


def allowed_misses(loss_frac: float) -> int:
    """How many heartbeats in a row may be lost without a suspicion, when this part of them is lost."""
    if loss_frac <= CLEAN_FRAC:
        return MISSES
    if loss_frac >= 1.0:
        return MISSES_MAX
    return min(max(ceil(log(FALSE_ALARM) / log(loss_frac)), MISSES), MISSES_MAX)


def bound_s(interval_s: float, loss_frac: float = 0.0, deviation_s: float = 0.0) -> float:
    """How long somebody who beats every `interval_s` may be silent without being suspected.

    Args:
        interval_s: between two heartbeats.
        loss_frac: the part of the heartbeats that is lost.
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
    """How long an agent may be silent after this heartbeat before it counts as failed.

    Args:
        heartbeat: its newest.
        arrivals: how its heartbeats have arrived so far at whoever judges.
    """
    if isinstance(heartbeat, MachineHeartbeat) and heartbeat.goals:
        return GOAL_SILENCE_S
    return bound_s(interval_s(heartbeat), arrivals.loss_frac, arrivals.deviation_s)


def gone_s(every_s: float) -> float:
    """How long somebody must be silent so that no link explains it, however bad.

    Args:
        every_s: how often that one speaks.
    """
    return MISSES_MAX * every_s + LATENESS_MAX_S


class ArrivalStatistics:
    """How heartbeats arrive: running estimates of their loss and their delay.

    Args:
        prior: what to begin with: how others' heartbeats arrive at the same agent.
    """

    __slots__ = ("deaf_s", "delay_s", "deviation_s", "heard", "loss_frac")

    def __init__(self, prior: ArrivalStatistics | None = None) -> None:
        self.heard: int = 0 if prior is None else prior.heard
        """Heartbeats so far."""
        self.loss_frac: float = 0.0 if prior is None else prior.loss_frac
        self.delay_s: float = 0.0 if prior is None else prior.delay_s
        """The mean delay."""
        self.deviation_s: float = 0.0 if prior is None else prior.deviation_s
        """The mean deviation from it."""
        self.deaf_s = 0.0
        """How long the agent that listens was held up itself, all told: silence in that time is its own."""

    def note(self, missed: int, delay_s: float) -> None:
        """Update the estimates by one heartbeat.

        Args:
            missed: how many before it have not.
            delay_s: how long it was under way, by the plant's clock.
        """
        # Beyond these bounds it is not the link: one of two clocks is wrong.
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

"""The agents' clock errors, as their heartbeats show them, and the correction of times by a wrong clock.

Every heartbeat contains its time of sending. Its delay is never negative, so

    behind_s   of one heartbeat: now - at_s, the clock's lag plus the delay of the link
    least_s    the least of the last HEARD_KEPT: the link at its best
    common_s   the median of that over all agents: the common part, as the link, and an error of our own clock
    ahead_s    common_s - least_s: how far the agent's clock is ahead, behind if negative
    bound_s    the uncertainty: the variation of the link, and its delay

A delayed heartbeat shows nothing wrong, only nothing. One agent, whatever it reports, changes no other agent's figure and hardly
the median. With fewer than three agents no common error can be seen, and only differences beyond any link's delay count.

Times by a wrong clock are corrected before they are stored or counted. A time that is still impossible (in the future, or
older than any history) counts as now.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from statistics import median

import msgspec
from msgspec import UnsetType

from dray.messages import AtvHeartbeat, Event, MachineHeartbeat, OutOfService, StationHeartbeat
from dray.messages.base import CLOCK_WRONG_S, CLOCKS_AGREE_S

HEARD_KEPT = 8
"""Heartbeats considered of each agent: as in the clock filter of NTP (RFC 5905, 10)."""

LATELY_S = 60.0
"""Plant seconds after its last heartbeat in which an agent's clock counts for the median."""

ALONE_S = 60.0
"""Errors beyond `CLOCKS_AGREE_S` are reported to people; with fewer than three agents, only errors beyond this."""

WALL_SLACK_S = 2.0
"""Wall seconds by which a simulated plant at speed may lag, or come in bursts."""

MAJORITY = 3

OLDEST_S = 400 * 86_400.0
"""The oldest plausible history: a year and more."""

AGENTS_KEPT = 20_000
"""Maximum agents with a watched clock: twice the vehicles that a gateway remembers."""

_TIMES = ("deadline_s", "bids_until_s", "finish_s", "next_round_s", "promised_s", "until_s")
"""Fields of facts with times of the sender's clock; 0 means none."""


ToWall = Callable[[float], float]
"""Plant clock to wall clock, both in seconds."""

Timed = AtvHeartbeat | MachineHeartbeat | StationHeartbeat | Event
"""Messages with times of their sender's clock."""


class Offset(msgspec.Struct, frozen=True):
    """A clock's error."""

    ahead_s: float
    """Seconds ahead; negative for behind."""
    bound_s: float
    """The uncertainty in seconds, either way."""


class _Heard:
    __slots__ = ("at_s", "behind_s")

    def __init__(self) -> None:
        self.behind_s: deque[float] = deque(maxlen=HEARD_KEPT)
        self.at_s = 0.0


class Clocks:
    """The clocks of all agents.

    Args:
        speed: plant seconds per wall second.
    """

    def __init__(self, speed: float = 1.0) -> None:
        self._heard: dict[str, _Heard] = {}
        self._slack_s = WALL_SLACK_S * max(0.0, speed - 1.0)
        self._ahead_s: dict[str, float] = {}
        """The errors of clocks so far from our own that no link's delay explains them."""
        self._common: tuple[float, float] | None = None
        """The common part, and the time of its computation."""

    def right(self, message: Timed, now_s: float) -> Timed:
        """A message with corrected times; heartbeats update the errors.

        Args:
            message: the received message.
            now_s: the time of reception (plant clock, by our own).
        """
        if isinstance(message, Event):
            ahead_s = self._shift_s(message.agent, message.at_s, now_s, oldest_s=OLDEST_S)
            return _event(message, ahead_s) if ahead_s else message
        agent = _speaker(message)
        self._note(agent, message.at_s, now_s)
        ahead_s = self._shift_s(agent, message.at_s, now_s, oldest_s=CLOCK_WRONG_S + self._slack_s)
        if not ahead_s:
            return message
        if isinstance(message, AtvHeartbeat):
            return _atv(message, ahead_s)
        if isinstance(message, MachineHeartbeat):
            return _machine(message, ahead_s)
        return msgspec.structs.replace(message, at_s=message.at_s - ahead_s)

    def offset(self, agent: str) -> Offset | None:
        """An agent's clock error; None when unknown."""
        heard = self._heard.get(agent)
        if heard is None or not heard.behind_s:
            return None
        least_s = min(heard.behind_s)
        common_s = self._common_s(heard.at_s)
        spread_s = median(heard.behind_s) - least_s
        return Offset(common_s - least_s, spread_s + max(0.0, min(common_s, CLOCKS_AGREE_S)) + self._slack_s)

    def ahead_s(self, agent: str) -> float:
        """Seconds that an agent's clock is ahead of our own, whichever is wrong; 0 where links and clocks of one plant explain them.

        Thread-safe.
        """
        return self._ahead_s.get(agent, 0.0)

    def wrong(self, now_s: float) -> Iterator[tuple[str, Offset]]:
        """The agents heard lately whose clocks are wrong beyond doubt."""
        for agent, heard in self._heard.items():
            if now_s - heard.at_s <= LATELY_S + self._slack_s and (offset := self.offset(agent)) is not None:
                if self.is_wrong(offset):
                    yield agent, offset

    def is_wrong(self, offset: Offset) -> bool:
        """Whether an error is larger than those of clocks of one plant, beyond doubt."""
        return abs(offset.ahead_s) - offset.bound_s > self._threshold_s()

    def offsets(self) -> dict[str, Offset]:
        """The errors of all agents."""
        known = ((agent, self.offset(agent)) for agent in self._heard)
        return {agent: offset for agent, offset in known if offset is not None}

    # --- how it is done --------------------------------------------------------------------------

    def _note(self, agent: str, at_s: float, now_s: float) -> None:
        heard = self._heard.get(agent)
        if heard is None:
            if len(self._heard) >= AGENTS_KEPT:
                return
            heard = self._heard[agent] = _Heard()
            self._common = None
        heard.behind_s.append(now_s - at_s)
        heard.at_s = now_s
        least_s = min(heard.behind_s)
        # No message arrives before it is sent; a delay of a minute may be the link.
        if -(CLOCKS_AGREE_S + self._slack_s) <= least_s <= ALONE_S + self._slack_s:
            self._ahead_s.pop(agent, None)
        else:
            self._ahead_s[agent] = -least_s

    def _threshold_s(self) -> float:
        return CLOCKS_AGREE_S if len(self._heard) >= MAJORITY else ALONE_S

    def _common_s(self, now_s: float) -> float:
        """The common part, computed once a second: it changes slowly, and every message needs it."""
        if self._common is None or not 0.0 <= now_s - self._common[1] < 1.0:
            least_s = [
                min(heard.behind_s)
                for heard in self._heard.values()
                if heard.behind_s and abs(now_s - heard.at_s) <= LATELY_S + self._slack_s
            ]
            self._common = (median(least_s) if len(least_s) >= MAJORITY else 0.0, now_s)
        return self._common[0]

    def _shift_s(self, agent: str, at_s: float, now_s: float, *, oldest_s: float) -> float:
        """The correction to subtract from an agent's times."""
        offset, shift_s = self.offset(agent), 0.0
        if offset is not None and self.is_wrong(offset):
            shift_s = offset.ahead_s
        by_now_s = at_s - shift_s - now_s
        common_s = max(0.0, -self._common_s(now_s))
        if by_now_s > CLOCK_WRONG_S + self._slack_s + common_s or by_now_s < -oldest_s:
            shift_s = at_s - now_s
        return shift_s


def _speaker(heartbeat: AtvHeartbeat | MachineHeartbeat | StationHeartbeat) -> str:
    match heartbeat:
        case AtvHeartbeat():
            return heartbeat.atv
        case MachineHeartbeat():
            return heartbeat.machine
        case StationHeartbeat():
            return heartbeat.station


def _later(time_s: float | None, ahead_s: float) -> float | None:
    return None if time_s is None else time_s - ahead_s


def _event(event: Event, ahead_s: float) -> Event:
    fact = event.fact
    told = {name: value - ahead_s for name in _TIMES if (value := getattr(fact, name, 0.0))}
    if told:
        fact = msgspec.structs.replace(fact, **told)
    return msgspec.structs.replace(event, at_s=event.at_s - ahead_s, fact=fact)


def _atv(heartbeat: AtvHeartbeat, ahead_s: float) -> AtvHeartbeat:
    task, wanted, lost = heartbeat.task, heartbeat.help, heartbeat.lost_wlan
    wait = heartbeat.body_wait
    return msgspec.structs.replace(
        heartbeat,
        at_s=heartbeat.at_s - ahead_s,
        task=None if task is None else msgspec.structs.replace(task, due_s=_later(task.due_s, ahead_s)),
        help=None if wanted is None else msgspec.structs.replace(wanted, until_s=wanted.until_s - ahead_s),
        out_of_service=_out(heartbeat.out_of_service, ahead_s),
        body_wait=wait
        if isinstance(wait, UnsetType)
        else msgspec.structs.replace(wait, since_s=wait.since_s - ahead_s),
        lost_wlan=lost
        if isinstance(lost, UnsetType)
        else msgspec.structs.replace(lost, since_s=lost.since_s - ahead_s),
    )


def _machine(heartbeat: MachineHeartbeat, ahead_s: float) -> MachineHeartbeat:
    tasks = tuple(
        msgspec.structs.replace(task, deadline_s=task.deadline_s - ahead_s) for task in heartbeat.tasks
    )
    wanted = heartbeat.help
    return msgspec.structs.replace(
        heartbeat,
        at_s=heartbeat.at_s - ahead_s,
        tasks=tasks,
        help=wanted
        if isinstance(wanted, UnsetType)
        else msgspec.structs.replace(wanted, until_s=wanted.until_s - ahead_s),
        out_of_service=_out(heartbeat.out_of_service, ahead_s),
    )


def _out(out: OutOfService | UnsetType, ahead_s: float) -> OutOfService | UnsetType:
    if isinstance(out, UnsetType):
        return out
    return msgspec.structs.replace(out, since_s=out.since_s - ahead_s, back_s=_later(out.back_s, ahead_s))

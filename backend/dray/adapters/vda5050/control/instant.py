"""Instant actions: said until the vehicle's state shows them, and not for ever."""

from __future__ import annotations

from dataclasses import dataclass

from dray.adapters.vda5050.control.refusals import plain
from dray.adapters.vda5050.events import Effect, Note, Say
from dray.adapters.vda5050.profile import Profile
from dray.adapters.vda5050.wire.messages import OVER, State
from dray.adapters.vda5050.wire.orders import Action, instant_body

ASK_STATE = "stateRequest"
"""Let the vehicle say how it is."""

SAID_MAX = 5
"""Times one action is said: a vehicle that has not shown it by then never will."""

OPEN_MAX = 20
"""Kinds of instant actions that are looked after; there are eight."""

LATE_S = 60.0
"""One that is shown and has not ended by then is not waited for any longer."""

CLEAR, CLEAR_ZONES = "clearInstantActions", "clearZoneActions"
"""Of 3.0: the vehicle keeps the states of instant actions, and of actions of zones, until it is told to clear them."""

CLEARED_AT, CLEARED_EVERY_S = 50, 60.0
"""Ended instant actions that a vehicle may show before it is told to clear them, and how often that is said at most."""

FULL = {"instantactionstatesfull": CLEAR, "zoneactionstatesfull": CLEAR_ZONES}
"""What a vehicle complains of (3.0, 7.8), without capitals and underscores, and what helps."""


@dataclass
class _Open:
    action: Action
    said_s: float
    first_s: float
    is_late: bool = False
    times: int = 1
    status: str = ""
    """As the vehicle shows it; empty as long as it does not."""


class InstantActions:
    """Those of one life.

    Args:
        agent: its id.
        life: of the agent; ids must not come again in another.
        profile: of the vehicle.
        out: where effects go.
    """

    def __init__(self, agent: str, life: int, profile: Profile, out: list[Effect]) -> None:
        self._agent, self._life, self._profile, self._out = agent, life, profile, out
        self._number = 0
        self._cleared_s = float("-inf")
        self._open: dict[str, _Open] = {}
        """By kind: of each the newest one counts."""

    def say(self, kind: str, now_s: float) -> None:
        """Say it, and go on until it is shown. What was open of this kind is forgotten."""
        self._number += 1
        action = Action(f"{self._agent}-{self._life}-i{self._number}", kind, "NONE")
        if kind in self._open or len(self._open) < OPEN_MAX:
            self._open[kind] = _Open(action, now_s, now_s)
        self._write(action)

    def status(self, kind: str) -> str:
        """What the vehicle shows of the newest one of a kind; empty for nothing."""
        return self._open[kind].status if kind in self._open else ""

    def is_open(self, kind: str) -> bool:
        """Whether one of this kind is looked after."""
        return kind in self._open

    def is_given_up(self, kind: str) -> bool:
        """Whether it was said as often as it is said at most and never shown, or was shown and does not end."""
        one = self._open.get(kind)
        return one is not None and (one.is_late or (not one.status and one.times >= SAID_MAX))

    def forget(self, kind: str) -> None:
        """Say it no more."""
        self._open.pop(kind, None)

    def on_state(self, state: State) -> None:
        """See what the vehicle shows of them."""
        for one in self._open.values():
            shown = state.action(one.action.id)
            if shown is not None and shown.action_status:
                one.status = shown.action_status

    def clear(self, state: State, now_s: float) -> None:
        """Let a vehicle of 3.0 clear its lists of ended actions, when they are long or it says that they are full."""
        if self._profile.version != "3.0" or now_s - self._cleared_s < CLEARED_EVERY_S:
            return
        full = {FULL.get(plain(error.error_type), "") for error in state.errors or ()} - {""}
        ended = sum(one.action_status in OVER for one in state.instant_action_states or ())
        for kind in sorted(full | ({CLEAR} if ended >= CLEARED_AT else set())):
            self._cleared_s = now_s
            self.say(kind, now_s)

    def tick(self, now_s: float) -> None:
        """Say again what is not shown; give up what is shown and does not end."""
        for one in self._open.values():
            if one.status and one.status not in OVER and not one.is_late and now_s - one.first_s >= LATE_S:
                one.is_late = True
                text = f"{one.action.type} stays {one.status}, and is not waited for any longer"
                self._out.append(Note(text))
            if not one.status and one.times < SAID_MAX and now_s - one.said_s >= self._profile.resend_s:
                one.said_s, one.times = now_s, one.times + 1
                self._write(one.action)

    def _write(self, action: Action) -> None:
        body = instant_body(action, self._profile.dialect, self._profile.instant_actions)
        self._out.append(Say("instantActions", body))

"""Instant actions: sent until the vehicle's state shows them, with a limit."""

from __future__ import annotations

from dataclasses import dataclass

from dray.adapters.vda5050.control.refusals import plain
from dray.adapters.vda5050.events import Effect, Note, Say
from dray.adapters.vda5050.profile import Profile
from dray.adapters.vda5050.wire.messages import OVER, State
from dray.adapters.vda5050.wire.orders import Action, instant_body

ASK_STATE = "stateRequest"
"""Request the vehicle's state."""

SAID_MAX = 5
"""Maximum sendings of one action: a vehicle that has not shown it by then never will."""

OPEN_MAX = 20
"""Maximum kinds of open instant actions; there are eight."""

LATE_S = 60.0
"""Timeout of an action that is shown and does not end."""

CLEAR, CLEAR_ZONES = "clearInstantActions", "clearZoneActions"
"""In 3.0 the vehicle keeps the states of instant actions, and of actions of zones, until it is told to clear them."""

CLEARED_AT, CLEARED_EVERY_S = 50, 60.0
"""Ended instant actions above which a vehicle is told to clear them, and the least seconds between two such requests."""

FULL = {"instantactionstatesfull": CLEAR, "zoneactionstatesfull": CLEAR_ZONES}
"""A vehicle's complaints (3.0, 7.8), without capitals and underscores, and the remedy."""


@dataclass
class _Open:
    action: Action
    said_s: float
    first_s: float
    is_late: bool = False
    times: int = 1
    status: str = ""
    """The status in the vehicle's state; empty before that."""


class InstantActions:
    """The instant actions of one life.

    Args:
        agent: its id.
        life: the agent's life; ids must be unique over lives.
        profile: the vehicle's profile.
        out: receives the effects.
    """

    def __init__(self, agent: str, life: int, profile: Profile, out: list[Effect]) -> None:
        self._agent, self._life, self._profile, self._out = agent, life, profile, out
        self._number = 0
        self._cleared_s = float("-inf")
        self._open: dict[str, _Open] = {}
        """By kind, the newest action."""

    def say(self, kind: str, now_s: float) -> None:
        """Send an action, and repeat it until the vehicle shows it. An earlier one of this kind is forgotten."""
        self._number += 1
        action = Action(f"{self._agent}-{self._life}-i{self._number}", kind, "NONE")
        if kind in self._open or len(self._open) < OPEN_MAX:
            self._open[kind] = _Open(action, now_s, now_s)
        self._write(action)

    def status(self, kind: str) -> str:
        """The vehicle's status of the newest action of a kind; empty for none."""
        return self._open[kind].status if kind in self._open else ""

    def is_open(self, kind: str) -> bool:
        """Whether an action of this kind is open."""
        return kind in self._open

    def is_given_up(self, kind: str) -> bool:
        """Whether it was sent the maximum number of times and never shown, or was shown and does not end."""
        one = self._open.get(kind)
        return one is not None and (one.is_late or (not one.status and one.times >= SAID_MAX))

    def forget(self, kind: str) -> None:
        """Stop sending it."""
        self._open.pop(kind, None)

    def on_state(self, state: State) -> None:
        """Update the actions from the vehicle's state."""
        for one in self._open.values():
            shown = state.action(one.action.id)
            if shown is not None and shown.action_status:
                one.status = shown.action_status

    def clear(self, state: State, now_s: float) -> None:
        """Let a vehicle of 3.0 clear its lists of ended actions, when they are long or it reports that they are full."""
        if self._profile.version != "3.0" or now_s - self._cleared_s < CLEARED_EVERY_S:
            return
        full = {FULL.get(plain(error.error_type), "") for error in state.errors or ()} - {""}
        ended = sum(one.action_status in OVER for one in state.instant_action_states or ())
        for kind in sorted(full | ({CLEAR} if ended >= CLEARED_AT else set())):
            self._cleared_s = now_s
            self.say(kind, now_s)

    def tick(self, now_s: float) -> None:
        """Repeat actions that are not shown; give up shown ones that do not end."""
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

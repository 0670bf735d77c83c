"""How a vehicle that was busy asks for waiting work, instead of hearing repeated announcements.

A refused announcement to the whole plant shows that work waits. From then on the vehicle asks once whenever it is
free (`WorkSought`). Every coordinator with waiting transports answers that vehicle alone, with the most urgent one
that it can carry. The vehicle collects offers for COLLECT_S, then bids for the most urgent, and for the next one if
that is lost. Without an answer no work waits any more.

    nothing known --refused for lack of time--> known --free--> COLLECTING --> BIDDING --contract--> known
          ^                                                          |
          +----------------- nobody answers ASKS times --------------+

This is an optimisation: waiting tasks are announced too, ever more rarely. A lost message costs time.
"""

from __future__ import annotations

from dray.messages import Refusal, Role, TaskAnnounced, WorkSought
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.runtime.events import Publish
from dray.protocol.runtime.life import Life
from dray.protocol.runtime.retransmission import Retransmitter

SEEK = "seek"
"""Alarm of the next step: the choice, or the next bid."""

ASK_FOR_WORK = "ask for work"
"""Alarm of the next question while there is no answer."""

COLLECT_S = 0.5
"""Time to collect offers (s): a few times the latency of a good WLAN. A later offer is answered when it comes."""

ANSWER_S = 1.5
"""Answer timeout of a bid (s): its auction was resting, so the award follows at once."""

ASKS = 3
ASK_AGAIN_S = 5.0
"""Maximum questions without an answer, and their interval (s): one may be lost, and after the last no work waits."""

OFFERS_KEPT = 64
"""Maximum coordinators whose offers are kept; the least urgent are dropped."""

PASSING = frozenset({Refusal.BUSY, Refusal.BATTERY, Refusal.NOT_FIT})
"""Refusals that end when the vehicle is free, charged and well. A deadline moves with the next announcement."""

CHARGED_FRAC = 0.05
"""Charge after which a transport that was refused for the battery may be possible."""

PAUSE_S = 20.0
"""Pause after a search without a contract (s)."""

ROUNDING_M = 1e-6


class WorkSearch:
    """One vehicle's knowledge of waiting work.

    Args:
        atv: the vehicle's id.
        plant: the plant, for its size.
        vehicle_type: id of the vehicle's type.
        keys: the plant's bus keys.
        life: the agent's life; alarms are named `SEEK` and ``(ASK_FOR_WORK, atv)``.
    """

    def __init__(self, atv: str, plant: Plant, vehicle_type: str, keys: Keys, life: Life) -> None:
        self._atv = atv
        sought = WorkSought(atv=atv, abilities=plant.vehicle_types[vehicle_type].abilities)
        self._sought = Publish(keys.free(atv), sought)
        self._reach_m = plant.diameter_m
        self._life = life
        self._question = Retransmitter(ASK_FOR_WORK, life, every_s=COLLECT_S + ASK_AGAIN_S, most=ASKS)
        self.is_known = False
        """Whether work waits, as far as the vehicle knows."""
        self._seeks = False
        """Whether it has asked, and chooses from offers."""
        self._offers: dict[str, TaskAnnounced] = {}
        """The present offers, the newest of each task."""
        self._open = False
        """Whether offers are being collected."""
        self._answered = False
        """Whether there was an offer since it began to ask."""
        self._enough_frac = 0.0
        """Charge below which the last transport was refused."""
        self._not_before_s = 0.0

    def note_refused(self, message: TaskAnnounced, reason: Refusal, battery_frac: float) -> None:
        """An announcement was refused: work waits, if all vehicles have heard it."""
        everybody = message.radius_m >= self._reach_m - ROUNDING_M
        if everybody and message.role is Role.PRIMARY and reason in PASSING:
            self.is_known = True
            if reason is Refusal.BATTERY:
                self._enough_frac = battery_frac + CHARGED_FRAC

    def ask_for_work(self, battery_frac: float, now_s: float) -> None:
        """The vehicle is free: ask for waiting work that it may be able to carry."""
        if not self.is_known or self._seeks or now_s < self._not_before_s:
            return
        if battery_frac >= self._enough_frac:
            self._enough_frac = 0.0
            self._seeks = True
            self._question.say(self._atv, self._sought, now_s)
            self._collect(now_s)

    def ask_again(self, now_s: float) -> None:
        """Repeat the unanswered question."""
        self._question.wake(self._atv, now_s)
        self._collect(now_s)

    def stop(self) -> None:
        """Stop: the vehicle has work, or can take none."""
        self._life.cancel(SEEK)
        self._question.settle(self._atv)
        self._offers.clear()
        self._open = self._answered = self._seeks = False
        self._not_before_s = 0.0

    def take(self, message: TaskAnnounced, now_s: float) -> bool:
        """Keep an announcement for the choice; False if it is to be answered now."""
        if not self._seeks or message.role is not Role.PRIMARY:
            return False
        self._question.settle(self._atv)
        if not self._offers and not self._open:
            # The offer comes late, on a slow link: collect others that come with it.
            self._collect(now_s)
        self._offers[message.task] = message
        if len(self._offers) > OFFERS_KEPT:
            del self._offers[max(self._offers, key=self._urgency)]
        return True

    def choose(self, now_s: float) -> TaskAnnounced | None:
        """Choose the next offer, after the alarm or a refused one.

        Returns:
            The offer to bid for now; None if there is none.
        """
        self._open = False
        if self._offers:
            self._answered = True
            self._life.alarm(SEEK, now_s + ANSWER_S)
            return self._offers.pop(min(self._offers, key=self._urgency))
        if self._answered:
            self.stop()  # All waiting work went to others, or is unsuitable.
            self._not_before_s = now_s + PAUSE_S
        elif self._question.is_exhausted(self._atv):
            self.is_known = False
            self.stop()
        return None

    def _collect(self, now_s: float) -> None:
        """Collect offers for COLLECT_S, and choose then."""
        self._open = True
        self._life.alarm(SEEK, now_s + COLLECT_S)

    def _urgency(self, task: str) -> tuple[float, str]:
        message = self._offers[task]
        return message.needed_s or message.deadline_s, task

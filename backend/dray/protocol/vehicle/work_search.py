"""How a vehicle that had no time asks for work that waits, instead of hearing it announced again and again.

An announcement that reaches the whole plant and is refused because there is no time shows that work waits. From then on, whenever
the vehicle is free, it says so once (`WorkSought`). Every coordinator whose transports wait answers with the most urgent one that
the vehicle can carry, to it alone. For COLLECT_S it hears what there is, then it bids for the most urgent, and for the
next one when that was given to somebody else. When nobody answers, nothing waits any more.

    nothing known --refused for lack of time--> known --free--> COLLECTING --> BIDDING --contract--> known
          ^                                                          |
          +----------------- nobody answers ASKS times --------------+

Nothing hangs on it: what waits is announced too, ever more rarely. A word that is lost costs time.
"""

from __future__ import annotations

from dray.messages import Refusal, Role, TaskAnnounced, WorkSought
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.runtime.events import Publish
from dray.protocol.runtime.life import Life
from dray.protocol.runtime.retransmission import Retransmitter

SEEK = "seek"
"""The alarm for the next step: choosing, or the next bid."""

ASK_FOR_WORK = "ask for work"
"""The alarm for asking again, as long as nobody has answered."""

COLLECT_S = 0.5
"""A few times the latency of a good WLAN. An offer that comes later is answered when it comes."""

ANSWER_S = 1.5
"""How long a bid may stay unanswered: its auction was resting, so the award follows at once."""

ASKS = 3
ASK_AGAIN_S = 5.0
"""Questions without an answer, and the time between two: one may be lost, and after the last one nothing waits."""

OFFERS_KEPT = 64
"""Coordinators whose offers are kept; the least urgent beyond that are dropped."""

PASSING = frozenset({Refusal.BUSY, Refusal.BATTERY, Refusal.NOT_FIT})
"""Refusals that do not hold any more when the vehicle is free, charged and well. A deadline moves with the next announcement."""

CHARGED_FRAC = 0.05
"""Charge after which a transport that was refused for the battery may be possible."""

PAUSE_S = 20.0
"""When nothing that was offered came to a contract."""

ROUNDING_M = 1e-6


class WorkSearch:
    """What one vehicle knows of work that waits.

    Args:
        atv: the vehicle.
        plant: how far everybody is.
        vehicle_type: id of the vehicle's type.
        keys: the plant's bus keys.
        life: its agent's; its alarms are named `SEEK` and ``(ASK_FOR_WORK, atv)``.
    """

    def __init__(self, atv: str, plant: Plant, vehicle_type: str, keys: Keys, life: Life) -> None:
        self._atv = atv
        sought = WorkSought(atv=atv, abilities=plant.vehicle_types[vehicle_type].abilities)
        self._sought = Publish(keys.free(atv), sought)
        self._reach_m = plant.diameter_m
        self._life = life
        self._question = Retransmitter(ASK_FOR_WORK, life, every_s=COLLECT_S + ASK_AGAIN_S, most=ASKS)
        self.is_known = False
        """Work waits, as far as the vehicle knows."""
        self._seeks = False
        """It has asked, and chooses from what is offered."""
        self._offers: dict[str, TaskAnnounced] = {}
        """What is offered now, the newest of each task."""
        self._open = False
        """Offers are collected."""
        self._answered = False
        """Something was offered since it began to ask."""
        self._enough_frac = 0.0
        """Below this the battery was not enough the last time."""
        self._not_before_s = 0.0

    def note_refused(self, message: TaskAnnounced, reason: Refusal, battery_frac: float) -> None:
        """An announcement was refused: somebody waits, if all vehicles have heard it."""
        everybody = message.radius_m >= self._reach_m - ROUNDING_M
        if everybody and message.role is Role.PRIMARY and reason in PASSING:
            self.is_known = True
            if reason is Refusal.BATTERY:
                self._enough_frac = battery_frac + CHARGED_FRAC

    def ask_for_work(self, battery_frac: float, now_s: float) -> None:
        """The vehicle is free: ask for what waits, if anything may and this vehicle may be able to carry it."""
        if not self.is_known or self._seeks or now_s < self._not_before_s:
            return
        if battery_frac >= self._enough_frac:
            self._enough_frac = 0.0
            self._seeks = True
            self._question.say(self._atv, self._sought, now_s)
            self._collect(now_s)

    def ask_again(self, now_s: float) -> None:
        """Nobody has answered the last question."""
        self._question.wake(self._atv, now_s)
        self._collect(now_s)

    def stop(self) -> None:
        """The vehicle has work, or can take none."""
        self._life.cancel(SEEK)
        self._question.settle(self._atv)
        self._offers.clear()
        self._open = self._answered = self._seeks = False
        self._not_before_s = 0.0

    def take(self, message: TaskAnnounced, now_s: float) -> bool:
        """Keep an announcement for the choice; False when nothing is being chosen, and it is to be answered now."""
        if not self._seeks or message.role is not Role.PRIMARY:
            return False
        self._question.settle(self._atv)
        if not self._offers and not self._open:
            # It comes late, on a slow link: choose from what comes with it.
            self._collect(now_s)
        self._offers[message.task] = message
        if len(self._offers) > OFFERS_KEPT:
            del self._offers[max(self._offers, key=self._urgency)]
        return True

    def choose(self, now_s: float) -> TaskAnnounced | None:
        """The alarm has come, or what was chosen last is not for this vehicle.

        Returns:
            What to bid for now; None when nothing is offered.
        """
        self._open = False
        if self._offers:
            self._answered = True
            self._life.alarm(SEEK, now_s + ANSWER_S)
            return self._offers.pop(min(self._offers, key=self._urgency))
        if self._answered:
            self.stop()  # All that waits was given to others, or is not for this vehicle.
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

"""The contractor's side of the Contract Net: evaluate, price, bid, or refuse (paper, 4.1)."""

from __future__ import annotations

import msgspec

from dray.messages import Award, DockTime, Refusal, Role, TaskAnnounced, Transport, Work
from dray.plant import Plant
from dray.protocol.contract_net.dock_queues import DOCKS_MAX, wait_s
from dray.protocol.contract_net.replies import Refusals, offer
from dray.protocol.contract_net.trust.probation import ON_PROBATION, SHORT_S, Probation
from dray.protocol.contract_net.waits import Waits
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.life import Life
from dray.protocol.vehicle.charging import Charging
from dray.protocol.vehicle.pricing import Pricer, Quote, Unable

MAX_WATCHES = 3
"""Maximum tasks that one vehicle watches: it can take over only one of them."""

PLACES_TOLD = 32
"""Maximum places whose waiting time one announcement tells: its sources, and its destination."""


RESERVE_AFTER_S = 300.0
"""Time after which a vehicle of the reserve may carry an overdue task (s): the vehicles at work may be broken, or unable to
carry it."""


class Standing(msgspec.Struct, frozen=True):
    """A vehicle's state at an announcement or an award."""

    node: str
    """Its present node, or the next one."""
    node_at_s: float
    """When it is there (plant clock)."""
    x_m: float
    y_m: float
    speed_frac: float
    """The limit set by a person, as a fraction of its top speed."""
    battery_frac: float
    unfit: str
    """Why it may not work at all: stopped, in error, on the mesh; empty if it may."""
    busy_with: str
    """The task that it is primary of; empty for none."""
    watches: int
    battery_reckoned: bool = False
    """`battery_frac` is not measured."""
    node_in_m: float = 0.0
    """The way that it still has to drive to `node`."""
    is_reserve: bool = False
    """Whether it belongs to the reserve of a fleet that is too large for the roads (`dray.plant.spare_places`)."""


class Bidder:
    """Decides for one vehicle whether to bid, and at which price.

    Args:
        atv: the vehicle's id.
        plant: its ways.
        vehicle_type: id of the vehicle's type.
        probation: the vehicle's probation.
        charging: the vehicle's charging: whether its battery permits work.
        waits: learned waits at places; announcements add to them.
    """

    def __init__(
        self,
        atv: str,
        plant: Plant,
        vehicle_type: str,
        probation: Probation,
        charging: Charging,
        waits: Waits,
        life: Life,
    ) -> None:
        self._atv = atv
        self._plant = plant
        self._pricer = Pricer(plant, vehicle_type)
        self._probation = probation
        self._waits = waits
        self._expected: BoundedMap[str, tuple[DockTime, ...]] = BoundedMap(DOCKS_MAX)
        """By place: the expected vehicles by the last announcement."""
        self._charging = charging
        self._refusals = Refusals(life)
        self._life = life

    def on_announced(self, message: TaskAnnounced, standing: Standing, now_s: float) -> Refusal | None:
        """Answer an announcement with a bid, or note the refusal with its reason.

        Returns:
            The reason of a refusal; None for a bid, and for an announcement to others.
        """
        dx_m, dy_m = message.x_m - standing.x_m, message.y_m - standing.y_m
        if dx_m * dx_m + dy_m * dy_m > message.radius_m * message.radius_m:
            return None  # It is outside the radius: its cell only touches the circle.
        if isinstance(message.work, Transport) and message.work.vehicle not in ("", self._atv):
            return None  # Only another vehicle may carry it.
        if self._is_left_to_others(message, standing, now_s):
            self._refusals.note(
                message, Refusal.NOT_FIT, "in the reserve: the floor has no room for more at work"
            )
            return Refusal.NOT_FIT
        for told in message.waits[:PLACES_TOLD]:
            if told.wait_s or not told.expected:
                self._waits.note(told.place, message.coordinator, told.wait_s, now_s)
            if told.expected:
                self._expected[told.place] = told.expected
        answer = self._consider(
            message.work, message.role, message.primary, message.deadline_s, standing, now_s
        )
        if isinstance(answer, Quote):
            takes_s = answer.finish_s - now_s
            if self._probation.bars(short=takes_s <= SHORT_S, round_number=message.round):
                answer = Unable(Refusal.NOT_FIT, f"{ON_PROBATION}: it would take {takes_s:.0f} s")
            else:
                self._refusals.forget(message)
        if isinstance(answer, Unable):
            self._refusals.note(message, answer.reason, answer.detail)
            return answer.reason
        reckoned = standing.battery_reckoned
        self._life.do(
            *offer(message, answer.cost, answer.finish_s, now_s, answer.source, battery_reckoned=reckoned)
        )
        return None

    def _is_left_to_others(self, message: TaskAnnounced, standing: Standing, now_s: float) -> bool:
        """Whether this vehicle waits in the reserve, enough others can carry the load, and the task is not long overdue."""
        work = message.work
        if not standing.is_reserve or message.role is not Role.PRIMARY or not isinstance(work, Transport):
            return False
        if work.vehicle or not self._has_able_at_work(work):
            return False
        return now_s < (message.needed_s or message.deadline_s) + RESERVE_AFTER_S

    def _has_able_at_work(self, work: Transport) -> bool:
        """Whether a third of the able vehicles are at work even if able ones take all reserve places."""
        plant = self._plant
        able = sum(
            set(work.needed) <= set(plant.vehicle_types[spec.type].abilities) for spec in plant.fleet.values()
        )
        return plant.spare_places.holds_back_from(able)

    def review(self, award: Award, standing: Standing, now_s: float) -> Quote | Unable:
        """Whether an award can still be accepted from the vehicle's present position."""
        work = award.work
        if isinstance(work, Transport) and award.source:
            work = msgspec.structs.replace(work, sources=(award.source,))
        return self._consider(work, award.role, award.primary, award.deadline_s, standing, now_s)

    def quote(self, work: Work, standing: Standing, now_s: float) -> Quote | Unable:
        """The price of carrying this from here without a deadline, for a takeover."""
        return self._consider(work, Role.PRIMARY, "", float("inf"), standing, now_s)

    def _consider(
        self,
        work: Work,
        role: Role,
        primary: str,
        deadline_s: float,
        standing: Standing,
        now_s: float,
    ) -> Quote | Unable:
        if standing.unfit:
            return Unable(Refusal.NOT_FIT, standing.unfit)
        if standing.busy_with:
            return Unable(Refusal.BUSY, standing.busy_with)
        self._charging.note(standing.battery_frac, standing.node)
        if must_charge := self._charging.why_no_work(standing.battery_frac):
            return Unable(Refusal.BATTERY, must_charge)
        if not isinstance(work, Transport):
            return Unable(Refusal.ABILITY, "not a transport")
        if role is Role.SECONDARY:
            if primary in ("", self._atv):
                return Unable(Refusal.IS_PRIMARY, "")
            if self._probation.lasts:
                # A watch is a promise to carry another vehicle's task, short or long.
                return Unable(Refusal.NOT_FIT, "on probation, and watches nobody")
            if standing.watches >= MAX_WATCHES:
                return Unable(Refusal.WATCHING_ENOUGH, f"{standing.watches} tasks")
            # A watch matters only if its primary fails, and late is better than never then.
            deadline_s = float("inf")
        quote = self._pricer.quote(
            work,
            node=standing.node,
            node_at_s=standing.node_at_s,
            node_in_m=standing.node_in_m,
            battery_frac=standing.battery_frac,
            now_s=now_s,
            deadline_s=deadline_s,
            speed_frac=standing.speed_frac,
            wait_s=lambda place, comes_s: (
                self._waits.expect_s(place, now_s)
                + wait_s(self._expected.get(place) or (), comes_s, self._atv)
            ),
        )
        if isinstance(quote, Unable) and quote.reason is Refusal.BATTERY:
            self._charging.note_short()
        return quote

"""The contractor's side of the Contract Net: hear, price, bid, or say why not (paper, 4.1)."""

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
"""Tasks that one vehicle watches at most: it can take over only one of them."""

PLACES_TOLD = 32
"""Places whose waiting time one announcement tells: its sources, and its destination."""


RESERVE_AFTER_S = 300.0
"""A task that has waited for so long beyond the time when it was needed is carried by a vehicle of the reserve, too: those at work may be
broken, or unable to carry it."""


class Standing(msgspec.Struct, frozen=True):
    """A vehicle's circumstances at the moment of an announcement or an award."""

    node: str
    """Where it is, or will be next."""
    node_at_s: float
    x_m: float
    y_m: float
    speed_frac: float
    """The limit that a person has set, as a part of its own top speed."""
    battery_frac: float
    unfit: str
    """Why it may not work at all: stopped, in error, on the mesh; empty when it may."""
    busy_with: str
    """The task it is primary of; empty for none."""
    watches: int
    battery_reckoned: bool = False
    """`battery_frac` is not measured."""
    silent_one: str = ""
    """A silent vehicle that it has waited for in vain; empty for none."""
    is_reserve: bool = False
    """It belongs to the reserve of a fleet that is too large for the roads (`dray.plant.spare_places`)."""


class Bidder:
    """Decides for one vehicle whether to bid, and at what price.

    Args:
        atv: the vehicle.
        plant: where the ways are.
        vehicle_type: id of the vehicle's type.
        probation: of the vehicle.
        charging: of the vehicle: whether its battery lets it work.
        waits: what the vehicle has learned of places; announcements tell of them, too.
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
        """Place -> who is expected there, as announcements have told last."""
        self._charging = charging
        self._refusals = Refusals(life)
        self._life = life

    def on_announced(self, message: TaskAnnounced, standing: Standing, now_s: float) -> Refusal | None:
        """Answer an announcement with a bid, or note the refusal and its reason.

        Returns:
            The reason of a refusal; None for a bid, and for an announcement that is for others.
        """
        dx_m, dy_m = message.x_m - standing.x_m, message.y_m - standing.y_m
        if dx_m * dx_m + dy_m * dy_m > message.radius_m * message.radius_m:
            return None  # A neighbour of those who were asked: its cell only touches the circle.
        if isinstance(message.work, Transport) and message.work.vehicle not in ("", self._atv):
            return None  # Only another one may carry it.
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
        """Whether this vehicle waits in the reserve, enough others can carry the load, and it has not waited for long."""
        work = message.work
        if not standing.is_reserve or message.role is not Role.PRIMARY or not isinstance(work, Transport):
            return False
        if work.vehicle or not self._has_able_at_work(work):
            return False
        return now_s < (message.needed_s or message.deadline_s) + RESERVE_AFTER_S

    def _has_able_at_work(self, work: Transport) -> bool:
        """Whether a third of the vehicles that can carry a load are at work, even if all places of the reserve are taken by such ones."""
        plant = self._plant
        able = sum(
            set(work.needed) <= set(plant.vehicle_types[spec.type].abilities) for spec in plant.fleet.values()
        )
        return plant.spare_places.holds_back_from(able)

    def review(self, award: Award, standing: Standing, now_s: float) -> Quote | Unable:
        """Whether an award can still be taken, from where the vehicle is now."""
        work = award.work
        if isinstance(work, Transport) and award.source:
            work = msgspec.structs.replace(work, sources=(award.source,))
        return self._consider(work, award.role, award.primary, award.deadline_s, standing, now_s)

    def quote(self, work: Work, standing: Standing, now_s: float) -> Quote | Unable:
        """What it would take to carry this from here, however late: for a task that is taken over."""
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
                # A watch is a promise to carry what somebody else has taken, short or long.
                return Unable(Refusal.NOT_FIT, "on probation, and watches nobody")
            if standing.watches >= MAX_WATCHES:
                return Unable(Refusal.WATCHING_ENOUGH, f"{standing.watches} tasks")
            # A watch is taken over only when its primary fails, and late is better than never then.
            deadline_s = float("inf")
        quote = self._pricer.quote(
            work,
            node=standing.node,
            node_at_s=standing.node_at_s,
            battery_frac=standing.battery_frac,
            now_s=now_s,
            deadline_s=deadline_s,
            speed_frac=standing.speed_frac,
            silent_one=standing.silent_one,
            wait_s=lambda place, comes_s: (
                self._waits.expect_s(place, now_s)
                + wait_s(self._expected.get(place) or (), comes_s, self._atv)
            ),
        )
        if isinstance(quote, Unable) and quote.reason is Refusal.BATTERY:
            self._charging.note_short()
        return quote

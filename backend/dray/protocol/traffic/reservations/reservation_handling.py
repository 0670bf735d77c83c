"""Right of way at a machine or a storage's station: messages, alarms and stored notes of the tables that it keeps.

An agent without tables whose dock makes itself safe also listens to removals: a vehicle that died there would keep the dock
for ever.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from msgspec import UNSET, UnsetType

from dray.memory import Memory, TableMemory
from dray.messages import (
    AtvHeartbeat,
    Message,
    PlaceRequested,
    Removal,
    Removals,
    TableAcknowledged,
    TableAsked,
    TableReplicated,
    TableReported,
)
from dray.messages.floor.traffic import line_beyond
from dray.messages.heartbeat import AWAITED_MAX
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.liveness.failure_detector import EVERYBODY, HeartbeatSubscriptions
from dray.protocol.liveness.suspicion import WORKING_INTERVAL_S, gone_s
from dray.protocol.runtime.events import NEVER_S, Commit
from dray.protocol.runtime.life import Change, Life
from dray.protocol.runtime.trust import Trusts
from dray.protocol.traffic.neighbours import Neighbours
from dray.protocol.traffic.removal_authorisation import (
    HEARD_SINCE,
    IS_HEARD,
    NO_PLACE,
    NOT_THERE,
    NOT_TRUSTED,
    TOO_EARLY,
    RemovalAuthorisation,
)
from dray.protocol.traffic.reservations.copies import Kept
from dray.protocol.traffic.reservations.district import TABLE_TICK
from dray.protocol.traffic.reservations.districts import Districts
from dray.protocol.traffic.reservations.impostors import Impostors
from dray.protocol.traffic.reservations.refused_removals import RefusedRemovals
from dray.protocol.traffic.traffic_map import TrafficMap

NOT_KEPT_HERE = "a message about a reservation table that is not kept here, perhaps of another plant file"

WITHOUT_TABLES = "a message about places, while this agent runs without right of way"

ABOUT_TABLES: tuple[type[Message], ...] = (
    PlaceRequested,
    TableReplicated,
    TableAcknowledged,
    TableAsked,
    TableReported,
)

REQUESTED_S = gone_s(WORKING_INTERVAL_S)
"""A vehicle whose newest request is younger than this counts as heard, even without heartbeats."""

NAMED_S = 300.0
"""Time for which a carried vehicle is listened to after people's last report: it may be put back anywhere."""

NOTE = "book "
"""Prefix, before the district, of a table's note in the journal; unchanged since earlier versions."""


@dataclass(frozen=True, slots=True)
class CarriedAway(Change):
    """People have carried a vehicle away, and their word was accepted."""

    vehicle: str


class ReservationHandling:
    """The reservation tables of one agent, or none.

    Args:
        me: the agent.
        plant: for keys, and for the agent's node.
        traffic: of the plant; None when vehicles drive without right of way.
        trusts: the people whose removals are accepted.
        subscriptions: the agent's subscriptions to heartbeats.
    """

    def __init__(
        self,
        me: str,
        plant: Plant,
        traffic: TrafficMap | None,
        trusts: Trusts,
        subscriptions: HeartbeatSubscriptions,
        life: Life,
    ) -> None:
        self._me = me
        self._plant = plant
        self._keys = Keys(plant.id)
        self._traffic = traffic
        self._subscriptions = subscriptions
        self._life = life
        self._neighbours = Neighbours()
        self._impostors = Impostors(life)
        self._authorisation = RemovalAuthorisation(plant, trusts, self._neighbours)
        self._refused = RefusedRemovals(life)
        self._followed: set[str] = set()
        """The vehicles whose heartbeats it subscribes to."""
        self._hears_all_since_s: float | None = None
        """Since when it listens to all vehicles; None when it does not."""
        self._named_s: dict[str, float] = {}
        """Vehicle -> when people last reported its removal."""
        self._written: dict[str, Kept] = {}
        self._outdated: list[str] = []
        """Districts that the agent no longer keeps since the plant file changed: their notes are to be deleted."""
        self._tables: Districts | None = None

    @property
    def keeps_tables(self) -> bool:
        """Whether this agent is a replica of any district."""
        return self._traffic is not None and any(
            self._me in replicas for replicas in self._traffic.places.replicas_of.values()
        )

    @property
    def tables(self) -> Districts | None:
        """The tables that it keeps; None before the start, or without tables."""
        return self._tables

    def awaited(self, now_s: float) -> tuple[str, ...] | UnsetType:
        """The awaited vehicles for the agent's heartbeat; unset when there are none."""
        if self._tables is None:
            return UNSET
        return tuple(sorted(self._tables.awaited(now_s))[:AWAITED_MAX]) or UNSET

    def start(self, memory: Memory, now_s: float, *, dock_answers: bool = False) -> None:
        """Start with the notes of an earlier run.

        Args:
            memory: its notes.
            now_s: the present time.
            dock_answers: whether the agent's dock makes itself safe.
        """
        if self.keeps_tables or dock_answers:
            self._life.subscribe(self._keys.removals)
        traffic = self._traffic
        if traffic is None or not self.keeps_tables:
            return
        kept = {
            name.removeprefix(NOTE): Kept(
                note.epoch, note.kept_epoch, note.version, note.reservations, note.removed, note.given_back
            )
            for name, note in memory.items()
            # A table with lines beyond its version, which earlier versions accepted from liars, counts as lost.
            if isinstance(note, TableMemory) and not line_beyond(note.reservations, note.version)
        }
        self._written = dict(kept)
        self._outdated = [name for name in kept if self._me not in traffic.places.replicas_of.get(name, ())]
        self._tables = Districts(
            self._me,
            traffic.places,
            traffic.atvs,
            kept,
            self._neighbours,
            self._impostors,
            self._keys.floor,
            self._life,
            traffic.is_signed,
        )
        self._tables.start(now_s)
        self._follow(now_s)

    @property
    def committers(self) -> tuple[Callable[[], list[Commit]], ...]:
        """Functions that return, after each step, what must be stored; none without tables."""
        return (self.commits,) if self.keeps_tables else ()

    def commits(self) -> list[Commit]:
        """The changed tables: they are stored before any message is sent."""
        if self._tables is None:
            return []
        commits: list[Commit] = []
        if self._outdated:
            commits = [Commit(None, NOTE + district) for district in self._outdated]
            self._outdated = []
        for district, table in self._tables.districts.items():
            kept, written = table.copies.kept, self._written.get(district)
            if written is kept or table.copies.lost:
                continue
            if written != kept:
                note = TableMemory(
                    kept.epoch,
                    kept.kept_epoch,
                    kept.version,
                    kept.reservations,
                    kept.removed,
                    kept.given_back,
                )
                commits.append(Commit(note, NOTE + district))
            self._written[district] = kept
        return commits

    # --- messages and alarms ---------------------------------------------------------------------

    def handlers(
        self, before: Mapping[type[Message], Callable[[str, Any, float], None]]
    ) -> dict[type[Message], Callable[[str, Any, float], None]]:
        """The agent's message handlers together with those for tables; both get heartbeats of vehicles."""
        table: dict[type[Message], Callable[[str, Any, float], None]] = dict(before)
        watches = before.get(AtvHeartbeat)
        table[AtvHeartbeat] = self._on_vehicle if watches is None else _both(self._on_vehicle, watches)
        table[Removals] = self._on_removals
        if self._traffic is None:
            table |= dict.fromkeys(ABOUT_TABLES, self._on_mixed_settings)
        elif self.keeps_tables:
            table |= dict.fromkeys(ABOUT_TABLES, self._on_message)
        return table

    @property
    def alarms(self) -> dict[str, Callable[[Any, float], None]]:
        """The handlers of its alarms."""
        return {TABLE_TICK: self._tick}

    def _on_removals(self, _sender: str, said: Removals, now_s: float) -> None:
        for removal in said.removals:
            if objection := self._remove(removal, now_s):
                self._life.ignore(objection)
                if self._keeps_for(removal, objection):
                    self._refused.refuse(removal, objection, now_s)
            else:
                self._refused.accept(removal)
        self._follow(now_s)

    def _remove(self, removal: Removal, now_s: float) -> str:
        """A person has carried a vehicle away, or puts it back. Returns why that is refused; empty when it is accepted."""
        atv = removal.atv
        objection = self._authorisation.objection(removal, self._since_s(atv, now_s), now_s)
        if self._tables is not None and objection in ("", TOO_EARLY):
            # The leader has listened for longer and may accept it; its table must not be refused here.
            self._tables.on_carried(atv)
        if objection:
            if objection in (TOO_EARLY, IS_HEARD, HEARD_SINCE):
                self._named_s[atv] = now_s
            return objection
        self._named_s[atv] = now_s
        districts = self._tables.districts.values() if self._tables is not None else ()
        spoke_s = max((district.spoke_s(atv) for district in districts), default=-NEVER_S)
        if now_s - spoke_s < REQUESTED_S:
            return IS_HEARD
        last = self._neighbours.last(atv)
        was_at = last.route[:1] if last is not None else ()
        # Without a table, a silent vehicle may be at this dock.
        nodes = was_at or (self._nodes_of(atv) if districts else (self._plant.node_of(self._me),))
        if not self._authorisation.covers(removal, nodes):
            return NOT_THERE
        named = (removal.life, removal.seq)
        self._neighbours.carry_away(atv, max(named, last.said) if last is not None else named)
        traffic = self._traffic
        place = traffic.places.place_of(removal.node) if traffic is not None and removal.node else ""
        for district in districts:
            district.remove(removal, place, now_s)
        self._life.note(CarriedAway(atv))
        self._life.settle(now_s)  # Before the next removal.
        return ""

    def _keeps_for(self, removal: Removal, objection: str) -> bool:
        """Whether a table here keeps a place for the vehicle, so that people wait for this agent to believe the report."""
        districts = self._tables.districts.values() if self._tables is not None else ()
        if any(district.names(removal.atv) for district in districts):
            return True
        if objection == NOT_TRUSTED or self._traffic is None:
            # Of names without a place anybody could invent ever more.
            return False
        if objection == NO_PLACE:
            return bool(districts)
        place = self._traffic.places.place_of(removal.node) if removal.node else ""
        return any(district.is_polling or district.has(place) for district in districts)

    def _nodes_of(self, atv: str) -> tuple[str, ...]:
        """The nodes among the places that a vehicle holds."""
        districts = self._tables.districts.values() if self._tables is not None else ()
        places = (line.place for district in districts for line in district.table.of(atv))
        return tuple(place for place in places if place in self._plant.nodes)

    def _on_message(self, sender: str, message: Any, now_s: float) -> None:
        if type(message) is PlaceRequested:
            if self._traffic is None or not self._traffic.is_signed(sender, message):
                self._impostors.tell(sender, now_s)
                return
        if self._tables is None or not self._tables.on_message(sender, message.district, message, now_s):
            self._life.ignore(NOT_KEPT_HERE)
        self._follow(now_s)

    def _on_vehicle(self, _sender: str, heartbeat: AtvHeartbeat, now_s: float) -> None:
        atv = heartbeat.atv
        if self._hears_all_since_s is None and atv not in self._followed:
            return
        is_news = self._neighbours.on_vehicle(heartbeat, now_s)
        if self._tables is None:
            return
        removal = heartbeat.floor.removal if heartbeat.floor is not UNSET else None
        self._tables.on_vehicle(atv, heartbeat.incarnation, removal, now_s, is_news=is_news)

    def _on_mixed_settings(self, _sender: str, _message: Message, _now_s: float) -> None:
        self._life.ignore(WITHOUT_TABLES)

    def _tick(self, district: str, now_s: float) -> None:
        if self._tables is not None:
            self._tables.tick(district, now_s)
            self._follow(now_s)

    # --- whom it listens to ----------------------------------------------------------------------

    def _since_s(self, atv: str, now_s: float) -> float:
        """Since when this agent would have heard the vehicle if it lived."""
        since_s = (self._neighbours.expected_since_s(atv), self._hears_all_since_s)
        return min((one_s for one_s in since_s if one_s is not None), default=now_s)

    def _follow(self, now_s: float) -> None:
        """Subscribe to the vehicles that the tables need, and to all vehicles while a recovery poll runs."""
        tables = self._tables.districts.values() if self._tables is not None else ()
        hears_all = any(district.is_polling for district in tables)
        if hears_all is not (self._hears_all_since_s is not None):
            self._hears_all_since_s = now_s if hears_all else None
            (self._subscriptions.follow if hears_all else self._subscriptions.unfollow)(EVERYBODY)
        if self._named_s:
            self._named_s = {atv: at_s for atv, at_s in self._named_s.items() if now_s - at_s < NAMED_S}
        wanted = set(self._named_s)
        for district in tables:
            wanted |= district.listens_to
        if wanted == self._followed:
            return
        for atv in sorted(self._followed - wanted):
            self._subscriptions.unfollow(atv)
            self._neighbours.forget(atv)
        for atv in sorted(wanted - self._followed):
            self._subscriptions.follow(atv)
            self._neighbours.expect(atv, now_s)
        self._followed = wanted


def _both(
    first: Callable[[str, Any, float], None], then: Callable[[str, Any, float], None]
) -> Callable[[str, Any, float], None]:
    def handle(sender: str, message: Any, now_s: float) -> None:
        first(sender, message, now_s)
        then(sender, message, now_s)

    return handle

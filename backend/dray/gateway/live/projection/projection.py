"""The whole projection: takes messages in and makes frames."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from msgspec import UNSET

from dray.gateway.live.frames import MANY, VIEWS, Delta, Snapshot
from dray.gateway.live.projection.agents.atvs import Atvs
from dray.gateway.live.projection.agents.disputes import Disputes
from dray.gateway.live.projection.agents.machines import BROKEN, DOWN, RESTING, Machines
from dray.gateway.live.projection.agents.outsiders import Outsiders
from dray.gateway.live.projection.agents.people import People
from dray.gateway.live.projection.agents.removals import Removals
from dray.gateway.live.projection.agents.silence import Silence, heard_until_s, plant_bound_s
from dray.gateway.live.projection.agents.stations import Stations
from dray.gateway.live.projection.agents.strategists import Strategists
from dray.gateway.live.projection.alerting import alert_rules, causes, wait_rules
from dray.gateway.live.projection.alerting.alerts import Alerts
from dray.gateway.live.projection.alerting.goods_rules import of_goods
from dray.gateway.live.projection.auctions.tasks import Tasks
from dray.gateway.live.projection.closures import Closures
from dray.gateway.live.projection.figures.fleet import BLOCKED, OUT_OF_SERVICE
from dray.gateway.live.projection.figures.interventions import Interventions
from dray.gateway.live.projection.figures.time_use import SILENT
from dray.gateway.live.projection.figures.traffic import Traffic
from dray.gateway.live.projection.injected_faults import InjectedFaults
from dray.gateway.live.projection.materials import Materials
from dray.gateway.live.projection.news import News, Present
from dray.gateway.live.projection.obstacles import Obstacles
from dray.gateway.live.projection.orders import Orders
from dray.gateway.live.projection.recent_commands import RecentCommands
from dray.gateway.live.projection.right_of_way.waits import Waits
from dray.gateway.live.projection.scenarios import Scenarios
from dray.gateway.live.projection.site import Site
from dray.gateway.live.timescale import TimeScale, WallWorkingTime
from dray.gateway.live.views import FactoryView, RemovalView, UseView
from dray.messages import (
    AtvHeartbeat,
    Event,
    MachineHeartbeat,
    Message,
    StationHeartbeat,
    StrategistHeartbeat,
)
from dray.messages.floor.obstacle import ObstacleCleared, ObstacleSeen
from dray.overload import Overload
from dray.plant import Plant
from dray.plant.model import PlantFile
from dray.protocol.liveness.suspicion import AnyHeartbeat
from dray.store.factory.exclusions import Exclusion
from dray.store.factory.kpis import KpiSample
from dray.store.factory.lane_traffic import LaneTraffic
from dray.store.history.clocks import Clocks, Timed

_Dated = Timed | StrategistHeartbeat
"""Messages that tell when they were sent."""


class Projection:
    """Everything that panels see.

    Args:
        plant: names and types of all agents and places.
        time: plant clock and wall clock.
        fault_injection: whether faults can be begun by hand.
        wall_s: wall clock to judge agents' times by; None to believe all of them.

    Attributes:
        plant: its id.
        site: the places of everything in the plant.
        kinds: the kinds of entities, by their field in a frame.
    """

    def __init__(
        self,
        plant: PlantFile,
        time: TimeScale,
        *,
        fault_injection: bool = False,
        wall_s: Callable[[], float] | None = None,
    ) -> None:
        self.plant, self._time, self._wall_s = plant.plant, time, wall_s
        self.outsiders, self.people, self.strategists = Outsiders(), People(), Strategists()
        self.removals = Removals()
        self.clocks, self.disputes, self._silence = Clocks(time.speed), Disputes(), Silence(time.speed)
        top_mps = max(kind.max_speed_mps for kind in plant.vehicle_types)
        self.atvs = Atvs(
            plant.fleet,
            plant.vehicle_types,
            time.to_wall_s,
            self.outsiders,
            self.removals,
            self.clocks,
            self._silence,
            top_mps,
        )
        self.site = Site(plant)
        self._told_plant: Plant | None = None
        """The plant at the last look at the figures; the site replaces it as a whole."""
        self._plant_at_s = 0.0
        self.materials = _materials(plant)
        self.machines = Machines(
            self.site, time.to_wall_s, self.outsiders, self.clocks, self._silence, self.materials
        )
        storages = self.site.plant.stores
        self.stations = Stations(storages, time.to_wall_s, self.outsiders, self.clocks, self._silence)
        self.stations.product_of = self.machines.product_of
        self.machines.name_of = self.stations.name_of = self._name_of
        self.orders = Orders(time.to_wall_s, self.site.products, self.materials)
        self.machines.due_of, self.machines.order_of = self.orders.due_of, self.orders.named
        self.tasks = Tasks(time.to_wall_s, self.orders.named)
        self.alerts, self.traffic, self.commands = Alerts(), Traffic(plant.lanes), RecentCommands()
        self.faults, self.scenarios = InjectedFaults(possible=fault_injection), Scenarios()
        self.closures, self.obstacles = Closures(), Obstacles(time.speed)
        self.news, self.waits = News(time.to_wall_s), Waits(time.to_wall_s)
        self.interventions, self._overload = Interventions(), Overload()
        self._on_fact = self._rooms_by_fact()
        self.kinds: Mapping[str, Any] = {collection: getattr(self, collection) for collection in VIEWS}
        self._all = tuple(kind.changes for kind in self.kinds.values())
        self.heard = 0
        """Messages that told something new."""
        self.ignored = 0
        """Messages that told nothing new: late, doubled, stale, or about something else. Normal."""

    @property
    def speed(self) -> float:
        """Factory seconds per real second."""
        return self._time.speed

    @property
    def changed(self) -> bool:
        """Whether anything changed since the last delta."""
        return any(self._all)

    def plant_s(self, wall_s: float) -> float:
        """A wall clock time on the plant's clock."""
        return self._time.to_plant_s(wall_s)

    def fold(self, message: Message) -> None:
        """Take one message in; never raises, whatever a peer sends."""
        now_s = delay_s = 0.0
        if isinstance(message, _Dated):
            now_s = message.at_s if self._wall_s is None else self._time.to_plant_s(self._wall_s())
        if self._wall_s is not None and isinstance(message, Timed):
            message = self.clocks.right(message, now_s)
            delay_s = now_s - message.at_s
        match message:
            case AtvHeartbeat():
                told = self._fold_atv(message, now_s, delay_s)
            case MachineHeartbeat():
                self.site.on_heartbeat(message)
                told = self.machines.fold(message, now_s)
                if told:
                    self._silence.note(message.machine, message, delay_s)
                    self.tasks.on_heartbeat(message)
                    self.orders.on_heartbeat(message)
            case StationHeartbeat():
                told = self.stations.fold(message, now_s)
                if told:
                    self._silence.note(message.station, message, delay_s)
                    self.tasks.on_heartbeat(message)
            case StrategistHeartbeat():
                told = self.strategists.fold(message, now_s)
            case Event():
                told = False
                for fold in self._on_fact.get(type(message.fact), ()):
                    told |= fold(message)
            case ObstacleSeen() | ObstacleCleared():
                told = self.obstacles.fold(message)
            case _:
                told = False
        self.heard += told
        self.ignored += not told

    def _fold_atv(self, message: AtvHeartbeat, now_s: float, delay_s: float) -> bool:
        before = self.atvs.last(message.atv)
        if not self.atvs.fold(message, now_s):
            return False
        self.waits.follow(self.atvs.last(message.atv) or message)
        self._silence.note(message.atv, message, delay_s)
        self.closures.on_heartbeat(message)
        self.traffic.follow(before, message)
        return True

    def _rooms_by_fact(self) -> Mapping[type, tuple[Callable[[Event], bool], ...]]:
        """Per kind of fact, all rooms that take it in: a waiting goal concerns tasks, orders and news."""
        rooms = self.tasks, self.orders, self.news, self.interventions, self.disputes
        folds: dict[type, tuple[Callable[[Event], bool], ...]] = {}
        for kinds, fold in (
            *((room.heeded, room.fold) for room in rooms),
            (Removals.heeded, self._on_removal),
        ):
            for kind in kinds:
                folds[kind] = *folds.get(kind, ()), fold
        return folds

    def _on_removal(self, event: Event) -> bool:
        self.atvs.mark(self.removals.fold(event))
        return False

    def show_removals(self, removals: Iterable[tuple[str, RemovalView]]) -> None:
        """Show these vehicles as carried away, and no others."""
        self.atvs.mark(self.removals.put(removals))

    def shut_out(self, exclusions: Iterable[Exclusion]) -> None:
        """Show these agents as shut out, and no others."""
        changed = self.outsiders.put(exclusions)
        self.atvs.mark(changed)
        self.machines.mark(changed)
        self.stations.mark(changed)

    def look(self, wall_s: float) -> list[str]:
        """Find what is wrong now; only this look detects silence.

        Returns:
            The alerts that have ended.
        """
        self.obstacles.look(wall_s)
        now = self._moment(wall_s)
        heard = [each for each in self.atvs.heartbeats() if each.atv not in self.outsiders]
        awaited = self._awaited(now)
        explained = {*awaited, *(each.atv for each in heard if each.atv in self.removals)}
        of_calls = tuple(alert_rules.of_calls(self.people.calls(now.plant_s), now))
        explained |= {each.agent for each in of_calls if each.kind == "atv_unplaced"}
        of_atvs = tuple(alert_rules.of_atvs(heard, explained, now))
        self.waits.look(self._is_heard(now), self.site.plant)
        machines = [each for each in self.machines.heartbeats() if each[0].machine not in self.outsiders]
        stations = [each for each in self.stations.heartbeats() if each.station not in self.outsiders]
        heard_there = {each.machine: each for each, _ in machines} | {each.station: each for each in stations}
        strategists = [
            each for each in self.strategists.heartbeats() if each.strategist not in self.outsiders
        ]
        clocks = {
            agent: offset for agent, offset in self.clocks.wrong(now.plant_s) if agent not in self.outsiders
        }
        wrong = (
            *alert_rules.of_the_plant(now),
            *alert_rules.of_demand(self._overload, self.tasks, len(heard), now),
            *alert_rules.of_outsiders(self.outsiders, self.atvs, self.site.plant.stores),
            *alert_rules.of_clocks(clocks.items()),
            *alert_rules.of_disputes(self.disputes, clocks.keys(), now),
            *alert_rules.of_strangers(self.atvs.strangers + self.machines.strangers),
            *alert_rules.of_machines(machines, self.materials, now),
            *alert_rules.of_stations(stations, now),
            *alert_rules.of_doubts(heard_there, self._name_of, now),
            *alert_rules.of_strategists(strategists, now),
            *of_calls,
            *of_atvs,
            *wait_rules.of_recovery_polls(awaited),
            *wait_rules.of_waits(self.waits, {each.agent for each in of_atvs}, now),
            *alert_rules.of_transports(self.tasks.under_way(), of_atvs),
            *of_goods(
                self.tasks.under_way(),
                self.people.calls(now.plant_s),
                self.people.on_duty(now.plant_s),
                self.site.plant.products,
                now,
            ),
            *alert_rules.of_orders(self.orders.in_trouble(wall_s), self.orders.impossible(), now),
        )
        self.news.look(self._present(now))
        return self.alerts.look(causes.gathered(wrong, now.speed), wall_s)

    def _name_of(self, item: str) -> str:
        """The name of a material or product."""
        product = self.site.plant.products.get(item)
        return self.materials.name(item) if product is None else product.name

    def _present(self, now: alert_rules.Moment) -> Present:
        """The state that no fact reports."""
        lasts: dict[str, AnyHeartbeat] = {last.atv: last for last in self.atvs.heartbeats()}
        lasts |= {last.machine: last for last, _ in self.machines.heartbeats()}
        lasts |= {last.station: last for last in self.stations.heartbeats()}
        there = {
            agent: last
            for agent, last in lasts.items()
            if agent not in self.outsiders and agent not in self.removals
        }
        return Present(
            wall_s=now.wall_s,
            last_s={agent: last.at_s for agent, last in there.items()},
            silent=frozenset(agent for agent, last in there.items() if now.is_lost(agent, last)),
            removals=self.removals.views(),
            closures=self.closures.views(),
            commands=self.commands.views(),
        )

    def working_of(self, machine: str) -> WallWorkingTime | None:
        """A machine's working time on the wall clock; None for one that never rests."""
        working_time = self.site.plant.working_time_of(machine)
        return None if working_time.is_always else WallWorkingTime(working_time, self._time)

    def traffic_at(self, wall_s: float) -> Iterator[LaneTraffic]:
        """Lanes that vehicles passed or waited on in the hour before this moment."""
        return self.traffic.lanes(self._present_s(wall_s, self._heard_until_s(wall_s)))

    def factory(self, wall_s: float) -> FactoryView:
        """The factory's figures now."""
        heard_s = self._heard_until_s(wall_s)
        now_s = self._present_s(wall_s, heard_s)
        orders, transports = self.orders, self.tasks.transports
        commands, helps = self.interventions.in_hour(now_s)
        use = self.atvs.fleet.use.hour(now_s)
        machines = self.machines.use.hour(now_s)
        return FactoryView(
            orders_open=orders.open,
            orders_delivered=orders.delivered,
            on_time_frac=orders.on_time / orders.delivered if orders.delivered else None,
            starved_frac=self.machines.starved_frac(now_s),
            transport_p50_s=transports.quantile_s(0.5),
            transport_p95_s=transports.quantile_s(0.95),
            empty_frac=self.atvs.fleet.empty_frac(now_s),
            use=UseView(**use) if use else None,
            atv_available_frac=_available(use),
            machine_available_frac=_part_up(machines),
            commands=commands,
            helps=helps,
            deliveries_per_hour=transports.per_hour(now_s),
            atvs_by_status=dict(+self.atvs.by_status),
            machines_by_status=dict(+self.machines.by_status),
            speed=self._time.speed,
            behind_s=(self._time.to_plant_s(wall_s) - heard_s) / self._time.speed,
            plant_at_s=self.plant_at_s(wall_s),
        )

    def plant_at_s(self, wall_s: float) -> float:
        """See `PlantPicture.plant_at_s`."""
        if self._told_plant is not self.site.plant:
            # Later than before, also where the clock stands or was set back.
            self._told_plant, self._plant_at_s = self.site.plant, max(wall_s, self._plant_at_s + 1e-3)
        return self._plant_at_s

    def totals(self, wall_s: float) -> KpiSample:
        """All totals since the plant's zero, with every agent's time counted up to now."""
        now_s = self._present_s(wall_s, self._heard_until_s(wall_s))
        fleet, machines, transports = self.atvs.fleet, self.machines.use, self.tasks.transports
        for use in (fleet.use, machines):
            use.settle(now_s)
        spent_s = {f"atv_{doing}_s": total_s for doing, total_s in fleet.use.totals_s.items()}
        spent_s |= {f"machine_{doing}_s": total_s for doing, total_s in machines.totals_s.items()}
        return KpiSample(
            at_s=wall_s,
            span_s=now_s,
            orders_delivered=self.orders.delivered,
            orders_on_time=self.orders.on_time,
            transports=transports.count,
            transport_p50_s=transports.quantile_s(0.5),
            transport_p95_s=transports.quantile_s(0.95),
            empty_m=fleet.empty_m,
            loaded_m=fleet.loaded_m,
            energy_wh=fleet.energy_wh,
            commands=self.interventions.commands,
            helps=self.interventions.helps,
            **spent_s,
        )

    def snapshot(self, number: int, wall_s: float, most: int | None = None) -> Snapshot:
        """The complete state; does not affect the next delta.

        Args:
            number: the frame's number.
            wall_s: the wall clock.
            most: maximum entities of each collection in `MANY`, first ones first; None for all.
        """
        return Snapshot(
            number=number,
            at_s=wall_s,
            plant=self.plant,
            factory=self.factory(wall_s),
            fault_injection=self.faults.possible,
            **{
                collection: kind.views(most) if collection in MANY else kind.views()
                for collection, kind in self.kinds.items()
            },
        )

    def delta(
        self, number: int, wall_s: float, factory: FactoryView | None, most: int | None = None
    ) -> Delta:
        """Changes since the last delta; of each collection in `MANY` at most `most`, the others next time."""
        if self.waits.is_stale:
            self.waits.look(self._is_heard(self._moment(wall_s)), self.site.plant)
        return Delta(
            number=number,
            at_s=wall_s,
            factory=factory,
            **{
                collection: kind.take_changed(most) if collection in MANY else kind.take_changed()
                for collection, kind in self.kinds.items()
            },
            gone=tuple(name for changes in self._all for name in changes.take_gone()),
        )

    def _moment(self, wall_s: float) -> alert_rules.Moment:
        now_s, heard_s = self._time.to_plant_s(wall_s), self._heard_until_s(wall_s)
        return alert_rules.Moment(
            now_s, heard_s, wall_s, self._time.speed, self._time.to_wall_s, self._silence
        )

    def _awaited(self, now: alert_rules.Moment) -> dict[str, set[str]]:
        """Vehicles whose answer reservation tables await -> the living keepers of those tables."""
        awaited: dict[str, set[str]] = {}
        keepers: list[tuple[str, MachineHeartbeat | StationHeartbeat]] = [
            *((last.machine, last) for last, _ in self.machines.heartbeats()),
            *((last.station, last) for last in self.stations.heartbeats()),
        ]
        for keeper, last in keepers:
            if last.awaits is UNSET or keeper in self.outsiders or now.is_lost(keeper, last):
                continue
            for atv in last.awaits:
                awaited.setdefault(atv, set()).add(keeper)
        return awaited

    def _is_heard(self, now: alert_rules.Moment) -> Callable[[str], bool]:
        """A test for vehicles that are neither lost nor shut out."""

        def is_heard(atv: str) -> bool:
            last = self.atvs.last(atv)
            return last is not None and atv not in self.outsiders and not now.is_lost(atv, last)

        return is_heard

    def _heard_until_s(self, wall_s: float) -> float:
        """Time up to which the plant was heard (plant clock)."""
        told_s = [each.at_s for each in self.atvs.heartbeats() if each.atv not in self.outsiders]
        machines = self.machines.heartbeats()
        told_s += [each.at_s for each, _ in machines if each.machine not in self.outsiders]
        stations = self.stations.heartbeats()
        told_s += [each.at_s for each in stations if each.station not in self.outsiders]
        return heard_until_s(told_s, self._time.to_plant_s(wall_s))

    def _present_s(self, wall_s: float, heard_s: float) -> float:
        """The plant's present (plant clock); where the plant is behind, the time up to which it was heard."""
        now_s = self._time.to_plant_s(wall_s)
        return now_s if now_s - heard_s <= plant_bound_s(self._time.speed) else heard_s

    def discard_changes(self) -> None:
        """Drop all changes while nobody watches: the next delta begins here."""
        for changes in self._all:
            changes.take_changed()
            changes.take_gone()


def _materials(plant: PlantFile) -> Materials:
    return Materials(
        {material.id: material.name for material in plant.materials},
        {product.id: [line.material for line in product.bill] for product in plant.products},
    )


def _part_up(use: Mapping[str, float]) -> float | None:
    """Fraction of machines' working time in which they were heard and not in error; None without any."""
    worked = 1.0 - use.get(RESTING, 0.0) if use else 0.0
    return 1.0 - sum(use[each] for each in (BROKEN, DOWN, SILENT)) / worked if worked > 0.0 else None


def _available(use: Mapping[str, float]) -> float | None:
    """Fraction of vehicles' time in service in which they could work; None without any."""
    in_service = 1.0 - use.get(OUT_OF_SERVICE, 0.0)
    return (in_service - use[BLOCKED] - use[SILENT]) / in_service if use and in_service > 0 else None

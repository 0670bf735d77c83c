"""A vehicle's heartbeat, composed from its parts."""

from __future__ import annotations

from typing import Protocol

from msgspec import UNSET, UnsetType

from dray.messages import NOTHING_KNOWN, AtvHeartbeat, AtvStatus, BodyWait, Link, LostWlan
from dray.protocol.closures.known_floor import KnownFloor
from dray.protocol.runtime.life import Life
from dray.protocol.vehicle.contracts import Contracts
from dray.protocol.vehicle.drivers.driver import Driver
from dray.protocol.vehicle.idle_positioning import IdlePositioning
from dray.protocol.vehicle.lost_memory import LostMemory
from dray.protocol.vehicle.people.command_handling import CommandHandling

WAIT_TOLD_S = 10.0
"""Minimum duration of a body's wait in the heartbeat (s): most waits end by themselves, and heartbeats stay short."""


class Vehicle(Protocol):
    """The vehicle's own facts beside its parts."""

    id: str
    incarnation: int
    battery_frac: float
    battery_reckoned: bool
    load: tuple[str, int]
    body_wait: BodyWait | None
    floor: KnownFloor

    @property
    def is_draining(self) -> bool:
        """Whether it was asked to leave."""
        ...


class StatusReport:
    """Composes a vehicle's heartbeats.

    Args:
        vehicle: the vehicle.
        software: the version it runs.
        driver, contracts, idle, commands, lost_memory: the vehicle's parts.

    Attributes:
        access_point: its modem's last WLAN access point; empty if unknown.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        software: str,
        driver: Driver,
        contracts: Contracts,
        idle: IdlePositioning,
        commands: CommandHandling,
        lost_memory: LostMemory,
        life: Life,
    ) -> None:
        self._vehicle = vehicle
        self._software = software
        self._driver = driver
        self._contracts = contracts
        self._idle = idle
        self._commands = commands
        self._lost_memory = lost_memory
        self._life = life
        self.access_point = ""
        self._lost: LostWlan | UnsetType = UNSET

    @property
    def status(self) -> AtvStatus:
        """The status that other agents see."""
        if self._commands.stopped:
            return AtvStatus.STOPPED
        if self._commands.assistance.problem:
            return AtvStatus.ERROR
        if self._contracts.job is not None:
            return AtvStatus.WORKING
        return AtvStatus.CHARGING if self._idle.charging else AtvStatus.IDLE

    def unfit(self, link: Link) -> str:
        """Why it may take no work at all; empty if it may. `link` is the link that it uses."""
        if self._commands.assistance.problem:
            return self._commands.assistance.problem
        if self._commands.stopped:
            return self._commands.stop_cause or "stopped by an operator"
        if link is Link.MESH:
            return "on the radio mesh"
        if self._commands.out_of_service is not None:
            return "out of service"
        if not self._driver.is_placed:
            return "the place where it stands is not its own yet"
        if self._vehicle.is_draining:
            return "draining"
        return "a load is on board" if self._contracts.job is None and self._vehicle.load[0] else ""

    def heartbeat(self, status: AtvStatus, link: Link, now_s: float) -> AtvHeartbeat:
        """The next heartbeat.

        Args:
            status: the status last reported.
            link: the link that it uses.
            now_s: the present time.
        """
        assistance = self._commands.assistance
        job, driver = self._contracts.job, self._driver
        return AtvHeartbeat(
            atv=self._vehicle.id,
            incarnation=self._vehicle.incarnation,
            seq=self._life.count_beat(),
            at_s=now_s,
            status=status,
            pose=driver.pose,
            node=driver.node,
            speed_mps=driver.speed_mps,
            battery_frac=self._vehicle.battery_frac,
            battery_reckoned=self._vehicle.battery_reckoned,
            load=self._vehicle.load[0],
            load_quantity=self._vehicle.load[1],
            left_empty=self._lost_memory.left_empty,
            task=job.brief() if job is not None else None,
            watches=self._contracts.standby.briefs() if self._contracts.standby else (),
            way=driver.ahead,
            dwell_point=self._idle.dwell_point,
            speed_limit_frac=driver.speed_frac,
            acknowledged=self._commands.acknowledged,
            link=link,
            lost_wlan=self._lost_wlan(link, now_s),
            problem=assistance.problem,
            about_problem=UNSET if assistance.about == NOTHING_KNOWN else assistance.about,
            body_wait=self._body_wait(now_s),
            help=assistance.help,
            software=self._software,
            draining=self._vehicle.is_draining,
            out_of_service=self._commands.out_of_service or UNSET,
            sent_to_charge=self._commands.is_sent_to_charge,
            in_reserve=self._idle.is_reserve(now_s),
            probation=self._contracts.probation.brief(),
            floor=driver.floor(now_s),
            closures=self._vehicle.floor.closures_known,
        )

    def _body_wait(self, now_s: float) -> BodyWait | UnsetType:
        wait = self._vehicle.body_wait
        return UNSET if wait is None or now_s - wait.since_s < WAIT_TOLD_S else wait

    def _lost_wlan(self, link: Link, now_s: float) -> LostWlan | UnsetType:
        """The loss of WLAN while only the radio works: every change of the link is told at once."""
        if link is Link.WLAN:
            self._lost = UNSET
        elif self._lost is UNSET:
            self._lost = LostWlan(since_s=now_s, access_point=self.access_point)
        return self._lost

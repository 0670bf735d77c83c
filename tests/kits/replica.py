"""One machine that keeps all tables of the default plant alone, and what is said to it."""

from __future__ import annotations

from typing import Any

from msgspec import UNSET
from msgspec.structs import replace

from dray.adapters.security.signing import SigningKey, TrustedKeys, is_signed
from dray.memory import Note, TableMemory
from dray.messages import AtvHeartbeat, AtvStatus, Message, Pose, Removal, Removals
from dray.messages.floor.traffic import PlaceGranted, PlaceRequested
from dray.messages.heartbeat import FloorBrief
from dray.messages.keys import Keys
from dray.plant import default_plant
from dray.protocol.liveness.failure_detector import HeartbeatSubscriptions
from dray.protocol.liveness.suspicion import IDLE_INTERVAL_S, gone_s
from dray.protocol.runtime.events import Effect, Ignore, Record, Send
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.places import Places
from dray.protocol.traffic.reservations.reservation_handling import NOTE, ReservationHandling
from dray.protocol.traffic.reservations.reservation_table import ReservationTable
from dray.protocol.traffic.traffic_map import TrafficMap

PLANT = default_plant()
KEY, FORGER = SigningKey(b"k" * 32), SigningKey(b"f" * 32)
GONE_S = gone_s(IDLE_INTERVAL_S)
DIED_S = 100.0
LATER_S = DIED_S + GONE_S + 1.0
AREA = next(iter(PLANT.areas))


PLACES = Places(PLANT, replicas=("M4",))
(DISTRICT,) = PLACES.replicas_of


def node_in(area: str, *, other: bool = False) -> str:
    return next(
        node.id
        for node in PLANT.nodes.values()
        if (area in PLANT.areas_at(node.x_m, node.y_m)) is not other and node.id in PLANT.stops
    )


HERE, ELSEWHERE = node_in(AREA), node_in(AREA, other=True)


class Replica:
    """One machine that keeps all tables of the plant alone."""

    def __init__(self, memory: dict[str, Note] | None = None, now_s: float = 0.0) -> None:
        traffic = TrafficMap(PLANT, is_signed)
        traffic.places = PLACES
        self.life = Life()
        self.out = self.life.effects
        self.reservations = ReservationHandling(
            "M4",
            PLANT,
            traffic,
            TrustedKeys(KEY.public),
            HeartbeatSubscriptions(Keys(PLANT.id).atv_heartbeat, self.life),
            self.life,
        )
        self.reservations.start(memory or {NOTE + DISTRICT: TableMemory(0, 0, 0)}, now_s)
        self.handlers = self.reservations.handlers({})

    def told(self, sender: str, message: Message, now_s: float) -> list[Effect]:
        self.life.effects.clear()
        self.handlers[type(message)](sender, message, now_s)
        return list(self.life.effects)

    def remove(self, now_s: float = LATER_S, **how: Any) -> list[str]:
        """Returns why it is not believed."""
        effects = self.told("gateway", Removals(removals=(word(**how),)), now_s)
        return [effect.reason for effect in effects if isinstance(effect, Ignore)]

    @property
    def table(self) -> ReservationTable:
        tables = self.reservations.tables
        assert tables is not None
        return tables.districts[DISTRICT].table

    def holder(self, place: str) -> str:
        return self.table.holder(place)

    def comes(self, atv: str, *places: str, now_s: float, seq: int = 7) -> None:
        """A vehicle asks for places, and is heard to be there."""
        self.told(atv, request(groups=tuple((place,) for place in places)), now_s)
        self.told(atv, beat(atv=atv, seq=seq), now_s)
        assert {self.holder(place) for place in places} == {atv}


def word(
    number: int = 1,
    *,
    key: SigningKey = KEY,
    areas: tuple[str, ...] | None = None,
    until_s: float = 1e6,
    heard: tuple[int, int] = (1, 7),
    node: str = "",
    atv: str = "A",
    reported_s: float | None = None,
    signed_s: float = LATER_S,
) -> Removal:
    """A person's report; without its time, as gateways of the last version say it, unless that is given."""
    removal = key.remove(
        atv,
        number,
        heard=heard,
        node=node,
        person="eve",
        areas=areas,
        reported_s=reported_s or 0.0,
        now_s=signed_s,
        valid_until_s=until_s,
    )
    return removal if reported_s is not None else replace(removal, reported=UNSET)


def request(
    *holds: str, removal: int = 0, life: int = 1, seq: int = 1, epoch: int = 0, **more: Any
) -> PlaceRequested:
    said: dict[str, Any] = {"seen": 0, "groups": (), **more}
    return PlaceRequested(
        district=DISTRICT,
        life=life,
        seq=seq,
        epoch=epoch,
        rank=(0, 0.0, "A"),
        holds=holds,
        stands=True,
        docked=False,
        removal=removal,
        **said,
    )


def beat(seq: int = 7, life: int = 1, removal: int = 0, node: str = HERE, atv: str = "A") -> AtvHeartbeat:
    return AtvHeartbeat(
        atv=atv,
        incarnation=life,
        seq=seq,
        at_s=0.0,
        status=AtvStatus.IDLE,
        pose=Pose(x_m=0.0, y_m=0.0, heading_rad=0.0),
        node=node,
        speed_mps=0.0,
        battery_frac=1.0,
        floor=FloorBrief(holds=(node,), removal=removal),
    )


def facts(effects: list[Effect], kind: type) -> list[Any]:
    return [effect.fact for effect in effects if isinstance(effect, Record) and isinstance(effect.fact, kind)]


def answers(effects: list[Effect]) -> list[PlaceGranted]:
    return [
        effect.message
        for effect in effects
        if isinstance(effect, Send) and isinstance(effect.message, PlaceGranted)
    ]
